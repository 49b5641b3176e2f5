"""What a profile may say of the joint, and which devices can do it."""

import math
from dataclasses import asdict, fields

import pytest
from joint_fakes import (
    CHANNELS,
    ENCODERS,
    GEOMETRY,
    JointBench,
    joint_limits,
    joint_settings,
)
from pneumatic_fakes import (
    BASE,
    HIGHEST,
    HOME,
    LOWEST,
    PERIOD,
    FakeCamera,
    FakeRegulators,
)

from rig.config.settings import adapter
from rig.hal import ConfigurationError
from rig.mechanisms.joint.alarms.settings import JointAlarmSettings
from rig.mechanisms.joint.mechanism import SphericalJoint
from rig.mechanisms.joint.settings import JointFriction, JointLimits, JointSettings
from rig.mechanisms.pneumatic.alarms.settings import PressureAlarm


def test_controllers_are_told_what_the_profile_says():
    settings = joint_settings()
    model = SphericalJoint.model_of(settings)
    assert (model.geometry, model.area, model.mass) == (GEOMETRY, settings.area, 0.14)
    assert (model.base_pressure, model.pressure_min, model.pressure_max) == (BASE, LOWEST, HIGHEST)
    assert (model.regulator_bandwidth, model.regulator_damping) == (40.0, 1.0)
    assert (model.coulomb, model.breakaway) == (7.0, 10.0)
    assert (model.stribeck_velocity, model.viscous) == (8e-3, 50.0)
    assert (model.ring_friction, model.wire_friction) == (0.07, 0.11)
    assert model.wire_stiffness == settings.wire_stiffness
    assert (model.least_tension, model.most_tension) == (5.0, 90.0)
    assert SphericalJoint.wiring(settings) == dict(zip(ENCODERS, CHANNELS, strict=True))


def test_a_joint_is_put_together_from_the_devices_that_the_profile_names():
    bench = JointBench(camera=FakeCamera())
    devices = {device.name: device for device in bench.encoders}
    devices |= {"regulators": bench.regulators, "camera": bench.camera, "stop": bench.stop}
    settings = joint_settings(camera="camera", emergency_stop="stop")
    joint = SphericalJoint.assemble(settings, devices, PERIOD)
    bench.encoders[2].extension = 0.5 * HOME
    assert joint.read(0.0).rods == (0.0, 0.0, 0.5 * HOME, 0.0)
    bare = SphericalJoint.assemble(joint_settings(), devices, PERIOD)
    bench.stop.pressed = True
    bare.check(bare.read(0.0), 0.0)  # it knows of none
    with pytest.raises(ConfigurationError, match=r"joint\.camera: stop is no MarkerCamera"):
        SphericalJoint.assemble(joint_settings(camera="stop"), devices, PERIOD)


def test_a_joint_needs_its_four_channels_in_their_order():
    with pytest.raises(ConfigurationError, match="the joint needs ch1, ch2, ch3, ch4"):
        JointBench(regulators=FakeRegulators(("ch1", "ch3", "ch2", "ch4")))


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_camera_may_take_the_marker_for_a_little_nearer_or_farther(side):
    height = GEOMETRY.marker_height
    JointBench(camera=FakeCamera(sphere_radius=height + side * 0.1999e-3))
    with pytest.raises(ConfigurationError, match=r"^camera: marker\.sphere_radius is 5\d\.\d+ mm"):
        JointBench(camera=FakeCamera(sphere_radius=height + side * 0.2001e-3))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rod": 16e-3}, "does not fit into bore"),
        ({"home": 2 * HOME}, "is not within stroke"),
        ({"base_pressure": LOWEST - 1.0}, r"outside limits\.pressure"),
        ({"base_pressure": LOWEST}, r"is the least of limits\.pressure"),
        ({"base_pressure": HIGHEST + 1.0}, r"outside limits\.pressure"),
        ({"encoders": ("e1", "e2", "e3", "e1")}, "one device is named for two channels"),
    ],
)
def test_a_joint_that_cannot_be_is_refused(changes, message):
    joint_settings(base_pressure=LOWEST + 1.0)
    joint_settings(base_pressure=HIGHEST)
    with pytest.raises(ValueError, match=message):
        joint_settings(**changes)


@pytest.mark.parametrize("name", ["pressure", "tension"])
def test_a_range_has_its_lower_end_below_its_upper_one(name):
    """A profile is held to it with the type of the limits, so that it is told beside all else."""
    adapter(JointLimits).validate_python(asdict(joint_limits(**{name: (1.0, 1.0 + 1e-9)})))
    for empty in ((1.0, 1.0), (1.0, 0.5)):
        with pytest.raises(ValueError, match=rf"{name}: the lower limit"):
            adapter(JointLimits).validate_python(asdict(joint_limits(**{name: empty})))
    assert joint_settings().area == pytest.approx(181.427e-6, rel=1e-5)


def test_what_a_profile_leaves_out_is_as_its_documentation_says():
    limits = JointLimits(
        tilt=1.0, speed=1.0, pressure=(0.0, 1.0), pressure_rate=1.0, tension=(0.0, 1.0),
        reading_age=1.0,
    )  # fmt: skip
    assert (limits.tilt_excess, limits.seat_margin) == (math.radians(5.0), 0.0)
    assert limits.free_wires
    assert (limits.residual, limits.disagreement, limits.grace) == (1e-3, 3e-3, 0.05)
    alarms = joint_settings().alarms
    assert JointAlarmSettings().pressure == PressureAlarm(None, None, None, None)
    assert (alarms.frozen.distance, alarms.frozen.time) == (0.4e-3, 0.05)
    assert (alarms.swapped.distance, alarms.swapped.share) == (1e-3, 0.25)
    assert (alarms.twist.limit, alarms.twist.time) == (math.radians(10.0), 0.1)
    settings = joint_settings()
    assert settings.wire_offsets == (0.0,) * 4
    defaults = {field.name: field.default for field in fields(JointSettings)}
    assert defaults["wire_stiffness"] == 80e3
    assert (settings.camera, settings.emergency_stop) == (None, None)
    assert JointFriction(1.0, 2.0, 3.0, 4.0) == JointFriction(1.0, 2.0, 3.0, 4.0, 0.08, 0.10)
