"""What is added to a planned posture in each cycle: against the servos' sag, and for balance."""

from controllers.gait.plan import GaitPlan
from controllers.gait.sag import sag_offsets
from controllers.gait.stabiliser import Stabiliser
from controllers.gait.types import GaitModel, Joints, LegsCommand, LegsState


class Corrections:
    """The corrections that a model asks for; without any a command is passed on as it is.

    Parameters
    ----------
    model : GaitModel
        What the law is told of the legs.
    period : float
        The loop's, s.
    """

    def __init__(self, model: GaitModel, period: float) -> None:
        self._sag = model.sag
        self._period = period
        self._stabiliser = (
            None
            if model.stabiliser is None
            else Stabiliser(model.stabiliser, model.geometry, model.balance, period)
        )
        self._are_any = self._sag is not None or self._stabiliser is not None
        self._offsets: list[list[float]] = []
        self._samples = 0
        self._sample = 0
        self._added: Joints | None = None

    @property
    def feels(self) -> bool:
        """Whether any of them depends on what the legs feel."""
        return self._stabiliser is not None

    @property
    def doubt(self) -> str:
        """Why balance is not corrected any more; empty: it is, or never was."""
        return "" if self._stabiliser is None else self._stabiliser.doubt

    def prepare(self, plan: GaitPlan) -> None:
        """Take the plan that is to be corrected."""
        self._samples = len(plan.t)
        if self._sag is not None:
            self._offsets = sag_offsets(plan, self._sag).tolist()
        if self._stabiliser is not None:
            self._stabiliser.prepare(plan)

    def reset(self) -> None:
        """Begin with the plan's first sample."""
        self._sample = 0
        self._added = None
        if self._stabiliser is not None:
            self._stabiliser.reset()

    def apply(self, command: LegsCommand, state: LegsState) -> LegsCommand:
        """Return a planned command as it is to be sent; called once for each sample of the plan."""
        if not self._are_any:
            return command
        sample = min(self._sample, self._samples - 1)
        self._sample += 1
        planned = joints = command.positions
        if self._offsets:
            joints = tuple([q + s for q, s in zip(joints, self._offsets[sample], strict=True)])
        if self._stabiliser is not None:
            joints = self._stabiliser.correct(sample, joints, state)
        added = tuple([a - b for a, b in zip(joints, planned, strict=True)])
        before, self._added = self._added or added, added
        rates = [
            rate + (now - then) / self._period
            for rate, now, then in zip(command.velocities, added, before, strict=True)
        ]
        return LegsCommand(joints, tuple(rates))
