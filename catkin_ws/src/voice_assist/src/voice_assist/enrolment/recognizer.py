# SPDX-License-Identifier: BSD-3-Clause
"""The recogniser with one person's weights in place of some of the base's."""

from __future__ import annotations

import copy

from torch import Tensor

from voice_assist.recognizer.embedded import EmbeddedRecognizer


class PersonalRecognizer(EmbeddedRecognizer):
    """As the base, and as quick; the base it was made of stays as it is."""

    def __init__(
        self,
        base: EmbeddedRecognizer,
        state: dict[str, Tensor],
        profile: str = "",
        digest: str = "",
    ) -> None:
        """Copy the base and change it.

        Args:
            base: With a CTC head.
            state: Adapted tensors by their name in HybridWhisper.
            profile: Name of whose they are.
            digest: SHA-256 of that profile.
        """
        self.__dict__.update(vars(base))
        self.model = copy.deepcopy(base.model)
        self.model.load_state_dict(state, strict=False)
        self.model.eval()
        self._newest = None  # what the base heard last was encoded by the base
        self.profile, self.profile_digest = profile, digest
