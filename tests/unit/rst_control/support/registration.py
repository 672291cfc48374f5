# SPDX-License-Identifier: BSD-3-Clause
"""A rig with somebody who sets a point of it: the trocar, or where to grasp."""

import numpy as np


class Setting:
    """What is asked for, and what the executor shows of it."""

    refusal = ("", "")  # kind of the event, and its command

    def __init__(self, rig, registrar):
        self.rig, self.registrar = rig, registrar(rig.context, rig.executor)

    @property
    def point(self):
        """The point that is set now [m]."""
        raise NotImplementedError

    def ask(self, point):
        answer = self.registrar.ask(point, "/test")
        self.rig.tick()
        return answer.result(0)

    def refused(self, point):
        """Ask for what must be refused; returns the reason."""
        before = self.rig.context.current
        reply = self.ask(point)
        assert not reply.accepted, reply.message
        assert self.rig.context.current is before
        entry = self.rig.executor.events[-1]
        assert (entry.kind, entry.command) == self.refusal
        assert reply.message in entry.message and "/test" in entry.message
        return reply.message

    def accepted(self, point):
        """Ask for what must be set."""
        reply = self.ask(point)
        assert reply.accepted, reply.message
        np.testing.assert_allclose(self.point, point, atol=1e-15)
        return reply.message
