"""Places out of CSV and YAML files: drawn tables in drawn units, and drawn damage to them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from controllers.arm.places.poses import read_poses
from controllers.motion import InfeasibleMotion

LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6}
ANGLES = {"rad": 1.0, "deg": math.pi / 180.0, "mrad": 1e-3}
SEQUENCES = ("ZYX", "xyz", "ZYZ", "XYX", "zxy", "YZX")
KINDS = ("none", "quaternion", "vector", "euler", "direction", "spin")
REMARK = "remark"


def about(axis, angle):
    """Return the rotation about a coordinate axis."""
    c, s = math.cos(angle), math.sin(angle)
    i = "xyz".index(axis)
    turn = np.eye(3)
    j, k = (i + 1) % 3, (i + 2) % 3
    turn[j, j], turn[j, k], turn[k, j], turn[k, k] = c, -s, s, c
    return turn


def matrix_of(quaternion):
    w, x, y, z = np.array(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def of_vector(vector):
    """Return the rotation of a rotation vector, by the series of the matrix exponential."""
    x, y, z = vector
    skew, term, total = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]), np.eye(3), np.eye(3)
    for k in range(1, 40):
        term = term @ skew / k
        total = total + term
    return total


class DrawnTable:
    """A table of a drawn kind with the poses that it means, written in either format."""

    def __init__(self, seed):
        rng = np.random.default_rng((71, seed))
        self.kind = KINDS[seed % len(KINDS)]
        count = int(rng.integers(2, 9))
        self.places = rng.uniform(-0.6, 0.6, (count, 3))
        columns = [
            self._scaled(name, LENGTHS, of, rng)
            for name, of in zip("xyz", self.places.T, strict=True)
        ]
        self.rotations = self.directions = self.spins = None
        if self.kind == "quaternion":
            q = rng.normal(size=(count, 4))
            q /= np.linalg.norm(q, axis=1)[:, None]
            self.rotations = [matrix_of(row) for row in q]
            columns += [(name, of) for name, of in zip(("qw", "qx", "qy", "qz"), q.T, strict=True)]
        elif self.kind == "vector":
            vectors = rng.normal(size=(count, 3))
            self.rotations = [of_vector(row) for row in vectors]
            names = (f"rotvec_{axis}" for axis in "xyz")
            columns += [
                self._scaled(name, ANGLES, of, rng)
                for name, of in zip(names, vectors.T, strict=True)
            ]
        elif self.kind == "euler":
            axes, angles = str(rng.choice(SEQUENCES)), rng.uniform(-3.0, 3.0, (count, 3))
            for a, b, c in angles:
                turns = [
                    about(axis.lower(), angle) for axis, angle in zip(axes, (a, b, c), strict=True)
                ]
                if axes.islower():  # fixed axes: the first turn is the innermost
                    turns.reverse()
                self.rotations = [*(self.rotations or []), turns[0] @ turns[1] @ turns[2]]
            names = (f"euler-{axes}-{k}" for k in (1, 2, 3))
            columns += [
                self._scaled(name, ANGLES, of, rng)
                for name, of in zip(names, angles.T, strict=True)
            ]
        elif self.kind in ("direction", "spin"):
            vectors = rng.normal(size=(count, 3))
            self.directions = vectors / np.linalg.norm(vectors, axis=1)[:, None]
            columns += [(f"tool_{axis}", of) for axis, of in zip("xyz", vectors.T, strict=True)]
            if self.kind == "spin":
                self.spins = rng.uniform(-3.0, 3.0, count)
                columns.append(self._scaled("spin", ANGLES, self.spins, rng))
        if rng.random() < 0.3:
            columns.append((REMARK, np.arange(count)))
        rng.shuffle(columns)
        self.header = [name for name, _ in columns]
        self.cells = [
            [repr(float(v)) for v in row] for row in zip(*(of for _, of in columns), strict=True)
        ]

    def _scaled(self, name, units, values, rng):
        unit = str(rng.choice(list(units)))
        return f"{name} ({unit})", values / units[unit]

    def written(self, folder, suffix):
        file = folder / f"places.{suffix}"
        if suffix == "csv":
            lines = [", ".join(self.header), *(", ".join(row) for row in self.cells)]
        else:
            lines = [f"columns: [{', '.join(self.header)}]", "rows:"]
            lines += [f"  - [{', '.join(row)}]" for row in self.cells]
        file.write_text("\n".join(lines) + "\n", encoding="utf-8")
        return file


@pytest.mark.parametrize("suffix", ["csv", "yaml"])
@pytest.mark.parametrize("seed", range(36))
def test_a_file_says_the_same_whatever_its_units_order_and_format(seed, suffix, tmp_path):
    table = DrawnTable(seed)
    poses = read_poses(table.written(tmp_path, suffix))
    np.testing.assert_allclose(poses.places, table.places, rtol=1e-12)
    if table.rotations is None:
        assert poses.quaternions is None
    else:
        turns = [matrix_of(quaternion) for quaternion in poses.quaternions]
        np.testing.assert_allclose(turns, table.rotations, atol=1e-12)
    for told, meant in ((poses.directions, table.directions), (poses.spins, table.spins)):
        if meant is None:
            assert told is None
        else:
            np.testing.assert_allclose(told, meant, rtol=1e-12, atol=1e-15)


def damaged(table, rng, suffix, folder):
    """Return a file with one cell that is wrong, the line of that cell and its column."""
    row, column = int(rng.integers(len(table.cells))), 0
    known = [k for k, name in enumerate(table.header) if name != REMARK]
    column = int(rng.choice(known))
    name = table.header[column].split(" ")[0]
    wrong = str(rng.choice(["", "nan", "1,5", "1_0", "one", "inf", "1e400", "1e9"]))
    if wrong == "1e9" and (name.startswith(("tool_", "q"))):
        wrong = "0x10"
    if suffix == "yaml" and wrong == "1,5":
        wrong = "'1,5'"
    if suffix == "yaml" and wrong == "":
        wrong = "''"
    table.cells[row][column] = wrong
    named = name if not name.startswith("euler-") else f"euler-{name[-1]}"
    return table.written(folder, suffix), row + 2 + (suffix == "yaml"), named


@pytest.mark.parametrize("suffix", ["csv", "yaml"])
@pytest.mark.parametrize("seed", range(60))
def test_a_wrong_cell_is_named_with_file_line_and_column(seed, suffix, tmp_path):
    rng = np.random.default_rng((72, seed))
    file, line, name = damaged(DrawnTable(seed), rng, suffix, tmp_path)
    with pytest.raises(InfeasibleMotion) as refused:
        read_poses(file)
    assert str(refused.value).startswith(f"{file}, line {line}"), str(refused.value)
    if "cells under a header" not in str(refused.value):  # a decimal comma is two cells
        assert f"({name})" in str(refused.value), str(refused.value)


def refusal(tmp_path, text, suffix="csv"):
    file = tmp_path / f"places.{suffix}"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InfeasibleMotion) as refused:
        read_poses(file)
    return str(refused.value).removeprefix(str(file))


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("x (mm), y (mm), z (mm), spin (deg)", ", line 1: the header has a spin, which is about"),
        ("x (mm), y (mm), z (mm), tool_x, tool_y", "and all of tool_x, tool_y, tool_z or none"),
        ("x (mm), y (mm), z (mm), tool_x (m), tool_y, tool_z", ", column 4: tool_x has no unit; "),
        ("x (mm), y (mm), z (mm), spni (deg)", ", column 4: no column is called 'spni'; did you"),
        ("X (mm), y (mm), z (mm)", ", column 1: no column is called 'X'; did you mean x?"),
        ("x (mm), y (mm), z (mm), x (m)", ", column 4: x is there already."),
        (
            "x (mm), y (mm), z (mm), qw, qx, qy, qz, tool_x, tool_y, tool_z",
            "says how the tool stands in two ways, qw … and tool_x …; leave one out",
        ),
        (
            "x (m), y (m), z (m), euler-ZYX-1 (deg), euler-ZYZ-2 (deg), euler-ZYX-3 (deg)",
            "column 5: the angles are about ZYX in one column and about ZYZ in this one",
        ),
        (
            "x (m), y (m), z (m), euler-ZZX-1 (deg), euler-ZZX-2 (deg), euler-ZZX-3 (deg)",
            "column 4: ZZX turns about one axis twice on end",
        ),
        ("x (m), y (m), z (m), rotvec_x (m)", "the unit of rotvec_x is m; write rotvec_x (deg)"),
    ],
)
def test_what_is_wrong_with_a_header_is_said(header, said, tmp_path):
    count = header.count(",") + 1
    assert said in refusal(tmp_path, f"{header}\n{', '.join(['1'] * count)}\n")
    assert said.split("column")[-1].split(": ")[-1] in refusal(
        tmp_path, f"columns: [{header}]\nrows: []\n", "yaml"
    )


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", ": the file is empty"),
        ("- 1\n", ", line 1, column 1: the document has to be a mapping"),
        ("columns: [x (m), y (m), z (m)]\n", "the file has no rows."),
        ("rows: []\n", "the file has no columns."),
        ("rows: []\nrows: []\n", ", line 2, column 1: rows is there already."),
        ("row: []\n", ", line 1, column 1: 'row' is no key; there are columns and rows."),
        ("columns: &a [x (m)]\n", ", line 1, column 10: anchors, aliases and tags have no place"),
        ("columns: [!!str x]\n", ", line 1, column 11: anchors, aliases and tags have no place"),
        ("columns: [[x]]\n", ", line 1, column 11: columns has to be a list of names"),
        ("rows: {a: 1}\n", ", line 1, column 7: rows has to be a list of lists"),
        ("rows:\n  - 1\n", ", line 2, column 5: a row has to be a list of numbers."),
        ("rows: [[1\n", ", line 2, column 1: "),
        ("columns: []\nrows: []\n---\na: 1\n", ", line 4, column 1: a second document"),
        ("x: \x00\n", ": it is not YAML: "),
        (
            "columns: [x (m), y (m), z (m)]\nrows:\n- [1, 2, 1000]\n",
            "1000 m is outside -100 m … 100",
        ),
        (
            "columns: [x (mm), y (m), z (m), tool_x, tool_y, tool_z]\nrows:\n- [1, 2, 1, 0, 0, 0]",
            ", line 3: (0, 0, 0) is no direction of the tool.",
        ),
    ],
)
def test_what_is_wrong_with_a_document_is_said_with_its_place(text, said, tmp_path):
    assert said in refusal(tmp_path, text, "yaml")


SCRAPS = st.sampled_from(
    [*"[]{}:,-&*!|>'\"#%@\n\t \x00", "columns", "rows", "x (mm)", "y (m)", "1", "\n- ", "---", "<<"]
)


@given(st.lists(SCRAPS, max_size=40).map("".join))
def test_scraps_of_a_document_are_refused_and_nothing_else(tmp_path_factory, text):
    file = tmp_path_factory.mktemp("scraps") / "places.yaml"
    file.write_text(text, encoding="utf-8", newline="")
    try:
        read_poses(file)
    except InfeasibleMotion as error:
        assert str(error).startswith(str(file))


def test_yaml_may_not_be_so_long_that_nobody_waits_for_it(tmp_path):
    rows = "- [1, 2, 3]\n" * 100_000
    assert "more than" in refusal(
        tmp_path, f"columns: [x (m), y (m), z (m)]\nrows:\n{rows}", "yaml"
    )


def test_a_remark_and_an_empty_line_count_for_nothing(tmp_path):
    file = tmp_path / "places.csv"
    file.write_text("no, x (mm), y (mm), z (mm),\n1, 1, 2, 3,\n\n2, 4, 5, 6,\n", encoding="utf-8")
    np.testing.assert_allclose(read_poses(file).places, [[1e-3, 2e-3, 3e-3], [4e-3, 5e-3, 6e-3]])
