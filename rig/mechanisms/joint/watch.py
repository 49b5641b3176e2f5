"""What is watched of the spherical joint while it moves, and what is a fault."""

import math
from collections.abc import Sequence

from controllers.spherical_joint.geometry import PAIRS, Quadruple
from controllers.spherical_joint.poses import Vector, tilt_of
from controllers.spherical_joint.types import CameraSample, JointState
from rig.hal import DeviceFault, LimitExceeded, SafetyError
from rig.hal.quantities import Margin
from rig.mechanisms.joint.alarms.camera import MarkerWatch
from rig.mechanisms.joint.alarms.wires import WireLimits, WireWatch
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.pulls import pull_balance
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.alarms.bounds import derive_bounds
from rig.mechanisms.pneumatic.alarms.pressures import PressureOff, PressureWatch
from rig.mechanisms.pneumatic.alarms.scatter import explain_scatter
from rig.mechanisms.pneumatic.alarms.tracking import Shifted, Strayed
from rig.mechanisms.pneumatic.alarms.unheld import explain_unheld
from rig.mechanisms.pneumatic.alarms.work import WorkWatch

_SPEED_WINDOW = 0.01
"""Speeds are judged over this time, s: over one cycle, an encoder step would look fast."""
_POSE_EVERY = 4
"""The pose is worked out for the checks every so many cycles: faults last longer."""
_JUMP = 0.3
"""A rod that runs was at this share of its speed a cycle before; an encoder that jumps was not."""


