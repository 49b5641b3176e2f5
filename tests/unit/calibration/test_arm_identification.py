"""An arm's zeros and lengths from made-up hand positions: what is true is known."""

import dataclasses

import numpy as np
import pytest

from controllers.arm.geometry import ArmGeometry
from controllers.arm.kinematics import dimensions_of, forward
from rig.calibration.recording import CalibrationRefused
from rig.mechanisms.arm.calibration.hand_fit import find_directions, fit_hand
from rig.mechanisms.arm.calibration.hand_model import marker_positions, parameters_of
from rig.mechanisms.arm.calibration.poses import is_clear, near_poses, wide_poses
from rig.mechanisms.arm.settings import HandMetrology

ZEROS = np.array((0.02, -0.015, 0.03, -0.01, 0.025, 0.012))
LENGTHS = np.array((1e-3, -2e-3, 0.5e-3, 1.5e-3, -1e-3, 0.7e-3, -0.4e-3))
START = (0.1, 0.5, 1.2, 0.2, -0.6, 0.3)


def made(metrology, *, marker=(0.04, 0.0, 0.03), noise=50e-6, count=None, turned=(1,) * 6):
    """Return parameters, joints as read and the marker as seen of an arm that errs."""
    geometry = ArmGeometry(marker=marker)
    parameters = parameters_of(geometry, metrology)
    true = np.array([parameter.value for parameter in parameters])
    true[:6] += ZEROS
    true[6:13] += LENGTHS
    if metrology.frame == "free":
        true[-6:] = (0.4, -0.2, 2.0, 1.0, -3.0, 0.5)
    posture = np.array(START) + np.array([pose for _, pose in near_poses()])[:count]
    rng = np.random.default_rng(5)
    hand = marker_positions(true, posture, 1.0)
    hand = hand + noise * rng.standard_normal(hand.shape)
    return parameters, posture * np.array(turned), hand


class TestModel:
    @pytest.mark.parametrize("wrist_sign", [1, -1])
    def test_is_the_kinematics_of_the_laws(self, wrist_sign):
        geometry = ArmGeometry(
            base_height=0.1,
            elbow_offset=0.03,
            shoulder_offset=-0.02,
            a1=0.05,
            wrist_sign=wrist_sign,
        )
        values = np.array([p.value for p in parameters_of(geometry, HandMetrology())])
        joints = np.random.default_rng(1).uniform(-2.0, 2.0, (20, 6))
        arm = dimensions_of(geometry)
        expected = [forward(arm, tuple(q)).position for q in joints.tolist()]
        assert marker_positions(values, joints, wrist_sign) == pytest.approx(
            np.array(expected), abs=1e-12
        )


class TestFit:
    def test_finds_zeros_and_lengths_within_their_intervals(self):
        metrology = HandMetrology(marker_accuracy=0.0)
        parameters, joints, hand = made(metrology)
        fit = fit_hand(parameters, joints, hand, 1.0, metrology.accuracy)
        error = fit.values[:13] - np.concatenate((ZEROS, [p.value for p in parameters[6:13]]))
        error[6:] -= LENGTHS
        assert np.all(np.abs(error) < 3.5 * np.sqrt(np.diag(fit.covariance)[:13]))
        assert np.sqrt(np.mean(fit.residuals**2)) == pytest.approx(50e-6, rel=0.2)

    def test_the_marker_s_tolerance_is_in_the_tool_s_length(self):
        parameters, joints, hand = made(HandMetrology(marker_accuracy=200e-6))
        fit = fit_hand(parameters, joints, hand, 1.0, 50e-6)
        assert fit.covariance[8, 8] ** 0.5 > 200e-6  # d6
        assert fit.covariance[5, 5] ** 0.5 > 200e-6 / 0.04  # q6, over the marker's lever

    def test_an_instrument_that_stands_anywhere_does_not_see_q1_and_the_height(self):
        metrology = HandMetrology(frame="free")
        parameters, joints, hand = made(metrology)
        fit = fit_hand(parameters, joints, hand, 1.0, metrology.accuracy)
        first, second = fit.notes
        assert first.startswith("the zero of q1 and the instrument's frame")
        assert "are one: a turn of the base looks the same" in first
        assert second.startswith("base_height and the instrument's frame")
        assert not fit.seen[0]
        assert fit.values[1:6] == pytest.approx(ZEROS[1:], abs=4e-3)

    def test_a_marker_on_the_tool_s_axis_does_not_see_q6(self):
        parameters, joints, hand = made(HandMetrology(), marker=(0.0, 0.0, 0.03))
        fit = fit_hand(parameters, joints, hand, 1.0, 50e-6)
        (note,) = fit.notes
        assert note.startswith("the zero of q6 is not seen")
        assert "20 mm or more across it" in note
        assert fit.values[5] == 0.0

    def test_too_few_poses_say_what_they_lack(self):
        parameters, joints, hand = made(HandMetrology(), count=4)
        with pytest.raises(CalibrationRefused, match=r"do not tell .* apart: measure more of them"):
            fit_hand(parameters, joints, hand, 1.0, 50e-6)


