"""The page of a campaign fits its window, and says what was drawn and no more."""

from dataclasses import replace

import pytest
from page_in_browser import browser, until

from rig.faults.case import Break, Case, Moment
from rig.faults.page import write_page
from rig.faults.table import PASSES, WRONGS, Row
from rig.faults.uncounted import say_uncounted

CASE = Case("joint", "joint-circle", 1, Moment.RUN, 0.5, Break("leak", "plant ch1", 2e-8, 1e9))
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
    said = say_uncounted([replace(CASE, first=replace(CASE.first, kind=kind))])
    assert said.startswith(f"not counted: what nothing could keep off after {kind}. ")
    assert told in said
    assert untold not in said