class JointWatch:
    """Checks each state of the joint and names what is broken.

    Parameters
    ----------
    settings : JointSettings
        Geometry, limits and alarms.
    regulators : str
        Name of the regulators, for messages.
    encoders : sequence of str
        Names of the encoders of ch1 … ch4, for messages.
    camera : str, optional
        Name of the camera, for messages.
    """

    def __init__(
        self,
        settings: JointSettings,
        regulators: str,
        encoders: Sequence[str],
        camera: str | None,
    ) -> None:
        limits, alarms, friction = settings.limits, settings.alarms, settings.friction
        self._limits = limits
        self._most_tilt = limits.tilt + limits.tilt_excess
        self._marker = settings.geometry.marker
        self._encoders = tuple(encoders)
        self._give = settings.area / settings.wire_stiffness
        self.pressures = PressureWatch(
            derive_bounds(alarms.pressure, settings),
            settings.regulator_response,
            CHANNELS,
            regulators,
            settings.feeder,
        )
        self._wires = WireWatch(
            settings.geometry,
            WireLimits(
                limits.residual,
                limits.grace,
                settings.home,
                settings.stroke,
                0.5 * friction.breakaway / settings.area,
            ),
            alarms.frozen,
            encoders,
            CHANNELS,
        )
        self._work = WorkWatch(
            alarms.swapped, settings.area, friction.coulomb, encoders, CHANNELS, PAIRS
        )
        self._balance = pull_balance(settings, regulators)
        self._camera = (
            None
            if camera is None
            else MarkerWatch(camera, limits.disagreement, limits.grace, alarms.twist, encoders)
        )
        self._cycle = 0
        self._speed_from: tuple[float, Quadruple] | None = None
        self._last: Quadruple = (0.0,) * 4
        self._before: Quadruple = (0.0,) * 4
        self._step = self._then = 0.0

    def compile(self) -> None:
        """Make it fast; see `WireWatch.compile`."""
        self._wires.compile()

    def restart(self) -> None:
        """Forget where the rods were: a new motion starts."""
        self._speed_from = None
        self._balance.restart()

    def send(self, setpoints: Sequence[float]) -> None:
        """Take the setpoints that the regulators get in this cycle, Pa gauge."""
        self.pressures.send(setpoints)

    def axis_of(self, state: JointState) -> Vector:
        """Return the axis that the rods show; the last one known if they fit no pose."""
        return self._wires.axis_of(self._unstretched(state))

    def check(self, state: JointState, now: float) -> None:
        """Raise if the state is not safe.

        Raises
        ------
        SafetyError
            A reading is not a number, or something is broken: its name is in the message.
        LimitExceeded
            A rod is too fast or the tilt too great.
        """
        _, rods, pressures, sample = state
        if not math.isfinite(sum(rods) + sum(pressures)):
            raise SafetyError(f"a reading is not a number: {state}")
        self._before, self._last = self._last, rods
        self._step, self._then = now - self._then, now
        self.pressures.check(pressures, now)
        self._balance.note(now, rods, pressures)
        self._wires.follow(rods, now)
        self._check_speed(rods, now)
        self._cycle += 1
        if self._cycle % _POSE_EVERY == 0:
            unstretched = self._unstretched(state)
            self._work.check(rods, pressures, lambda: self._wires.explain_swap(unstretched))
            self._wires.check(rods, unstretched, pressures, now)
            unseen = self._balance.explain_unseen()
            if unseen is not None and self._wires.agree(unstretched):
                scatters = explain_scatter(self._encoders, self._balance.rods)
                raise SafetyError(f"{scatters} ({unseen})" if scatters else unseen)
            if self._camera is not None:
                self._check_camera(self._camera, sample, now)
            tilt = tilt_of(self._wires.axis)
            if tilt > self._most_tilt:
                raise LimitExceeded("tilt of the ring", tilt, 0.0, self._most_tilt, "rad")

    def explain(self, error: Exception, state: JointState) -> Exception:
        """Return an error of a device or limit with the cause that the rest of the rig shows.

        Parameters
        ----------
        error : Exception
            What was found first.
        state : JointState
            Of the cycle in which it was.
        """
        if isinstance(error, PressureOff):
            cause = explain_scatter(self._encoders, self._balance.rods)
            # No chamber makes rods disagree, and those that do throw the ring and shake setpoints.
            cause = cause or self._wires.suspicion(
                state.rods, self._unstretched(state), state.pressures
            )
            return error if cause is None else SafetyError(f"{cause} ({error})")
        if isinstance(error, Strayed):
            return self._explain_strayed(error, state)
        if not self._cycle and (cause := explain_unheld(error, self._encoders, "the ring")):
            return SafetyError(f"{cause} ({error})")
        k = self._running_rod(error, state.rods)
        if k is None:
            return error
        if isinstance(error, DeviceFault):  # this cycle's state was not checked
            state = self._gone_on(state)
        rods = self._unstretched(state)
        cause = self._wires.explain_run(rods, state.pressures, k)
        if cause is None and isinstance(error, LimitExceeded):
            cause = self._balance.explain()
        cause = cause or self.pressures.suspicion()
        if cause is None and isinstance(error, Shifted) and (error.ran or self._wires.agree(rods)):
            number, off = _pair_of(error.rod, error.value)
            cause = self._balance.explain_gone(off, number)
        if cause is None and isinstance(error, DeviceFault):
            emptied = self._balance.explain_emptied(_number_of(k))
            cause = emptied or self._explain_push(k, rods)
        return error if cause is None else SafetyError(f"{cause} ({error})")

    def _gone_on(self, state: JointState) -> JointState:
        """Return a state whose rods go on as they ran where no new reading of them was taken.

        A reading that was refused is missing of one rod alone: it seems to stay behind the others.
        """
        gone = [
            rod if rod != last else 2.0 * last - before
            for rod, last, before in zip(state.rods, self._last, self._before, strict=True)
        ]
        return state._replace(rods=(gone[0], gone[1], gone[2], gone[3]))

    def _explain_push(self, k: int, rods: Quadruple) -> str | None:
        """Return that rod `k` did not run alone; None: it did."""
        if self._wires.agree(rods):
            return "the ring was pushed or struck: all rods move with it"
        if self._runs_with(k):
            return "the ring was pushed or struck: other rods run with it"
        return None

    def _explain_strayed(self, error: Strayed, state: JointState) -> Exception:
        """Return why a rod is not where it should be."""
        rods = self._unstretched(state)
        cause = self._wires.explain_run(rods, state.pressures, error.rod) if error.ran else None
        cause = cause or self._balance.explain() or self.pressures.suspicion()
        number, off = _pair_of(error.rod, error.value)
        if cause is None:
            cause = self._balance.explain_strayed(off, number, ran=error.ran, lasted=error.lasted)
        if cause is None and error.offs:  # of the other pair: the ring slides on without it
            one, opposite = PAIRS[1 - number]
            off = 0.5 * (error.offs[one] - error.offs[opposite])
            if abs(off) > 0.5 * self._limits.following:
                cause = self._balance.explain_off(off, 1 - number)
        return error if cause is None else SafetyError(f"{cause} ({error})")

    def drives(self, rod: int, off: float) -> bool:
        """Return whether a pair's own pressures pull a rod to where it is off its reference, m."""
        number, off = _pair_of(rod, off)
        return self._balance.drives(off, number)

    def explain_held(self) -> str | None:
        """Return why a pair sticks whose pressures should move it; None: they need not."""
        return self._balance.explain(sticks=True)

    def margins(self) -> tuple[Margin, ...]:
        """Return how far each quantity that is watched is from its limit."""
        limits = self._limits
        tilt = tilt_of(self._wires.axis)
        return (
            Margin("tilt", 1.0 - tilt / self._most_tilt),
            Margin("wire agreement", 1.0 - self._wires.residual / limits.residual),
        )

    def _running_rod(self, error: Exception, rods: Quadruple) -> int | None:
        """Return which rod runs too fast, if that is the error and no encoder just jumped."""
        if isinstance(error, LimitExceeded):
            ways = [rod - before for rod, before in zip(rods, self._before, strict=True)]
            return max(range(4), key=lambda k: abs(ways[k]))
        if not isinstance(error, DeviceFault) or error.device not in self._encoders:
            return None
        k = self._encoders.index(error.device)
        # This cycle's state was not checked: the device said first that it is wrong, and may
        # hold its last good reading.
        way, way_before = rods[k] - self._last[k], self._last[k] - self._before[k]
        fast = max(abs(way), self._limits.speed * self._step)
        return k if abs(way_before) > _JUMP * fast else None

    def _runs_with(self, k: int) -> bool:
        """Return whether another rod ran as well, in the last cycle that was checked."""
        fast = _JUMP * self._limits.speed * self._step
        ways = [rod - before for rod, before in zip(self._last, self._before, strict=True)]
        return any(abs(way) > fast for i, way in enumerate(ways) if i != k)

    def _check_speed(self, rods: Quadruple, now: float) -> None:
        if self._speed_from is None:
            self._speed_from = (now, rods)
            return
        then, before = self._speed_from
        if now - then < _SPEED_WINDOW:
            return
        bound = self._limits.speed
        for name, rod, was in zip(CHANNELS, rods, before, strict=True):
            speed = (rod - was) / (now - then)
            if abs(speed) > bound:
                raise LimitExceeded(f"speed of the rod of {name}", speed, -bound, bound, "m/s")
        self._speed_from = (now, rods)

    def _check_camera(self, watch: MarkerWatch, sample: CameraSample | None, now: float) -> None:
        watch.take(self._marker(self._wires.axis), now)
        if sample is None:
            return
        watch.check(sample)
        if sample.twist is not None:
            watch.check_twist(sample.twist, sample.t)

    def _unstretched(self, state: JointState) -> Quadruple:
        """Return the rods less what the wires stretch under the measured pressures."""
        give = self._give
        (a, b, c, d), (p, q, r, s) = state.rods, state.pressures
        return a - give * p, b - give * q, c - give * r, d - give * s


def _number_of(rod: int) -> int:
    """Return the number of a rod's pair."""
    return next(k for k, pair in enumerate(PAIRS) if rod in pair)


def _pair_of(rod: int, off: float) -> tuple[int, float]:
    """Return the number of a rod's pair, and how far the pair is off if the rod is, m."""
    number = _number_of(rod)
    return number, off if rod == PAIRS[number][0] else -off
