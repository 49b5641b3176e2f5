"""The pneumatic side of the spherical joint."""

import dataclasses
import math
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from controllers.cylinder.types import PairReference
from controllers.spherical_joint.geometry import PAIRS
from controllers.spherical_joint.poses import natural_rotation
from controllers.spherical_joint.tension import TensionDistribution
from controllers.spherical_joint.types import JointCommand, JointEstimate, JointReference
from rig.assembly import plan_motion
from rig.calibration.arrays import Array, between_rows
from rig.calibration.profile_changes import profile_with, with_wider_limits
from rig.calibration.recording import Stretch
from rig.config import Profile, format_quantity
from rig.hal.motion import Motion
from rig.mechanisms.joint.calibration.leaning import Leaning
from rig.mechanisms.joint.first_gains import with_placing_law
from rig.mechanisms.joint.motion import PosedMotion
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.pneumatic.calibration.pneumatics import Limit, Pneumatics
from rig.mechanisms.pneumatic.calibration.smoothing import PairSignals

_ZERO: Final = (0.0, 0.0, 0.0)
_BETWEEN: Final = 0.25 * math.pi
"""Azimuth between the pairs, rad: leaning there moves all rods."""

_CASCADE: Final = {"position_rate": 97.5, "velocity_rate": 344.0, "integral": 7.5e4}
"""Greatest gains of a cascade that slides the pairs on quick regulators: rad/s, rad/s, N/(m s)."""

_LATE: Final = 0.7
"""Phase that dead time takes of the position loop of that cascade, rad, beyond which its integrals
are ahead of the air: at rest they throw a ring that seals do not hold."""

_STICKY: Final = 1.2
"""Breakaway over Coulomb friction of seals that hold it, and need these integrals to let go: 1.46
of standard ones, 1.04 of low-speed ones."""

_CALM: Final = 0.3
"""Share of the profile's own integral where they do not. What holds a falling ring are the other
gains: with 0.7 of them it falls more often."""

_GENTLE_PRESSURE: Final = 120e3
"""Greatest base pressure under which a ring that leans is moved, Pa gauge.

The more the wires pull, the faster the ring falls on, until no regulator can follow."""

_CHECKED: Final = 0.75
"""Of the permitted tilt that is used: the rods may not know it yet."""

_RESIDUAL: Final = 8e-3
_DISAGREEMENT: Final = 60e-3
"""Of the rods, and of camera and rods, before they have been calibrated, m.

At half a metre 2 degrees about every axis of the camera make 25 mm, and 2 % of all lengths as much
again."""

_FOLLOWING: Final = 0.3
"""How far a rod may be off its reference, over the stroke: what is measured is where it is, not
where it should be. On slow regulators a ring with standard seals sticks, then slips."""

_SWING: Final = 0.1
"""What counts as a swing about the reference, over the stroke."""

_WITHIN: Final = 0.99
"""Share of the stroke, beyond which no disagreement is: a limit there is refused."""

_ABSENCE: Final = 30.0
_AREA: Final = 0.9
"""For how long the rays of a camera with a wrong pose may pass by the marker's sphere, s, and by
which share a marker's area may be off: its tilt follows from that pose."""

_FEW_SIGHTINGS: Final = 1.2
_FEW_RESIDUAL: Final = 4e-3
"""The same absence (s) and the rods' residual (m) where the camera is what is looked for: too many
frames must not be lost."""

_POSE_EVERY: Final = 10
"""Samples between two poses for which the distribution of tensions is worked out."""


