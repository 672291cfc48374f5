# SPDX-License-Identifier: BSD-3-Clause
"""Which spoken words count at this moment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class WordRule:
    """When one spoken word counts; the controller checks the rest, such as limits."""

    phrase: str
    modes: frozenset[str]  # of the voice
    states: frozenset[str]  # of the controller
    is_tissue_held: bool | None  # that it needs; None: either


def words_that_count(
    rules: Sequence[WordRule], mode: str, state: str, is_tissue_held: bool
) -> tuple[str, ...]:
    """Phrases in the order of the rules.

    Args:
        rules: One for each spoken command.
        mode: Of the voice: standby or active.
        state: Of the controller.
        is_tissue_held: The jaws hold tissue.
    """
    return tuple(
        rule.phrase
        for rule in rules
        if mode in rule.modes
        and state in rule.states
        and rule.is_tissue_held in (None, is_tissue_held)
    )
