"""Dimensions of the spherical joint, from encoders and camera in motion, and its camera with them.

Ball, ring and anchor angles follow from how the rods move with the axis that the camera sees. The
marker's height no motion shows: a gauge does. What the drawing knows better than the motion is
said so, and stays within its tolerance.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from rig.calibration.instruments import Instrument, Readings
from rig.calibration.procedure import Excitation, Finding, Procedure, quantity
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.joint.calibration.camera import camera_finding
from rig.mechanisms.joint.calibration.camera_and_geometry import (
    GAUGE_ACCURACY,
    RESIDUAL_BOUND,
    solve,
    swing,
)
from rig.mechanisms.joint.calibration.parameters import ANGLES, LENGTHS
from rig.mechanisms.joint.calibration.rosette import UPRIGHT, Rosette

ROSETTE: Final = Rosette(tilt=0.73, petals=12, period=3.2)

_GAUGE: Final = "height gauge"


class Geometry(Procedure[Recording]):
    """Procedure for the dimensions of ball, ring and wires, with the camera's pose and latency."""

    name = "geometry"
    title = "dimensions of the joint, and its camera with them"
    shares = ("camera",)
    rests_on_dimensions = True

    def targets(self, profile: Profile) -> tuple[str, ...]:
        """Return the joint's and the camera's file, if there is a camera."""
        camera = profile.mechanism_settings.camera
        return () if camera is None else (profile.mechanism, camera)

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return the gauge for the marker's height over the ball's centre, ring upright."""
        return (Instrument(_GAUGE, "m", GAUGE_ACCURACY, (UPRIGHT,), "marker_z"),)

    def excite(self, profile: Profile, done: Sequence[str]) -> Excitation:
        """Return the rosette; one that was broken off is begun anew."""
        return swing(profile, ROSETTE, done)

    def identify(self, profile: Profile, data: Recording, readings: Readings) -> Sequence[Finding]:
        """Fit joint and camera."""
        gauge = readings.get(_GAUGE, {}).get(UPRIGHT)
        if gauge is None:
            raise CalibrationRefused(
                f"the {_GAUGE} was not read in {UPRIGHT!r}: no motion shows how high the marker "
                "is over the ball's centre"
            )
        drawn = profile.nominal_settings.geometry.marker_height
        bound = profile.mechanism_settings.tolerance.length * drawn
        if abs(gauge - drawn) > 2.0 * bound:
            raise CalibrationRefused(
                f"the {_GAUGE} shows {1e3 * gauge:.3f} mm in {UPRIGHT!r}, the drawing says "
                f"{1e3 * drawn:.3f} mm within {1e3 * bound:.2f} mm: was it set to zero at the "
                "ball's centre?"
            )
        solved = solve(profile, data, ROSETTE, gauge=gauge)
        posterior = solved.posterior
        values = posterior.by_name
        written = {
            "home": quantity(values["home"], "m"),
            "geometry": {
                **{name: quantity(values[name], "m") for name in LENGTHS},
                "anchor_angles": [quantity(values[name], "rad") for name in ANGLES],
            },
        }
        estimates = [posterior.estimate(name) for name in (*LENGTHS, *ANGLES, "home")]
        known = [name for name in posterior.dominated if name in (*LENGTHS, *ANGLES)]
        notes = (f"{', '.join(known)}, better than the drawing says them",) if known else ()
        joint = Finding(
            profile.mechanism, written, estimates, solved.residuals.ravel(), "m", RESIDUAL_BOUND,
            len(np.unique(solved.seen.blocks)), solved.panels,
            notes=notes,
        )  # fmt: skip
        camera = camera_finding(profile, solved, sphere=True)
        return joint, camera._replace(panels=())