class JointPneumatics(Pneumatics[JointReference, JointCommand]):
    """The pneumatic side of a joint."""

    locked_share = 0.75
    still = JointReference((0.0, 0.0, 1.0), _ZERO, _ZERO)
    no_estimate = JointEstimate(_ZERO, _ZERO, 0.0, (0.0,) * 4, (0.0,) * 4)
    command = JointCommand

    def __init__(self, profile: Profile) -> None:
        self.settings: JointSettings = profile.mechanism_settings
        super().__init__(profile)
        homes = (self.settings.home + offset for offset in self.settings.wire_offsets)
        self._homes = dict(zip(self.channels, homes, strict=True))

    @property
    def encoders(self) -> tuple[str, ...]:
        """See `Pneumatics.encoders`."""
        return tuple(self.settings.encoders)

    def extension(self, stretch: Stretch, channel: str) -> Array:
        """See `Pneumatics.extension`; the log says how far a rod is pulled in from home."""
        return np.asarray(self._homes[channel] - stretch[f"reading.rod_{channel}"])

    def rods(self, stretch: Stretch) -> Array:
        """Return how far each rod is pulled in, m, shape (n, 4)."""
        return np.column_stack([stretch[f"reading.rod_{c}"] for c in self.channels])

    def pulls(self, stretch: Stretch) -> Array:
        """Return the pull of each chamber, N, shape (n, 4)."""
        pressures = np.column_stack([stretch[f"reading.pressure_{c}"] for c in self.channels])
        return np.asarray(self.area * pressures)

    def signals(self, stretch: Stretch, axis: Array | None = None) -> list[PairSignals]:
        """Return what both pairs did in a stretch.

        A pair moves the ring with more than the difference of its own two tensions wherever the
        ring leans; see `controllers.spherical_joint.tension`.

        Parameters
        ----------
        stretch : Stretch
            What was recorded.
        axis : ndarray, shape (n, 3), optional
            Of the ring; if it is not given, as the controller made it out from the rods.
        """
        pull, rods = self.pulls(stretch), self.rods(stretch)
        if axis is None:
            marker = np.column_stack([stretch[f"estimate.encoder_marker_{n}"] for n in "xyz"])
            axis = marker / np.linalg.norm(marker, axis=1)[:, None]
        at = TensionDistribution(self.settings.geometry).at
        places = np.arange(0, len(axis), _POSE_EVERY)
        poses = [at(natural_rotation((x, y, z))) for x, y, z in axis[places].tolist()]
        found = []
        for number, (one, other) in enumerate(PAIRS):
            rows = np.array([(pose.first, pose.second)[number] for pose in poses])
            weights = between_rows(rows, places, np.arange(len(axis)))
            force = (weights * pull).sum(axis=1)
            position = 0.5 * (rods[:, one] - rods[:, other])
            load = pull[:, one] + pull[:, other]
            found.append(PairSignals(f"pair {one + 1}-{other + 1}", force, position, load))
        return found

    def _pressures(self) -> tuple[float, float]:
        low, high = self.settings.limits.pressure
        least, most = self.settings.limits.tension
        return max(low, least / self.area), min(high, most / self.area)

    def limits_in_force(self) -> Iterator[Limit]:
        """See `Pneumatics.limits_in_force`."""
        limits = self.settings.limits
        yield "speed", limits.speed, "m/s"
        yield "pressure", limits.pressure, "Pa"
        yield "tilt", limits.tilt, "rad"
        yield "tension", limits.tension, "N"

    def with_wider_limits(self, pair: float = 0.0) -> tuple[Profile, tuple[str, ...]]:
        """See `Pneumatics.with_wider_limits`; rods and camera agree only once calibrated."""
        return self._with_wider(_RESIDUAL, _ABSENCE)

    def with_limits_for_sightings(self) -> tuple[Profile, tuple[str, ...]]:
        """Return the profile with limits for a wrong camera and geometry, and notes on them."""
        profile, notes = self._with_wider(_FEW_RESIDUAL, _FEW_SIGHTINGS)
        # A wrong geometry turns the work of a pair round as swapped encoders do, by less.
        profile = profile_with(profile, {f"{profile.mechanism}.alarms.swapped.share": 1.0})
        return profile, (*notes, "alarms.swapped.share is 1")

    def _with_wider(self, residual: float, absence: float) -> tuple[Profile, tuple[str, ...]]:
        """Return the profile with wider limits: of the rods' residual, m, and a blind camera, s."""
        stroke = self.settings.stroke
        least = {
            "residual": residual,
            "disagreement": min(_DISAGREEMENT, _WITHIN * stroke),
            "following": _FOLLOWING * stroke,
        }
        run_off = {f"{self.profile.mechanism}.limits.run_off": self.settings.limits.most_run_off}
        usual_runs = profile_with(self.profile, run_off)
        profile, notes = self.with_unknown_response(*with_wider_limits(usual_runs, least))
        usual, swing = self.settings.alarms.oscillation.amplitude, _SWING * stroke
        if swing > usual:
            key = "alarms.oscillation.amplitude"
            profile = profile_with(profile, {f"{profile.mechanism}.{key}": swing})
            what = f"{key} is {1e3 * swing:g} mm instead of {1e3 * usual:g} mm"
            notes = (*notes, f"{what}: a ring may stick and slip, it is only measured where it is")
        name = self.settings.camera
        if name is None:
            return profile, notes
        camera = profile.devices[name].settings
        absence = max(camera.max_absence, absence)
        area = max(camera.marker.area_tolerance, _AREA)
        keys = (f"devices.{name}.max_absence", f"devices.{name}.marker.area_tolerance")
        return profile_with(profile, dict(zip(keys, (absence, area), strict=True))), (
            *notes,
            f"{name}.max_absence is {absence:g} s: a wrong pose puts rays beside the sphere",
            f"{name}.marker.area_tolerance is {area:g}: a wrong pose tells wrongly how it leans",
        )

    def with_blind_monitors(self, give: float) -> tuple[Profile, tuple[str, ...]]:
        """See `Pneumatics.with_blind_monitors`; alarms take from monitors how far wires give."""
        usual = self.settings.alarms.frozen.distance
        if usual >= give:
            return self.profile, ()
        note = (
            f"alarms.frozen.distance is {1e3 * give:g} mm instead of {1e3 * usual:g} mm: "
            "a monitor does not see behind a shut valve how far a wire gives"
        )
        key = f"{self.profile.mechanism}.alarms.frozen.distance"
        return profile_with(self.profile, {key: give}), (note,)

    @property
    def gentle_pressure(self) -> float:
        """See `Pneumatics.gentle_pressure`."""
        return min(self.base_pressure, _GENTLE_PRESSURE)

    def with_gentle_controller(self) -> tuple[Profile, str]:
        """See `Pneumatics.with_gentle_controller`.

        The ring sticks so much that only the cascade keeps it sliding, since it observes the
        friction. But tuned for use it relies on the viscous friction of standard seals, and with
        weaker ones it hunts. With half the stiffness and a third of the integral the pairs slide
        evenly at 0.6 to 1.4 times the friction, a few millimetres off their line; with still less
        the ring gets away from it. A PID would push a ring that sticks until it flies off.

        Whatever the profile's cascade is tuned for, on quick regulators this is the one for
        standard seals, with the profile's gains where they are lower. Behind a dead time its
        integrals throw a ring that low-speed seals hold no better at rest than in motion: there all
        gains are the profile's, with a part of its integral. So they are on valves, whose pressures
        follow at once and would shake. It heeds no camera, which may not be calibrated yet, and
        shakes nothing: that would change the friction.
        """
        usual = self.profile.controllers["cascade"]
        standard, gains = usual, dict(_CASCADE)
        if self._falls:
            gains = {"integral": _CALM * usual.pair.integral}
        elif self.settings.valves is None:
            standard = dataclasses.replace(
                type(usual)(), wire=usual.wire, pose=usual.pose, stretch=usual.stretch
            )
        believed = dataclasses.asdict(usual.pair)
        gains = {f"pair.{name}": min(believed[name], most) for name, most in gains.items()}
        calm = {**gains, "camera.gain": 0.0, "dither.amplitude": 0.0, "path_dither.force": 0.0}
        profile = dataclasses.replace(
            self.profile, controllers={**self.profile.controllers, "cascade": standard}
        )
        changes = {f"controllers.cascade.{name}": value for name, value in calm.items()}
        return profile_with(profile, {**changes, "controllers.cascade.learning": None}), "cascade"

    def with_placing_controller(self) -> tuple[Profile, str]:
        """See `Pneumatics.with_placing_controller`; a PID lets a ring fall that nothing holds."""
        if self._falls:
            return self.with_gentle_controller()
        return with_placing_law(self.profile)

    @property
    def nobody_leads(self) -> bool:
        """Whether seals hold the ring near upright, and no law leads it from there: late air."""
        return self.air_is_late and not self._falls

    @property
    def _falls(self) -> bool:
        """Whether the cascade for standard seals throws the ring: late air, and little friction."""
        friction = self.settings.friction
        return self.air_is_late and friction.breakaway < _STICKY * friction.coulomb

    @property
    def air_is_late(self) -> bool:
        """Whether the air is too late for the cascade for standard seals."""
        response = self.settings.regulator_response
        air = max(response.dead_time - response.monitor_time, 0.0)
        return self.settings.valves is None and air * _CASCADE["position_rate"] > _LATE

    def reach(self, share: float) -> float:
        """See `Pneumatics.reach`."""
        along_ball = self.settings.limits.tilt * self.settings.geometry.ball_radius
        return _CHECKED * share * along_ball

    def along_line(
        self,
        motion: Motion[PairReference],
        controller: object,
        bases: Sequence[tuple[float, float]] = (),
    ) -> PosedMotion:
        """See `Pneumatics.along_line`; the ring leans between its pairs."""
        line = Leaning(motion, _BETWEEN, self.settings.geometry.ball_radius, bases)
        planned = plan_motion(self.profile, line, controller)
        assert isinstance(planned, PosedMotion)
        return planned

    def describe_path(self, path: Sequence[JointReference]) -> Iterator[str]:
        """See `Pneumatics.describe_path`."""
        tilt = math.acos(min(max(min(row.axis[2] for row in path), -1.0), 1.0))
        speed = max(math.hypot(*row.velocity) for row in path)
        yield (
            f"the ring leans by up to {format_quantity(tilt, 'rad')}, at up to "
            f"{math.degrees(speed):.3g} deg/s"
        )

    def balanced(self, reference: JointReference, pressure: float) -> tuple[float, ...]:
        """See `Pneumatics.balanced`."""
        distribution = TensionDistribution(self.settings.geometry)
        shares = distribution.shares(natural_rotation(reference.axis))
        total = min(len(shares) * pressure, self.highest / max(shares))
        return tuple(total * share for share in shares)