class TestDirections:
    @pytest.mark.parametrize(
        ("turned", "frame"),
        [
            ((1, -1, -1, -1, 1, -1), "base"),
            pytest.param((1, 1, 1, 1, 1, 1), "base", marks=pytest.mark.slow),
            pytest.param((-1, 1, 1, 1, -1, 1), "base", marks=pytest.mark.slow),
            pytest.param((1, 1, 1, 1, 1, 1), "free", marks=pytest.mark.slow),
            pytest.param((-1, 1, 1, 1, -1, 1), "free", marks=pytest.mark.slow),
        ],
    )
    def test_are_found_from_how_the_hand_moves(self, turned, frame):
        parameters, joints, hand = made(HandMetrology(frame=frame), turned=turned)
        assert find_directions(parameters, joints, hand, 1.0, 50e-6) == turned

    @pytest.mark.slow
    def test_of_a_joint_that_is_not_seen_is_the_profile_s(self):
        parameters, joints, hand = made(HandMetrology(), marker=(0.0, 0.0, 0.0))
        assert find_directions(parameters, joints, hand, 1.0, 50e-6)[5] == 1.0

    def test_of_a_hand_that_did_not_move_as_the_joints_are_refused(self):
        parameters, joints, hand = made(HandMetrology())
        hand = hand[::-1]
        with pytest.raises(
            CalibrationRefused, match=r"does not tell which way|did not move as the joints"
        ):
            find_directions(parameters, joints, hand, 1.0, 50e-6)


class TestWidePoses:
    GEOMETRY = ArmGeometry(marker=(0.04, 0.0, 0.03))

    def test_are_as_many_as_asked_and_clear(self):
        poses = wide_poses(self.GEOMETRY, HandMetrology(poses=12))
        named = [q for name, q in poses if name]
        assert len(named) == 12
        assert all(is_clear(self.GEOMETRY, q) for q in named)

    def test_determine_more_than_those_around_one_posture(self):
        metrology = HandMetrology(poses=25, marker_accuracy=0.0)
        wide = np.array([q for name, q in wide_poses(self.GEOMETRY, metrology) if name])
        near = np.array(START) + np.array([q for _, q in near_poses()])
        parameters = parameters_of(self.GEOMETRY, metrology)
        start = np.array([p.value for p in parameters])
        stds = []
        for joints in (wide, near):
            hand = marker_positions(start, joints, 1.0)
            rng = np.random.default_rng(2)
            hand = hand + 50e-6 * rng.standard_normal(hand.shape)
            fit = fit_hand(parameters, joints, hand, 1.0, 50e-6)
            stds.append(np.sqrt(np.diag(fit.covariance)[6:13]))
        assert np.all(stds[0] < 0.7 * stds[1])

    def test_limits_that_leave_no_room_are_said(self):
        still = tuple([-0.01] * 6), tuple([0.01] * 6)
        narrow = dataclasses.replace(self.GEOMETRY, position_min=still[0], position_max=still[1])
        with pytest.raises(ValueError, match="too little room"):
            wide_poses(narrow, HandMetrology())
