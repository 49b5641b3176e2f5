"""Pages that other packages write: of the one builder, so escaped, with a policy and readable."""

import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from test_accessible_pages import Tree, inside

import rig
from rig.commissioning.page import write_page

PACKAGE = Path(rig.__file__).parent
HOSTILE = "<script>alert(1)</script><img src=x onerror=alert(2)>"
BUILDERS = {"report/markup.py", "watching/server.py"}


@pytest.fixture
def page(tmp_path):
    """The page of a record whose every text came from somebody else."""
    keys = ("backend", "operator", "date", "valid_until", "program", "digest")
    found = {"measured_in_words": [HOSTILE, "3 mm"], "said": HOSTILE, "passed": False}
    step = SimpleNamespace(name=HOSTILE, does=HOSTILE, expects=HOSTILE)
    record = {"rig": "mine", "steps": {HOSTILE: found}, **dict.fromkeys(keys, HOSTILE)}
    (tmp_path / "commissioning").mkdir()
    return write_page(tmp_path, record, [step]).read_text()


def test_what_somebody_wrote_is_text_on_the_page_of_an_acceptance_test(page):
    tree = Tree(page)
    assert {entry["tag"] for entry in tree.all} & {"script", "img"} == set()
    assert page.count("&lt;script&gt;") >= 11 and "Content-Security-Policy" in page


def test_it_has_a_language_a_main_part_and_tables_that_scroll(page):
    tree = Tree(page)
    assert tree.of("html")[0]["lang"] == "en" and len(tree.of("main")) == 1
    title = [entry["text"] for entry in tree.of("h1")]
    assert title == ["mine: acceptance test, rehearsal in simulation"]
    for table in tree.of("table"):
        assert [entry for entry in tree.of("th") if inside(entry, table)]
        assert table["parent"]["tabindex"] == "0" and table["parent"]["aria-label"]
    assert "FAILED" in [e["text"] for e in tree.of("span") if e.get("class") == "fail"]


def test_no_other_module_makes_pages():
    made = re.compile(r"<(!doctype|html|style)\b", re.IGNORECASE)
    writing = {
        str(path.relative_to(PACKAGE))
        for path in PACKAGE.rglob("*.py")
        if made.search(path.read_text(encoding="utf-8"))
    }
    assert writing == BUILDERS
