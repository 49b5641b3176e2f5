"""What becomes of axes that are held when the rig is stopped, left alone, or cut off."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rig.commissioning.site import Site
from rig.commissioning.steps.reactions import Energy, Reacting, acts_within, put_back
from rig.hal import DeviceError
from rig.mechanisms.servo.commissioning.axes import ENABLED, Axes, energised

_KEPT = "a drive follows setpoints still"


class HeldAxes(Energy):
    """Axes under torque: they are safe when they follow nobody."""

    def __init__(self, axes: Axes) -> None:
        self._axes = axes
        self.bench = axes.bench
        self.questions_feed = any(servo.questions_feed for servo in axes.servos)

    @property
    def holders(self) -> Sequence[str]:
        """See `Energy.holders`."""
        return [servo.name for servo in self._axes.servos]

    def bring_up(self) -> None:
        """See `Energy.bring_up`."""
        self.bench.run(ENABLED)

    def has_gone(self) -> bool:
        """See `Energy.has_gone`."""
        return not any(servo.unsafe(self.bench.now) for servo in self._axes.servos)

    def asked_to_have_gone(self) -> str:
        """See `Energy.asked_to_have_gone`."""
        for servo in self._axes.servos:
            following = servo.follow_still()
            if following is None:
                return f"{servo.name} cannot tell whether it follows setpoints (follow_still)"
            if following:
                return f"{servo.name} follows setpoints still ({', '.join(following)})"
        return ""

    def without_cable(self, site: Site, bus: str) -> Callable[[], str]:
        """See `Energy.without_cable`; the drives are asked when it is back."""
        profile, bench = site.profile, self.bench
        after = acts_within(profile, self.holders) + profile.loop.safe_within
        bench.listen(after, lambda: False)
        put_back(site, self.rig, bus)
        wrong = self._asked_on(bus)
        return lambda: wrong and f"{wrong} without the cable"

    def _asked_on(self, bus: str) -> str:
        """Ask the drives whose cable is back, for a while: it is not back at once."""
        bench, end, wrong = self.bench, self.bench.now + 0.5, ""
        while bench.now < end:
            bench.listen(0.02, lambda: False)
            try:
                return self.asked_to_have_gone()
            except DeviceError as error:
                wrong = str(error)
        return wrong


@contextmanager
def _held(site: Site) -> Iterator[Energy]:
    with energised(site) as axes:
        yield HeldAxes(axes)


REACTING = Reacting(
    _held,
    "Every joint is held by its drive",
    "no drive follows setpoints any more",
    _KEPT,
)
"""Servo axes' part of the steps that take energy away."""
