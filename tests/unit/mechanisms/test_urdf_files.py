"""URDFs of strangers: bounded, without entities, and nothing of them but their joints."""

import numpy as np
import pytest
from drawn_arms import draw_arm, draw_lengths, urdf_of

from rig.mechanisms.arm.drawing.chain import DrawingError
from rig.mechanisms.arm.drawing.spherical_wrist import recognise
from rig.mechanisms.arm.drawing.urdf import read_urdf

RNG = np.random.default_rng(11)
ARM = draw_arm(RNG, draw_lengths(RNG), (0.1, 0.2, 0.3, 0.4, 0.5, 0.6))
TEXT = urdf_of(ARM, RNG)


@pytest.fixture
def read(tmp_path):
    def reading(text, tip=None):
        file = tmp_path / "arm.urdf"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_urdf(file, tip)

    return reading


def test_the_limits_of_its_joints_are_read(read):
    chain = read(TEXT)
    assert [joint.name for joint in chain.joints] == [f"axis {k}" for k in range(1, 7)]
    assert {(j.lower, j.upper, j.speed, j.effort) for j in chain.joints} == {(-3, 3, 2.5, 40)}
    endless = read(TEXT.replace('"axis 1" type="revolute"', '"axis 1" type="continuous"'))
    assert np.isinf(endless.joints[0].upper)
    silent = read(TEXT.replace('velocity="2.5" effort="40"', 'velocity="0"'))
    assert silent.joints[0].speed is None
    assert silent.joints[0].effort is None


def test_meshes_and_files_are_not_looked_for(read, tmp_path):
    trap = tmp_path / "trap"
    parts = (
        f'<visual><geometry><mesh filename="file://{trap}"/></geometry></visual>'
        f'<collision><geometry><mesh filename="{trap}"/></geometry></collision>'
        '<inertial><mass value="nan"/></inertial>'
    )
    dressed = TEXT.replace('<link name="link 3"/>', f'<link name="link 3">{parts}</link>')
    dressed = dressed.replace("<link", f'<mujoco><compiler meshdir="{trap}"/></mujoco><link', 1)
    dressed = dressed.replace("<link", f'<include file="{trap}"/><link', 1)
    plain = recognise(read(TEXT))
    assert recognise(read(dressed)).lengths == plain.lengths


ENTITY = '<!DOCTYPE robot [<!ENTITY all SYSTEM "file:///etc/hostname">]>'
LAUGHS = (
    '<!DOCTYPE robot [<!ENTITY a "ha">'
    + "".join(
        f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefgh", "bcdefghi", strict=True)
    )
    + "]>"
)


@pytest.mark.parametrize("doctype", [ENTITY, LAUGHS, "<!DOCTYPE robot SYSTEM 'http://x/y'>"])
def test_a_document_type_is_refused_before_it_is_used(read, doctype):
    text = TEXT.replace("<robot", doctype + "<robot").replace('"drawn"', '"&i;"')
    with pytest.raises(DrawingError, match=r"line 2: a URDF has no document type"):
        read(text)
    # In another encoding it is no text here, whatever the file says.
    with pytest.raises(DrawingError, match=r"arm\.urdf"):
        read(text.encode("utf-16"))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "no element"),
        ("no: yaml", "no XML"),
        ("<robot/>", "it has no joints"),
        ("<robot>" + "<a>" * 100, "elements deep"),
        ("<robot>" + "<a/>" * 20_001, "20000 long"),
        ("<robot>" + "".join(f"<joint name='{k}'/>" for k in range(1001)), "1000 joints"),
        ("<robot>" + "&b;" + "</robot>", "undefined entity"),
        (TEXT.replace("axis 2", "axis 1"), "'axis 1' is no joint's own name"),
        (TEXT.replace('"axis 3" type="revolute"', '"axis 3" type="prismatic"'), "prismatic"),
        (
            TEXT.replace('"axis 3" type="revolute"', '"axis 3" type="fixed"'),
            "six joints; 5 lead to tool",
        ),
        (TEXT.replace('"axis 3" type="revolute"', '"axis 3" type="odd"'), "axis 3 is odd"),
        (TEXT.replace("<limit", '<mimic joint="axis 1"/><limit', 1), "axis 1 follows another"),
        (TEXT.replace('lower="-3.0"', 'lower="3.0"', 1), "the range of axis 1 is empty"),
        (TEXT.replace('lower="-3.0"', 'lower="nan"', 1), "'nan', no number"),
        (
            TEXT.replace('velocity="2.5"', 'velocity="1e-12"', 1),
            "velocity of axis 1 is 1e-12 rad/s",
        ),
        (TEXT.replace('velocity="2.5"', 'velocity="-2.5"', 1), "is -2.5 rad/s, and of a robot"),
        (TEXT.replace('effort="40"', 'effort="1e300"', 1), "effort of axis 1 is 1e.300 N m"),
        (TEXT.replace('lower="-3.0"', 'lower="${-pi}"', 1), r"'\$\{-pi\}', no number"),
        (TEXT.replace('parent link="root"', 'parent link="tool"'), "they end nowhere"),
        (TEXT.replace('xyz="', 'xyz="1e9 '), "xyz of origin of axis 1 is '1e9 "),
        (TEXT.replace('rpy="', 'rpy="nan '), "no three numbers below 100"),
        (TEXT.replace("<axis xyz=", "<axis xyz='0 0 0' was="), "axis of axis 1 has no direction"),
        (TEXT.replace('xyz="', 'xyz="1e300 ').replace(" ", "1e300 ", 1), "arm.urdf"),
    ],
)
def test_what_is_no_arm_is_refused_with_the_reason(read, text, reason):
    with pytest.raises(DrawingError, match=reason):
        recognise(read(text))


def test_which_link_is_the_tool(read):
    grip = (
        '<link name="grip"/><joint name="hold" type="fixed"><parent link="link 6"/>'
        '<child link="grip"/></joint></robot>'
    )
    two = TEXT.replace("</robot>", grip)
    with pytest.raises(DrawingError, match=r"--tip: tool, grip"):
        read(two)
    assert read(two, "tool").tip == "tool"
    assert read(two.replace('"grip"', '"tool0"')).tip == "tool0"
    with pytest.raises(DrawingError, match=r"no joint leads to 'elbow'; links are link 1"):
        read(TEXT, "elbow")


def test_a_file_that_is_none(tmp_path):
    with pytest.raises(DrawingError, match=r"none.urdf"):
        read_urdf(tmp_path / "none.urdf")
    with pytest.raises(DrawingError, match="not a regular file"):
        read_urdf(tmp_path)


@pytest.mark.parametrize("text", ['name="axis 6"', 'type="revolute"', 'link="link 3"'])
def test_a_name_that_no_screen_shows_is_refused(read, text):
    key, _, value = text.partition("=")
    with pytest.raises(DrawingError, match="more than 200 characters") as refused:
        read(TEXT.replace(text, f'{key}={value[:-1]}{"x" * 100_000}"'))
    assert len(str(refused.value)) < 1000


def test_a_link_that_two_joints_lead_to_and_a_joint_without_links_are_refused(read):
    second = (
        '<joint name="other" type="fixed"><parent link="link 1"/><child link="link 3"/></joint>'
    )
    with pytest.raises(DrawingError, match=r"other leads to link 3, and so does axis \d of line"):
        read(TEXT.replace("</robot>", second + "</robot>"))
    with pytest.raises(DrawingError, match="other names no parent link"):
        read(TEXT.replace("</robot>", '<joint name="other" type="fixed"/></robot>'))
