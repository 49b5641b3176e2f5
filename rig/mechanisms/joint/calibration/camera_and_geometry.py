"""Joint and camera fitted to one recording, for the procedures ``camera`` and ``geometry``.

Neither can be fitted alone: a wrong geometry misplaces the marker by which the camera is placed,
and a wrong camera misplaces the marker by which the geometry is found.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

import numpy as np

from controllers.spherical_joint.types import JointReference
from rig.assembly import make_controller, plan_motion
from rig.calibration.arrays import Array
from rig.calibration.procedure import Excitation, Panel
from rig.calibration.profile_changes import profile_with
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.hal.motion import Motion
from rig.mechanisms.joint.calibration.parameters import ANGLES, WIRES, Values, drawing_of, priors_of
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.joint.calibration.pose_fit import Data, Posterior, fit_posterior
from rig.mechanisms.joint.calibration.rosette import UPRIGHT, Rosette
from rig.mechanisms.joint.calibration.sighting_model import (
    Sightings,
    axes_seen,
    extensions_seen,
    rod_slopes,
)
from rig.mechanisms.joint.calibration.sightings import check_travel, sightings_of, track_of

RESIDUAL_BOUND: Final = 0.1e-3
"""Rms of what joint and camera do not explain of the rods above which the fit is of no use, m."""

GAUGE_ACCURACY: Final = 20e-6
"""Standard uncertainty of a reading of the height gauge, m."""

_FRAMES: Final = 700
"""So many are enough: the errors that limit the fit change more slowly than from frame to frame."""

_ROD_NOISE: Final = 5e-6
_AXIS_NOISE: Final = 10e-6
_TWIST: Final = 30e-3
"""Rms errors of a rod's stretch (m), of the marker in a frame (m) and of the ring's angle about its
axis (rad); E. Only their proportions matter. The angle is but a milliradian, but it lasts for a
petal and turns round on the way back; its large value here removes its direction from each frame.
"""

_SETTLED: Final = 50e-6
_ROUNDS: Final = 3
"""The latency is fitted anew until it changes by less, s; so often at most."""

_EQUAL: Final = 1e-5
"""Standard deviation of the anchors' mean angle about the drawing's, rad: they count from it."""

_WRONG_ZERO: Final = 5.0
"""A rod's zero that is off by more of its standard deviations was not calibrated."""


class Solved(NamedTuple):
    """A fit of joint and camera, with the data that it rests on.

    Parameters
    ----------
    posterior : Posterior
        Every parameter, with the covariance.
    seen : Sightings
        The frames.
    mounted : ndarray, shape (3,)
        Rotation vector of the camera in the drawing, rad.
    before : Values
        What was believed.
    channels : tuple of str
        Of the rods.
    """

    posterior: Posterior
    seen: Sightings
    mounted: Array
    before: Values
    channels: tuple[str, ...]

    @property
    def residuals(self) -> Array:
        """Measured less modelled extension of each rod, m, shape (n, 4)."""
        return self.seen.rods - extensions_seen(self.posterior.by_name, self.seen, self.mounted)

    @property
    def panels(self) -> list[Panel]:
        """One for each rod, and one of the residuals over time."""
        believed = extensions_seen(self.before, self.seen, self.mounted)
        # What friction and the rods' zeros add is the same for both: the geometry is shown.
        measured, rest = 1e3 * (self.seen.rods - believed), 1e3 * self.residuals
        labels = ("less the model before (mm)", "residual (µm)")
        panels = [
            Panel(
                f"rod of {channel}", "extension (mm)", *labels, 1e3 * self.seen.rods[:, k],
                measured[:, k], measured[:, k] - rest[:, k], np.zeros(len(rest)), 1e3,
            )
            for k, channel in enumerate(self.channels)
        ]  # fmt: skip
        return [
            *panels,
            Panel(
                "all rods over time", "time (s)", *labels, np.tile(self.seen.t, 4),
                measured.T.ravel(), (measured - rest).T.ravel(), np.zeros(rest.size), 1e3,
            ),
        ]  # fmt: skip


def swing(profile: Profile, rosette: Rosette, done: Sequence[str]) -> Excitation:
    """Return a rosette under control of encoders alone; nothing if it is recorded already.

    One that was broken off is begun anew: its petals belong together.
    """
    wider, notes = JointPneumatics(profile).with_limits_for_sightings()
    wider = profile_with(
        wider, {"controllers.cascade.camera.gain": 0.0, "controllers.cascade.learning": None}
    )
    controller = make_controller(wider, "cascade")
    motion = plan_motion(wider, rosette, controller)
    if all(segment.name in done for segment in rosette.segments):
        motion = _Recorded(motion)
    return JointPneumatics(wider).excitation(rosette, motion, controller, "cascade", notes, 2.0)


class _Recorded(Motion[JointReference]):
    """A motion of which nothing is left to do."""

    segments = ()

    def __init__(self, motion: Motion[JointReference]) -> None:
        self._motion = motion

    @property
    def duration(self) -> float:
        """How long it took, s."""
        return self._motion.duration

    def at(self, t: float) -> JointReference:
        """Return the reference that it had at `t`."""
        return self._motion.at(t)


