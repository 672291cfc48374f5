# SPDX-License-Identifier: BSD-3-Clause
"""Setting the trocar while the controller runs: only at rest, and only to where the shaft is.

The shaft is in the true trocar while this is asked, so a point far from the shaft cannot be it. The
tolerance is never above the one that motion keeps: what is accepted here, the next command puts
right by itself as its first leg.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from rst_control.errors import InsertionOutOfRange
from rst_control.execution.event_log import EventKind
from rst_control.execution.snapshot import ControllerSnapshot
from rst_control.registration.registrar import ContextRegistrar, position_words, ready
from rst_control.registration.trocar_context import Origin, TrocarContext, TrocarOutOfReach
from rst_control.types import Cause, Measurement, Reason, Vector

FOLLOWED = "followed"  # tracking.trocar.motion
IS_FOLLOWED = Cause(
    Reason.NOT_THE_TROCAR,
    "the trocar is followed from its tracker (tracking.trocar.motion): that says where it is",
)


class TrocarRegistrar(ContextRegistrar):
    """Sets the active trocar, with all that depends on it, in one tick of the control loop."""

    COMMAND: ClassVar[str] = "set_trocar"
    SET: ClassVar[EventKind] = "trocar_set"
    REFUSED: ClassVar[EventKind] = "trocar_refused"

    def _place(self, context: TrocarContext) -> Vector:
        return context.trocar

    def _other(self, context: TrocarContext) -> tuple[float, ...]:
        scene = context.config.scene
        return (*scene.grasp_point, *scene.pull_direction)

    def _note(self, origin: Origin) -> None:
        self._present.trocar_origin = origin

    def _make(self, place: Sequence[float], view: ControllerSnapshot) -> TrocarContext | Cause:
        if self._present.current.config.controller.tracking.trocar.motion == FOLLOWED:
            return IS_FOLLOWED
        try:
            return self._present.current.with_trocar(place)
        except TrocarOutOfReach as error:
            return Cause(Reason.UNREACHABLE, str(error))

    def _decide(self, context: TrocarContext, view: ControllerSnapshot) -> Cause | str:
        measured = ready(context, view)
        return measured if isinstance(measured, Cause) else _decide_shaft(context, measured)


def _decide_shaft(context: TrocarContext, measured: Measurement) -> Cause | str:
    shaft, rcm = context.shaft(measured.position), context.config.rcm
    allowed = rcm.registration.tolerance
    words = f"shaft {shaft.error * 1e3:.3f} mm off it, allowed {allowed * 1e3:.3f} mm"
    words = f"trocar {position_words(context.trocar)}: {words}"
    if shaft.error > allowed:
        return Cause(Reason.NOT_THE_TROCAR, words)
    least, most = rcm.insertion
    if not least <= shaft.insertion <= most:
        depth = InsertionOutOfRange(shaft.insertion, least, most)
        return Cause(Reason.INSERTION_DEPTH, str(depth))
    return words
