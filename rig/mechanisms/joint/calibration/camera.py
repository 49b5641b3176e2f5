"""Place, orientation and latency of a joint's camera, from encoders and marker in motion.

The geometry is fitted too, with the drawing's tolerances as priors: a camera that explains a wrong
geometry would be wrong itself. Only the camera is written. Its distance is in proportion to the
marker's height, since no ray shows it: `geometry` measures that height.

The latency counts against the encoders' stamps: by how much a frame is later than its own. On a
bus encoder samples are as old as SYNC is under way. That is part of the latency, as a controller
that fuses both needs it.

Friction holds a rod back as a late camera does. Coulomb friction does not grow with the speed and
is found from the motion. Viscous friction grows with it as lateness does, so no motion separates
the two: 25 N s/m at a wire of 80 N/mm are 0.31 ms. Nor can breakaway be found, as seals that stick
and slip keep to no law. So both are the profile's. Their tolerance (`joint.tolerance.friction`)
makes nearly all of the latency's interval.
"""

from collections.abc import Sequence
from typing import Final

from rig.calibration.estimates import Estimate
from rig.calibration.instruments import Readings
from rig.calibration.procedure import Excitation, Finding, Procedure, quantity
from rig.calibration.recording import Recording
from rig.config import Profile
from rig.mechanisms.joint.calibration.camera_and_geometry import (
    RESIDUAL_BOUND,
    Solved,
    solve,
    swing,
)
from rig.mechanisms.joint.calibration.rosette import Rosette
from rig.mechanisms.joint.calibration.sighting_model import camera_pose

ROSETTE: Final = Rosette(tilt=0.6, petals=8, period=1.3)

_HEIGHT: Final = 30e-6
"""How well a calibrated height of the marker is known, m: to the height gauge and a part."""


class Camera(Procedure[Recording]):
    """Procedure for pose and latency of the camera."""

    name = "camera"
    title = "place, orientation and latency of the camera"
    shares = ("geometry",)
    rests_on_dimensions = True

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the camera's file, if there is a camera."""
        camera = profile.mechanism_settings.camera
        return () if camera is None else (camera,)

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the rosette; one that was broken off is begun anew."""
        return swing(profile, ROSETTE, done)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit joint and camera, and keep the camera."""
        solved = solve(profile, data, ROSETTE, height=_HEIGHT)
        return (camera_finding(profile, solved),)


def camera_finding(profile: Profile, solved: Solved, *, sphere: bool = False) -> Finding:
    """Return what was found of the camera.

    Parameters
    ----------
    profile : Profile
        The rig.
    solved : Solved
        Joint and camera.
    sphere : bool
        Write the marker's distance from the centre as well: the rays end there.
    """
    from scipy.spatial.transform import Rotation

    device = profile.mechanism_settings.camera
    posterior, believed = solved.posterior, profile.devices[device].settings.latency
    values = posterior.by_name
    turn, place = camera_pose(values, solved.mounted)
    vector = Rotation.from_matrix(turn).as_rotvec()
    estimates: list[Estimate] = [
        *(posterior.estimate(f"camera_{axis}", f"position.{axis}") for axis in "xyz"),
        # The rotation vector that is written is no place for intervals: these turn the camera of
        # the drawing about its own axes.
        *(posterior.estimate(f"camera_angle_{axis}", f"angle.{axis}") for axis in "xyz"),
        posterior.estimate("lateness", "latency", believed),
    ]
    written = {
        "position_camera_in_base": [quantity(x, "m") for x in place.tolist()],
        "rotation_base_from_camera": [quantity(x, "rad") for x in vector.tolist()],
        "latency": quantity(max(believed + values["lateness"], 0.0), "s"),
    }
    if sphere:
        written["marker"] = {"sphere_radius": quantity(values["marker_height"], "m")}  # type: ignore[assignment]
    return Finding(
        device, written, estimates, solved.residuals.ravel(), "m", RESIDUAL_BOUND,
        len(set(solved.seen.blocks.tolist())), solved.panels,
    )  # fmt: skip
