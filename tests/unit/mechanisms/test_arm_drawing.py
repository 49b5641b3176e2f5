"""Arms from URDFs and Denavit-Hartenberg tables, held against kinematics that are not ours."""

import math
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml
from drawn_arms import away, draw_arm, draw_lengths, posture_of, universal_robot, urdf_of

from controllers.arm.inverse import BRANCHES, OutOfReach, inverse
from controllers.arm.kinematics import (
    dimensions_of,
    forward,
    jacobian_columns,
    singularity_indices,
)
from rig.hal import ConfigurationError
from rig.mechanisms.arm.drawing.chain import DrawingError
from rig.mechanisms.arm.drawing.denavit_hartenberg import read_dh
from rig.mechanisms.arm.drawing.profile import of_dh, of_urdf
from rig.mechanisms.arm.drawing.spherical_wrist import recognise
from rig.mechanisms.arm.drawing.urdf import read_urdf

ARMS = Path(__file__).parents[2] / "data" / "arms"


def hand_of(drawing, drawn):
    """Return the tip's pose in the drawing's base by the laws' kinematics."""
    hand = forward(dimensions_of(drawing.geometry), drawing.joints_of(drawn))
    turn = drawing.base_rotation
    return (
        drawing.base_position + turn @ np.array(hand.position),
        turn @ np.array(hand.rotation) @ drawing.tip_rotation,
    )


def theirs(drawing, q):
    return (np.array(q) - drawing.zeros) * drawing.signs


def judge(drawing, place, count, rng):
    """Hold forward and inverse kinematics against a function of the description's own joints."""
    arm = dimensions_of(drawing.geometry)
    found = 0
    for drawn in rng.uniform(-3.0, 3.0, (count, 6)):
        pose = place(drawn)
        assert away(hand_of(drawing, drawn), pose) < 1e-12
        mine = forward(arm, drawing.joints_of(drawn))
        for branch in BRANCHES:
            try:
                q = inverse(arm, mine, branch, drawing.joints_of(drawn))
            except OutOfReach:
                assert arm.a1 != 0.0
                continue
            found += 1
            # Beside a singularity an angle has fewer digits than a pose.
            assert away(place(theirs(drawing, q)), pose) < 2e-11
    assert 4 * count <= found <= 8 * count
    assert found == 8 * count or arm.a1 != 0.0


def mujoco_of(file):
    """Return a URDF's tip and its Jacobian as MuJoCo has them, which reads the file itself."""
    text = file.read_text().replace(
        "<link", '<mujoco><compiler fusestatic="false" boundmass="1" boundinertia="1" '
        'discardvisual="true"/></mujoco><link', 1,
    )  # fmt: skip
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)

    def place(q):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        tip = data.body("tool0")
        return np.array(tip.xpos), np.array(tip.xmat).reshape(3, 3)

    def jacobian(q):
        place(q)
        columns = np.zeros((6, 6))
        mujoco.mj_jacBody(model, data, columns[:3], columns[3:], data.body("tool0").id)
        return columns

    return place, jacobian


@pytest.mark.parametrize("name", ["irb-120", "kr-6-r900"])
def test_arms_of_data_sheets_are_where_mujoco_has_them(name):
    file = ARMS / f"{name}.urdf"
    drawing = recognise(read_urdf(file))
    place, jacobian = mujoco_of(file)
    rng = np.random.default_rng(1)
    judge(drawing, place, 100, rng)
    arm = dimensions_of(drawing.geometry)
    for drawn in rng.uniform(-3.0, 3.0, (100, 6)):
        q = drawing.joints_of(drawn)
        columns = np.array(jacobian_columns(arm, q)).T * drawing.signs
        np.testing.assert_allclose(columns, jacobian(drawn), atol=1e-12)
        c, s3, s5 = singularity_indices(arm, q)
        product = -arm.a2 * arm.a3 * c * s3 * s5 * math.prod(drawing.signs)
        assert np.linalg.det(jacobian(drawn)) == pytest.approx(product, abs=1e-13)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["irb-120", "kr-6-r900"])
def test_a_thousand_poses_on_all_branches(name):
    file = ARMS / f"{name}.urdf"
    judge(recognise(read_urdf(file)), mujoco_of(file)[0], 1000, np.random.default_rng(2))


@pytest.mark.parametrize("name", ["irb-120", "kr-6-r900"])
def test_arms_of_data_sheets_are_where_pinocchio_has_them(name):
    pin = pytest.importorskip("pinocchio")
    file = ARMS / f"{name}.urdf"
    model = pin.buildModelFromUrdf(str(file))
    data, tip = model.createData(), model.getFrameId("tool0")

    def place(q):
        pin.framesForwardKinematics(model, data, np.array(q))
        return np.array(data.oMf[tip].translation), np.array(data.oMf[tip].rotation)

    judge(recognise(read_urdf(file)), place, 100, np.random.default_rng(3))


