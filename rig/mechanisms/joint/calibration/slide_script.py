"""Slides and tugs of a joint that nobody leads: see `rig.mechanisms.joint.calibration.slides`."""

import math
from collections.abc import Generator, Iterator

from controllers.spherical_joint.geometry import PAIRS, SphericalJointGeometry
from controllers.spherical_joint.poses import Vector
from controllers.spherical_joint.types import (
    JointCommand,
    JointReference,
    JointState,
)
from rig.calibration.sequence import EstimatingController
from rig.config import format_quantity
from rig.mechanisms.joint.calibration.slides import GOAL, LATE, Release, Slides
from rig.mechanisms.joint.calibration.tugs import StrokesAndTugs, Tug, TugScript
from rig.mechanisms.joint.motion import PosedMotion

_UPRIGHT = (0.0, 0.0, 1.0)
_REST = (0.0, 0.0, 0.0)

_NEAR = 1e-3
"""A pair that stands nearer to upright stays there before a tug, m."""

_QUICK = 2.0
"""Before a tug the force rises so many times as fast: where exactly it ends does not matter."""

_SETTLED = 0.15
"""Before a stretch ends there is no force, s."""


class SlideScript(TugScript):
    """Does slides, and tugs between which a pair slides back upright; no controller leads the ring.

    Parameters
    ----------
    settings, still, controller, base, calm
        See `TugScript`; the motion stays at home, and of the controller only pushes are used.
    slides : Slides
        The slides of the settings.
    geometry : SphericalJointGeometry
        Where the wires lie.
    least : float
        Tension under which no wire is let, N.
    area : float
        Of a chamber, m².
    stiffness : float
        Of a wire, N/m.
    """

    def __init__(
        self,
        settings: StrokesAndTugs,
        still: PosedMotion,
        controller: EstimatingController[JointReference, JointState, JointCommand],
        base: float,
        calm: float,
        *,
        slides: Slides,
        geometry: SphericalJointGeometry,
        least: float,
        area: float,
        stiffness: float,
    ) -> None:
        self._slides, self._least, self._area = slides, least, area
        self._ways = [geometry.anchor_angles[one] for one, _ in PAIRS]
        self._late = [LATE, LATE]
        super().__init__(settings, still, controller, base, calm, give=0.5 / stiffness)

    def describe(self) -> Iterator[str]:
        """Yield what the slides are, and what comes after them."""
        slides = self._slides
        most, base, high = (
            format_quantity(value, unit)
            for value, unit in ((slides.most, "N"), (slides.base, "Pa"), (slides.highest, "Pa"))
        )
        yield f"upright, at {base} and then at up to {high}: {len(slides.slides)} times one pair is"
        yield f"pushed until it breaks away, with up to {most}, and slides some {2e3 * GOAL:g} mm;"
        yield "no controller leads the ring"
        yield from super().describe()

    def reference_at(self, t: float) -> JointReference:
        """Return the reference to stand upright."""
        return JointReference(_UPRIGHT, _REST, _REST, base_pressure=self._calm)

    def _begin(self) -> Iterator[JointCommand]:
        broke: list[float] = []
        for slide in self._slides.slides:
            base = self._slides.base
            if slide.again and broke:
                base = self._slides.second(sum(broke) / len(broke), self._least, self._area)
            release = yield from self._slid(
                slide.pair, slide.rise, slide.end, base, goal=GOAL, share=slide.share
            )
            if not slide.again and not math.isnan(release.broke):
                broke.append(release.broke)

    def _place_for(self, tug: Tug) -> Iterator[JointCommand]:
        half = 0.5 * self._settings.move
        for number, pair in enumerate((1 - tug.pair, tug.pair)):
            start = tug.start + number * half
            if abs(self._place_of(pair)) > _NEAR:
                yield from self._slid(pair, start, start + half, self._calm, goal=0.0, pace=_QUICK)
        while self.t < tug.start + self._settings.move:
            yield self._pushed(tug.pair, 0.0, self._calm, _UPRIGHT)

    def _catch(self, tug: Tug, force: float) -> Iterator[JointCommand]:
        while self._is_at(tug):
            back = 0.5 * tug.side * force if self.t < tug.end - _SETTLED else 0.0
            yield self._pushed(tug.pair, -back, self._calm, _UPRIGHT)

    def _slid(
        self,
        pair: int,
        rise: float,
        end: float,
        base: float,
        *,
        goal: float,
        share: float = 1.0,
        pace: float = 1.0,
    ) -> Generator[JointCommand, None, Release]:
        """Let a pair slide; return its `Release`."""
        release, axis = Release(self._place_of(pair), self._late[pair], goal, share), _UPRIGHT
        while self.t < end:
            force = 0.0
            if self.t < rise:  # from where all stands still
                release = Release(self._place_of(pair), self._late[pair], goal, share)
                axis = self._without(pair)
            elif self.t < end - _SETTLED:
                risen = self._slides.risen(pace * (self.t - rise))
                broken = self._broken(risen)
                force = release.force(self.t, self._place_of(pair), risen, broken)
            yield self._pushed(pair, force, base, axis)
        self._late[pair] = release.late(self._place_of(pair))
        return release

    def _without(self, pair: int) -> Vector:
        """Return where the ring points, with one pair upright.

        Tensions that balance where the other one stands keep it there: while the ring slides one
        way its seat does not hold it across.
        """
        x, y, _ = self._axis()
        cosine, sine = math.cos(self._ways[pair]), math.sin(self._ways[pair])
        along = x * cosine + y * sine
        x, y = x - along * cosine, y - along * sine
        return (x, y, math.sqrt(1.0 - x * x - y * y))

    def _pushed(self, pair: int, force: float, base: float, axis: Vector) -> JointCommand:
        push = (force, 0.0) if pair == 0 else (0.0, force)
        return self.follow(JointReference(axis, _REST, _REST, base_pressure=base, push=push))
