"""The table of a comparison: units that do not change within a row, and who has no numbers."""

import json

from rig.cli.compared_table import saying_never, table_lines


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


def metric(name, value, **more):
    return {"name": name, "value": value, "unit": "s", **more}


def test_what_never_came_is_told_as_in_every_other_table(tmp_path):
    first, second = tmp_path / "first", tmp_path / "second"
    unseen = {"bound": 1.0, "pass": None}
    for run, metrics in (
        (first, [metric("rise", 1.0), metric("settling", None), metric("still", None, **unseen)]),
        (second, [metric("rise", None), metric("settling", None, is_nan=True)]),
    ):
        run.mkdir()
        (run / "metrics.json").write_text(json.dumps({"metrics": metrics}))
    rows = [
        row("rise", "s", 1.0, None, None),
        row("settling", "s", None, None, "refused"),
        row("still", "s", None, None, None),
        row("of another kind", "s", None, 2.0, None),
    ]
    assert [one["values"] for one in saying_never(rows, [first, second])] == [
        [1.0, "never", None],
        ["never", None, "refused"],
        [None, None, None],
        [None, 2.0, None],
    ]
    assert rows[0]["values"] == [1.0, None, None]  # compare.json has what it had