def draw(seed, tmp_path):
    rng = np.random.default_rng((7, seed))
    lengths = draw_lengths(rng)
    arm = draw_arm(rng, lengths, rng.uniform(-1.3, 1.3, 6))
    file = tmp_path / "drawn.urdf"
    file.write_text(urdf_of(arm, rng))
    return lengths, arm, recognise(read_urdf(file)), rng


def judge_drawn(seed, tmp_path):
    lengths, arm, drawing, rng = draw(seed, tmp_path)
    judge(drawing, lambda q: posture_of(arm, q), 20, rng)
    for name in ("a2", "a3", "d6", "base_height", "a1"):
        assert drawing.lengths[name] == pytest.approx(lengths[name], abs=1e-9), name
    # The arm that looks the other way is the same one, with its shoulder on the other side.
    for name in ("elbow_offset", "shoulder_offset"):
        assert abs(drawing.lengths[name]) == pytest.approx(abs(lengths[name]), abs=1e-9), name


def test_drawn_arms_are_recognised(tmp_path):
    for seed in range(12):
        judge_drawn(seed, tmp_path)


@pytest.mark.slow
def test_many_drawn_arms_are_recognised(tmp_path):
    for seed in range(1000, 1150):
        judge_drawn(seed, tmp_path)


def chain_by_hand(rows, modified, tool):
    """Return the tool's matrix of a table as a function of its joints, factor by factor."""

    def about(axis, angle):
        c, s = math.cos(angle), math.sin(angle)
        if axis == "x":
            return np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])
        return np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])

    def along(x, z):
        return np.array([[1, 0, 0, x], [0, 1, 0, 0], [0, 0, 1, z], [0, 0, 0, 1]])

    def place(q):
        whole = np.eye(4)
        for (a, alpha, d, theta), angle in zip(rows, q, strict=True):
            first, second = about("z", theta + angle) @ along(0, d), along(a, 0) @ about("x", alpha)
            whole = whole @ (second @ first if modified else first @ second)
        whole = whole @ along(0, tool)
        return whole[:3, 3], whole[:3, :3]

    return place


HALF = math.pi / 2
STANDARD = [
    (0, HALF, 0.672, 0), (0.4318, 0, 0, 0), (0.0203, -HALF, 0.15005, 0),
    (0, HALF, 0.4318, 0), (0, -HALF, 0, 0), (0, 0, 0, 0),
]  # fmt: skip
MODIFIED = [
    (0, 0, 0.672, 0), (0, HALF, 0, 0), (0.4318, 0, 0.15005, 0),
    (0.0203, -HALF, 0.4318, 0), (0, HALF, 0, 0), (0, -HALF, 0, 0),
]  # fmt: skip


def table_of(rows, convention):
    joints = "".join(
        f"  - {{a: {a}, alpha: {alpha!r}, d: {d}, theta: {theta!r}}}\n"
        for a, alpha, d, theta in rows
    )
    return f"convention: {convention}\ntool: 56.25 mm\njoints:\n{joints}"


@pytest.mark.parametrize(("rows", "convention"), [(STANDARD, "standard"), (MODIFIED, "modified")])
def test_the_puma_in_both_conventions(rows, convention, tmp_path):
    file = tmp_path / "puma.yaml"
    file.write_text(table_of(rows, convention))
    drawing = recognise(read_dh(file))
    judge(
        drawing,
        chain_by_hand(rows, convention == "modified", 0.05625),
        60,
        np.random.default_rng(4),
    )
    shipped = recognise(read_dh(ARMS / "puma-560.yaml"))
    assert drawing.lengths == pytest.approx(shipped.lengths, abs=1e-12)
    assert shipped.lengths["shoulder_offset"] == pytest.approx(-0.15005)


@pytest.mark.parametrize("turned", [0.0, math.pi, -HALF])
def test_a_table_without_ranges_has_them_about_the_laws_zero(turned, tmp_path):
    """Where the table has its own zero says nothing of what a joint's cables bear."""
    rows = [*MODIFIED[:5], (0, -HALF, 0, turned)]
    file = tmp_path / "arm.yaml"
    file.write_text(table_of(rows, "modified"))
    made = of_dh("arm", file, None)
    assert "position_min: [-180 deg, -180 deg, -180 deg, -180 deg, -180 deg, -180 deg]" in made.text
    assert any("no range is given of row 1, " in note for note in made.notes)