def solve(
    profile: Profile,
    recording: Recording,
    rosette: Rosette,
    *,
    gauge: float | None = None,
    height: float | None = None,
) -> Solved:
    """Return the joint and the camera that explain a recording best.

    Parameters
    ----------
    profile : Profile
        The rig as it was recorded.
    recording : Recording
        Of the rosette.
    rosette : Rosette
        What was to be done.
    gauge : float, optional
        Height of the marker over the ball's centre while the ring stood upright, m.
    height : float, optional
        How well the marker's height is known without, if it was calibrated, m.

    Raises
    ------
    CalibrationRefused
        A stretch or the marker is missing, a rod hardly moved, or its zero is wrong.
    """
    names = [segment.name for segment in rosette.segments]
    recording.require(names)
    petals = [name for name in names if name != UPRIGHT]
    settings = profile.mechanism_settings
    mounted = np.array(profile.devices[settings.camera].nominal.rotation_base_from_camera)
    track = track_of(profile, recording, names)
    upright = sightings_of(profile, recording, [UPRIGHT], track).rays.mean(axis=0, keepdims=True)
    priors = priors_of(profile, height)
    turned = sum(drawing_of(profile).anchor_angles)
    part = settings.tolerance.part / np.sqrt(3.0)

    def extra(values: Mapping[str, float]) -> Array:
        rows = [(sum(values[name] for name in ANGLES) - turned) / (4.0 * _EQUAL)]
        if gauge is not None:
            shown = values["marker_height"] * axes_seen(values, upright, mounted)[0, 2]
            rows.append((shown - gauge) / np.hypot(GAUGE_ACCURACY, part))
        return np.array(rows)

    values = {p.name: p.mean for p in priors}
    late, settled, rounds = 0.0, False, 0
    while not settled:
        seen = _thinned(sightings_of(profile, recording, petals, track, late))
        check_travel(profile, seen)
        whitening = _whitening(values, seen, mounted)

        def misfit(
            values: Mapping[str, float], seen: Sightings = seen, whitening: Array = whitening
        ) -> Array:
            rest = seen.rods - extensions_seen(values, seen, mounted)
            return np.asarray(np.einsum("nij,nj->ni", whitening, rest))

        posterior = fit_posterior(priors, Data(misfit, seen.blocks, extra), values)
        values, rounds = posterior.by_name, rounds + 1
        settled = abs(values["lateness"] - late) < _SETTLED or rounds == _ROUNDS
        late = values["lateness"]
    _check_zeros(profile, posterior)
    channels = JointPneumatics(profile).channels
    return Solved(posterior, seen, mounted, _before(profile, posterior), channels)


def _whitening(values: Values, seen: Sightings, mounted: Array) -> Array:
    """Return what makes the four misfits of each frame independent and alike, (n, 4, 4).

    A wrong axis moves opposite rods against each other; their sum tells more than either.
    """
    first, second, twist = rod_slopes(values, seen, mounted)
    noise = _AXIS_NOISE / values["marker_height"]
    covariance = _ROD_NOISE**2 * np.eye(4) + sum(
        (size * size) * slope[:, :, None] * slope[:, None, :]
        for size, slope in ((noise, first), (noise, second), (_TWIST, twist))
    )
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def _thinned(seen: Sightings) -> Sightings:
    step = max(len(seen.t) // _FRAMES, 1)
    columns: Any = seen[:-1]
    return Sightings._make([*(column[::step] for column in columns), seen.late])


def _before(profile: Profile, posterior: Posterior) -> dict[str, float]:
    """Return the parameters with what the profile says of joint and camera in force."""
    from scipy.spatial.transform import Rotation

    settings = profile.mechanism_settings
    camera = profile.devices[settings.camera]
    geometry, believed = settings.geometry, camera.settings
    turn = (
        Rotation.from_rotvec(camera.nominal.rotation_base_from_camera).inv()
        * Rotation.from_rotvec(believed.rotation_base_from_camera)
    ).as_rotvec()
    values = dict(posterior.by_name)
    for name in ("ball_radius", "ring_radius", "adjust_radius", "adjust_depth", "marker_height"):
        values[name] = getattr(geometry, name)
    for k, axis in enumerate("xyz"):
        values[f"camera_{axis}"] = believed.position_camera_in_base[k]
        values[f"camera_angle_{axis}"] = float(turn[k])
    for k in WIRES:
        values[f"anchor_angle_{k}"] = geometry.anchor_angles[k - 1]
    return {**values, "lateness": 0.0, "home": settings.home}


def _check_zeros(profile: Profile, posterior: Posterior) -> None:
    zero = profile.mechanism_settings.tolerance.zero
    for k, channel in zip(WIRES, JointPneumatics(profile).channels, strict=True):
        off = posterior.by_name[f"offset_{k}"]
        if abs(off) > _WRONG_ZERO * zero:
            raise CalibrationRefused(
                f"the rod of {channel} seems to be off by {1e3 * off:.2f} mm against the others, "
                f"which is more than joint.tolerance.zero ({1e3 * zero:g} mm) permits: calibrate "
                "its encoder first, or its wire is slack"
            )
