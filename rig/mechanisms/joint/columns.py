"""What the log keeps of the spherical joint, each cycle."""

from collections.abc import Mapping

from controllers.spherical_joint.geometry import Quadruple
from controllers.spherical_joint.types import CameraSample
from rig.hal.columns import Column

CHANNELS = ("ch1", "ch2", "ch3", "ch4")

JOINT_COLUMNS = (
    *(Column(f"reading.rod_{name}", "m", "shortening of its wire") for name in CHANNELS),
    *(Column(f"reading.pressure_{name}", "Pa", "chamber pressure, gauge") for name in CHANNELS),
    Column("reading.age", "s", "age of the oldest reading when it was used"),
    *(Column(f"reading.marker_{axis}", "m", "marker as the camera saw it") for axis in "xyz"),
    Column("reading.marker_age", "s", "age of that sample; -1 before the first"),
    Column("reading.marker_time", "s", "of that sample on the rig's clock"),
    Column("reading.twist", "rad", "of the ring in that sample; 0 if the marker does not show it"),
    Column("reading.twist_shown", "1", "1 if the marker shows it"),
    *(Column(f"reference.axis_{axis}", "1", "desired axis of the ring") for axis in "xyz"),
    *(Column(f"reference.marker_{axis}", "m", "desired marker") for axis in "xyz"),
    *(Column(f"reference.rod_{name}", "m", "where control wants the rod") for name in CHANNELS),
    *(Column(f"estimate.marker_{axis}", "m", "encoders and camera") for axis in "xyz"),
    *(Column(f"estimate.encoder_marker_{axis}", "m", "encoders alone") for axis in "xyz"),
    Column("estimate.residual", "m", "how far the wires are from agreeing on a pose"),
    *(Column(f"estimate.tension_{name}", "N", "pull of the chamber") for name in CHANNELS),
    Column("estimate.lap", "1", "laps before this one; -1 out of a repeated motion"),
    Column("estimate.learning", "1", "1 while laps are learnt from, 2 when that has ended, else 0"),
    Column("plan.least_tension", "N", "of the wires that hold the pose at base pressure"),
    Column("plan.reach", "rad", "tilt that is possible in this direction"),
    Column("plan.paper_error", "m", "error of the paper's wires in the paper's pose"),
    *(Column(f"command.{name}", "Pa", "wanted setpoint, gauge") for name in CHANNELS),
    *(Column(f"applied.{name}", "Pa", "setpoint that was sent, gauge") for name in CHANNELS),
)


def four_of(logged: Mapping[str, float], prefix: str) -> Quadruple:
    """Return the values of the four channels in a row of the log."""
    first, second, third, fourth = (logged[f"{prefix}_{name}"] for name in CHANNELS)
    return first, second, third, fourth


def sample_of(logged: Mapping[str, float], before: CameraSample | None) -> CameraSample | None:
    """Return the camera's sample in a row of the log; the one before if it is still that one."""
    if logged["reading.marker_age"] == -1.0:
        return None
    t = logged["reading.marker_time"]
    if before is not None and before.t == t:
        return before
    x, y, z = (logged[f"reading.marker_{axis}"] for axis in "xyz")
    twist = logged["reading.twist"] if logged["reading.twist_shown"] else None
    return CameraSample((x, y, z), t, twist)
