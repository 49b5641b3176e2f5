"""The page of a campaign fits its window, and says what was drawn and no more."""

from dataclasses import replace

import pytest
from page_in_browser import browser, until

from rig.faults.case import Break, Case, Moment
from rig.faults.kind import Must
from rig.faults.oracle import Violation
from rig.faults.page import MOST_CASES, write_page
from rig.faults.table import PASSES, WRONGS, Row
from rig.faults.uncounted import say_uncounted
from rig.faults.verdict import CaseEnding, Verdict

CASE = Case("joint", "joint-circle", 1, Moment.RUN, 0.5, Break("leak", "plant ch1", 2e-8, 1e9))
OUT = Violation("position", "position", 1.05, -0.0301, -0.024, "m")
NEVER = Row("nothing", "arm-odrive", 1, ((1, 0),) * len(Moment), (1, 0, 0), (0,) * 7, (), 5e-3)


def full(fault, count):
    """Return a row that has something in each of its cells."""
    return Row(
        fault, "cylinder-valves", 100 * count, ((count, 1),) * len(Moment), (count,) * len(PASSES),
        (count,) * len(WRONGS), (0.0106, 0.521, 0.582), 1e-3,
    )  # fmt: skip


@pytest.mark.parametrize("width", [1500, 1600])
def test_the_widest_table_fits_the_window(tmp_path, width):
    page = tmp_path / "campaign.html"
    names = ("setpoints_out_of_order", "servo_encoder_mirrored", "two at once", "all")
    write_page(page, "Faults of everything", [full(name, 12) for name in names], [])
    with browser() as opened:
        shown = opened.new_page(viewport={"width": width, "height": 900})
        shown.goto(page.as_uri())
        until(shown, "document.querySelectorAll('.wide').length == 1")
        table, room = shown.evaluate(
            "(() => { const e = document.querySelector('.wide');"
            " return [e.scrollWidth, e.clientWidth]; })()"
        )
    assert table <= room


def test_columns_in_which_there_is_nothing_are_named_and_left_out(tmp_path):
    page = tmp_path / "campaign.html"
    write_page(page, "Faults", [NEVER], [])
    text = page.read_text()
    assert "None: hazards, unseen, misnamed, false trips, late, crashed, never, cycles" in text
    assert ">hazards</th>" not in text
    assert ">excused</th>" in text, "what went well is told in any case"


@pytest.mark.parametrize(
    ("kind", "told", "untold"),
    [
        ("carriage_push", "A push that is stronger", "mechanical stop"),
        ("wire_cut", "the mechanical stop has to bear it", "A push"),
        ("leak", "the mechanical stop has to bear it", "A push"),
        ("safe_torque_off", "lost its torque", "mechanical stop"),
    ],
)
def test_what_is_not_counted_is_told_of_what_was_drawn_alone(kind, told, untold):
    case = replace(CASE, first=replace(CASE.first, kind=kind))
    came = CaseEnding(4, "it broke", 1.0, 1.01, excused=(OUT,))
    seen = Verdict(case, came, Must.SAFE, 0.1)
    assert say_uncounted([replace(seen, ending=replace(came, excused=()))]) == ""
    said = say_uncounted([seen])
    assert said.startswith(f"not counted: what nothing could keep off after {kind}. ")
    assert told in said
    assert untold not in said


def test_a_page_has_each_of_a_few_cases_and_of_many_those_that_need_a_look(tmp_path):
    page = tmp_path / "campaign.html"
    quiet = Verdict(CASE, CaseEnding(4, "a tube is off", 1.0, 1.01), Must.SAFE, 0.1)
    excused = replace(quiet, ending=replace(quiet.ending, excused=(OUT,)))
    write_page(page, "Faults", [NEVER], [quiet, excused])
    few = page.read_text()
    assert few.count("a tube is off") == 2
    assert "position: -30.1 mm beyond -24 mm" in few and "50 ms after it broke" in few
    write_page(page, "Faults", [NEVER], [quiet] * MOST_CASES + [excused])
    many = page.read_text()
    assert many.count("a tube is off") == 1 and "50 ms after it broke" in many
