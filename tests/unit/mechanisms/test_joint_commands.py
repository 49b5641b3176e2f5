"""What the joint's chambers are told, and how near a limit is."""

import pytest
from joint_fakes import (
    CHANNELS,
    JointBench,
    joint_limits,
    joint_settings,
    off,
)
from pneumatic_fakes import (
    AGE,
    BASE,
    HIGHEST,
    LOWEST,
    PERIOD,
    HoldingRegulators,
)

from controllers.spherical_joint.poses import axis_from_tilt
from controllers.spherical_joint.types import JointCommand
from rig.hal.quantities import Margin
from rig.mechanisms.joint.alarms.settings import JointAlarmSettings
from rig.mechanisms.pneumatic.alarms.settings import PressureAlarm


def test_resting_keeps_the_sum_of_the_pressures_and_the_ring():
    bench = JointBench()
    bench.regulators.reads = (40e3, 80e3, 120e3, 160e3)
    state = bench.cycles(4)
    assert bench.joint.resting_command(state) == pytest.approx((100e3,) * 4)
    bench = JointBench()
    bench.lean(0.4)
    state = bench.cycles(4)
    leaning = bench.joint.resting_command(state)
    assert sum(leaning) == pytest.approx(4 * BASE)
    # Farther round the ball pulls with less lever: the wires on the side that rose hold more.
    assert leaning == pytest.approx(bench.joint.energised_command(state))
    assert max(leaning) - min(leaning) > 1e3


def test_resting_and_energised_stay_within_what_is_permitted():
    alarms = JointAlarmSettings(pressure=PressureAlarm(40e3, 0.05, offset=100e3, slow=1e12))
    for base, permitted in ((BASE, (LOWEST, 1.02 * BASE)), (BASE, (0.98 * BASE, HIGHEST))):
        bench = JointBench(
            joint_settings(joint_limits(pressure=permitted), base_pressure=base, alarms=alarms)
        )
        bench.lean(0.5)
        state = bench.cycles(4)
        command = bench.joint.energised_command(state)
        assert all(permitted[0] <= pressure <= permitted[1] for pressure in command)
        assert any(pressure in permitted for pressure in command)


def test_energised_the_mean_is_the_base_pressure():
    bench = JointBench()
    bench.regulators.reads = (40e3,) * 4
    assert bench.joint.energised_command(bench.cycles(4)) == pytest.approx((BASE,) * 4)


def test_released_all_chambers_have_the_least_pressure_but_what_the_devices_hold():
    assert JointBench().joint.released_command() == (LOWEST,) * 4
    regulators = HoldingRegulators(CHANNELS)
    regulators.held = (0.0, 1e5, 0.0, 2e5)
    assert JointBench(regulators=regulators).joint.released_command() == (0.0, 1e5, 0.0, 2e5)


def test_a_blend_goes_from_its_start_to_its_end():
    start, end = JointCommand(0, 100, 200, 300), JointCommand(100, 100, 0, 400)
    blend = JointBench().joint.blend
    assert (blend(start, end, 0.0), blend(start, end, 1.0)) == (start, end)
    assert blend(start, end, 0.25) == (25, 100, 150, 325)


def test_range_and_rate_are_kept_and_counted_from_the_measured_pressures():
    bench = JointBench(joint_settings(joint_limits(pressure_rate=1e3 / PERIOD)))
    bench.regulators.reads = (100e3, HIGHEST, LOWEST, 100e3)
    bench.joint.start_limiting(bench.cycles(1))
    applied = bench.joint.limit(JointCommand(100.5e3, HIGHEST + 1.0, LOWEST - 1.0, 102e3))
    assert applied == (100.5e3, HIGHEST, LOWEST, 101e3)
    assert bench.joint.limit_hits() == {"pressure range": 2, "pressure rate": 1}


def test_what_is_known_of_a_state_is_the_pose_of_its_rods():
    bench = JointBench()
    bench.lean(0.3, 1.0)
    state = bench.joint.read(0.0)
    axis, velocity, acceleration, *_ = bench.joint.reference_of(state)
    assert axis == pytest.approx(axis_from_tilt(0.3, 1.0), abs=1e-9)
    assert velocity == acceleration == (0.0,) * 3


@pytest.mark.parametrize(
    ("lean", "late", "pressures", "applied", "nearest"),
    [
        (0.5, 0.0, (BASE,) * 4, 0.0, Margin("tilt", 0.2)),
        (0.0, 0.875 * AGE, (BASE,) * 4, 0.0, Margin("reading age", 0.125)),
        (0.0, 0.0, (BASE,) * 4, 0.75 * HIGHEST, Margin("pressure", 0.25)),
        (0.0, 0.0, (BASE, BASE, 6.0, BASE), 0.0, Margin("slack wire", 0.2)),
    ],
)
def test_the_nearest_limit_is_told(lean, late, pressures, applied, nearest):
    settings = joint_settings()
    bench = JointBench(settings)
    bench.lean(lean)
    bench.regulators.reads = tuple([p if p > 100.0 else p / settings.area for p in pressures])
    bench.cycles(4)
    for device in (bench.regulators, *bench.encoders):
        device.t = 1.0 - late
    state = bench.joint.read(1.0)
    for k in range(4):
        margin = bench.joint.worst_margin(state, off((0.0,) * 4, k + 1, applied), 1.0)
        assert margin.name == nearest.name
        assert margin.fraction == pytest.approx(nearest.fraction, rel=1e-6)


def test_no_wire_is_slack_where_none_has_to_be_taut():
    bench = JointBench(joint_settings(joint_limits(tension=(0.0, 90.0))))
    bench.regulators.reads = (0.0,) * 4
    state = bench.cycles(4)
    assert bench.joint.worst_margin(state, (0.5 * HIGHEST,) * 4, bench.now) == ("pressure", 0.5)
