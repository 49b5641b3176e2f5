"""Twists in a file: units from its header, and every error with its line."""

import math

import pytest

from controllers.arm.online.commands import TwistRows, twist_at
from controllers.arm.online.twist_file import read_rows
from controllers.motion import InfeasibleMotion


def written(tmp_path, text):
    path = tmp_path / "twists.csv"
    path.write_text(text)
    return path


def test_units_stand_in_the_header(tmp_path):
    path = written(
        tmp_path,
        "t (ms), vx (mm/s), vy (cm/s), vz (m/s), wx (deg/s), wy (rad/s), wz (deg/s)\n"
        "# begin, then stop\n0, 100, 20, 0.3, 90, 0.5, -180\n\n250, 0, 0, 0, 0, 0, 0\n",
    )
    (line, first), (last_line, last) = read_rows(path)
    assert (line, last_line) == (3, 5)
    assert first == pytest.approx((0.0, 0.1, 0.2, 0.3, math.pi / 2, 0.5, -math.pi))
    assert last == (0.25, *(0.0,) * 6)


def test_the_tool_need_not_turn_and_columns_come_in_any_order(tmp_path):
    rows = read_rows(written(tmp_path, "vz (m/s),t (s),vx (m/s),vy (m/s)\n3,0,1,2\n0,1,0,0\n"))
    assert rows[0][1] == (0.0, 1.0, 2.0, 3.0, 0.0, 0.0, 0.0)


HEADER = "t (s), vx (m/s), vy (m/s), vz (m/s)\n"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the file is empty; its header begins with t (s)"),
        ("# only words\n", "the file is empty"),
        ("# words\n,\n", "line 2: the column '' is unknown"),
        ('"t (s)\n', "line 1: unexpected end of data"),
        ("t (s), vx, vy (m/s), vz (m/s)\n", "the unit of vx is missing"),
        ("t (s), vx (rad/s), vy (m/s), vz (m/s)\n", "the unit of vx is rad/s"),
        ("t (s), vx (m/s), vy (m/s)\n", "has to name t, vx, vy and vz"),
        ("t (s), vx (m/s), vy (m/s), vz (m/s), wx (rad/s)\n", "all of wx, wy, wz or none"),
        ("t (s), vx (m/s), vx (m/s), vz (m/s)\n", "'vx (m/s)' is there twice"),
        ("t (s), speed (m/s), vy (m/s), vz (m/s)\n", "'speed (m/s)' is unknown"),
        (HEADER + "0, 1, 0, x\n", "line 2: 'x' is no number"),
        (HEADER + "0, 1, 0, 1_0\n", "line 2: '1_0' is no number"),
        (HEADER + "0, 1, 0, ٣\n", "line 2: '٣' is no number"),
        (HEADER + "0, 1, 0, nan\n", "line 2: 'nan' is no number"),
        (HEADER + "0, 1, 0\n", "line 2: 3 values, the header has 4"),
        (HEADER + "0, 1, 0, 0\n", "the last of two rows says the end"),
        (HEADER + "0, 1, 0, 0\n0, 0, 0, 0\n", "line 3 is for 0 s, and must be after line 2"),
        (HEADER + "-1, 1, 0, 0\n0, 0, 0, 0\n", "line 2 is for -1 s, before the beginning"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, text, said):
    path = written(tmp_path, text)
    with pytest.raises(InfeasibleMotion) as caught:
        TwistRows(file=str(path)).known()
    assert said in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InfeasibleMotion, match=r"no-such\.csv"):
        TwistRows(file=str(tmp_path / "no-such.csv")).known()


def test_a_row_holds_until_the_next_and_the_last_one_ends_it():
    rows = [(0.5, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0), (1.0, 2.0, *(0.0,) * 5), (2.0, 9.0, *(0.0,) * 5)]
    told = [twist_at(rows, t)[0] for t in (0.0, 0.499, 0.5, 0.999, 1.0, 1.999, 2.0, 3.0)]
    assert told == [0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 0.0, 0.0]


def test_a_file_and_rows_exclude_each_other():
    with pytest.raises(ValueError, match="a file or rows"):
        TwistRows()
    with pytest.raises(ValueError, match="a file or rows"):
        TwistRows(file="a.csv", rows=((0.0,) * 7, (1.0,) * 7))


def test_a_twist_that_no_arm_has_is_refused_with_its_row():
    fast = (0.5, 0.0, -1e300, 0.0, 0.0, 0.0, 0.0)
    rows = ((0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0), fast, (1.0, *[0.0] * 6))
    with pytest.raises(InfeasibleMotion, match=r"row 2 asks for -1e\+300"):
        TwistRows(rows=rows).known()
