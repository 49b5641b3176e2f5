"""The table of a comparison: units that do not change within a row, and who has no numbers."""

from rig.cli.compared_table import table_lines


def row(name, unit, *values):
    return {"name": name, "unit": unit, "bound": None, "bound_kind": None, "values": list(values)}


def test_a_row_has_one_unit_that_suits_its_greatest():
    rows = [
        row("deviation", "m", 0.4, 1e-10, None),
        row("distance", "m", -1.2, 0.6, "halts"),
        row("share", "", 1.5, 0.0, 1),
    ]
    ok = dict.fromkeys("abc", "ok")
    assert [line.split() for line in table_lines("abc", rows, ok, {})] == [
        ["a", "b", "c"],
        ["deviation", "400", "mm", "1e-07", "mm", "-"],
        ["distance", "-1.2", "m", "0.6", "m", "halts"],
        ["share", "1.5", "0", "1"],
    ]


def test_who_did_not_end_well_is_told_in_a_row_of_its_own():
    rows = [row("share", "", 1.0, None)]
    lines = table_lines(("one", "two"), rows, {"one": "ok", "two": "faulted"}, {"one": "stable"})
    assert [line.split() for line in lines[-2:]] == [
        ["run", "ok", "faulted"],
        ["linear", "loop", "stable", "unknown"],
    ]