def test_a_turn_of_ninety_radians_was_meant_in_degrees(tmp_path):
    file = tmp_path / "arm.yaml"
    file.write_text(table_of([(0, 90, 0, 0), *MODIFIED[1:]], "modified"))
    with pytest.raises(ConfigurationError, match=r"arm.yaml:4:19: .*at most 360 deg"):
        read_dh(file)


def test_a_table_in_no_convention_is_refused(tmp_path):
    file = tmp_path / "arm.yaml"
    file.write_text(table_of(STANDARD, "craig"))
    with pytest.raises(ConfigurationError, match=r"arm.yaml:1:13.*standard"):
        read_dh(file)


def test_a_wrist_that_does_not_meet_is_refused_with_every_gap(tmp_path):
    file = tmp_path / "ur.urdf"
    file.write_text(urdf_of(universal_robot(), np.random.default_rng(0)))
    with pytest.raises(DrawingError) as caught:
        recognise(read_urdf(file))
    message = str(caught.value)
    assert "axis 3 and axis 4 (q3, q4) are 0 degrees apart instead of 90" in message
    assert "axis 4 and axis 6 (q4, q6) pass 94.65 mm apart" in message


@pytest.mark.parametrize(
    ("joint", "lean", "reason"),
    [
        (1, 2.0, r"\(q2, q3\) are 2 degrees from parallel"),
        (3, 0.5, r"\(q3, q4\) are 89.5 degrees apart instead of 90"),
        (4, 3.0, r"\(q4, q5\) are 87 degrees apart instead of 90"),
    ],
)
def test_axes_that_lean_are_refused_with_the_angle(joint, lean, reason, tmp_path):
    rng = np.random.default_rng(5)
    arm = draw_arm(rng, draw_lengths(rng), (0.0,) * 6)
    across = np.cross(arm.axes[joint], arm.axes[joint - 1 if joint == 4 else joint + 1])
    if joint == 1:  # parallel ones span no plane
        across = np.cross(arm.axes[1], arm.axes[0])
    if joint == 3:
        across = np.cross(arm.axes[3], arm.axes[2])
    turn = np.cross(across / np.linalg.norm(across), arm.axes[joint])
    if joint == 1:
        turn = across / np.linalg.norm(across)
    angle = math.radians(lean)
    side = across / np.linalg.norm(across) if joint == 1 else turn
    arm.axes[joint] = math.cos(angle) * arm.axes[joint] + math.sin(angle) * side
    file = tmp_path / "leaning.urdf"
    file.write_text(urdf_of(arm, rng))
    with pytest.raises(DrawingError, match=reason):
        recognise(read_urdf(file))


def test_a_tool_beside_the_last_axis_is_refused_with_the_distance(tmp_path):
    rng = np.random.default_rng(6)
    arm = draw_arm(rng, draw_lengths(rng), rng.uniform(-1.0, 1.0, 6))
    side = np.cross(arm.axes[5], (0.3, 0.4, 0.5))
    arm = arm._replace(position=arm.position + 0.012 * side / np.linalg.norm(side))
    file = tmp_path / "beside.urdf"
    file.write_text(urdf_of(arm, rng))
    with pytest.raises(DrawingError, match=r"tool is 12 mm beside the axis of axis 6"):
        recognise(read_urdf(file))


def spun(rng, ranges, speed=3.0):
    """Return the text of a URDF whose joints have these ranges (rad) and a speed."""
    text = urdf_of(draw_arm(rng, draw_lengths(rng), np.zeros(6)), rng, ranges)
    return re.sub(r"velocity=\"[^\"]*\"", f'velocity="{speed}"', text)


def test_a_range_that_no_cable_bears_is_that_of_a_joint_without_end(tmp_path):
    rng = np.random.default_rng(5)
    file = tmp_path / "vast.urdf"
    file.write_text(spun(rng, [(-1000.0, 1000.0), *[(-1.5, 1.5)] * 4, (-1e308, 1e308)]))
    made = of_urdf("vast", file, None)
    limits = yaml.safe_load(made.text)["arm"]["geometry"]
    for k in (0, 5):
        assert (limits["position_min"][k], limits["position_max"][k]) == ("-360 deg", "360 deg")
    assert any("turn without end: two turns are their range" in note for note in made.notes)


@pytest.mark.parametrize(("speed", "behind"), [(3.0, 0.15), (15.0, 0.3)])
def test_fast_joints_may_be_farther_behind(tmp_path, speed, behind):
    file = tmp_path / "fast.urdf"
    file.write_text(spun(np.random.default_rng(6), [(-1.5, 1.5)] * 6, speed))
    limits = yaml.safe_load(of_urdf("fast", file, None).text)["arm"]["limits"]
    assert limits["following"] == f"{behind} rad"
