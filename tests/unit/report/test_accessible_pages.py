"""A report for who uses a keyboard, a screen reader or a telephone."""

import re
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import pytest

import rig.report
from rig.report.markup import page, section, table
from rig.report.regenerate import write_report

CSS = Path(rig.report.__file__).with_name("report.css").read_text()
VOID = ("meta", "img", "br")


class Tree(HTMLParser):
    """Every element with its attributes, its text and the elements around it."""

    def __init__(self, text):
        super().__init__()
        self.around, self.all = [], []
        self.feed(text)
        assert not self.around

    def handle_starttag(self, tag, attrs):
        entry = {"tag": tag, "text": "", **dict(attrs), "in": [e["tag"] for e in self.around]}
        entry["parent"] = self.around[-1] if self.around else None
        self.all.append(entry)
        if tag not in VOID:
            self.around.append(entry)

    def handle_endtag(self, tag):
        assert self.around.pop()["tag"] == tag

    def handle_data(self, data):
        for entry in self.around:
            entry["text"] += data

    def of(self, tag):
        return [entry for entry in self.all if entry["tag"] == tag]


@pytest.fixture
def tree(make_run):
    return Tree(write_report(make_run(duration=2.0)).page.read_text())


def test_a_page_has_a_language_a_title_one_main_part_and_headings_in_order(tree):
    assert tree.of("html")[0]["lang"] == "en" and tree.of("title")[0]["text"].strip()
    assert len(tree.of("main")) == 1 and len(tree.of("h1")) == 1
    levels = [int(e["tag"][1]) for e in tree.all if re.fullmatch("h[1-6]", e["tag"])]
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_every_table_has_headers_with_text_and_scope(tree):
    tables = tree.of("table")
    assert len(tables) >= 4
    for one in tables:
        own = [e for e in tree.of("th") if e is not None and inside(e, one)]
        assert own and all(e["text"].strip() and e["scope"] in ("col", "row") for e in own)


def inside(entry, other):
    while entry is not None:
        if entry is other:
            return True
        entry = entry["parent"]
    return False


def test_what_scrolls_takes_focus_and_has_a_name(tree):
    scrolling = re.findall(r"\.(\w+) \{[^}]*overflow-x: auto", CSS)
    assert scrolling == ["wide"] and "overflow-x" not in CSS.replace("overflow-x: auto", "", 1)
    for entry in tree.all:
        if entry.get("class") == "wide":
            assert entry["tabindex"] == "0" and entry["role"] == "region"
            assert entry["aria-label"].strip()
    names = [e["aria-label"] for e in tree.all if e.get("role") == "region"]
    assert len(names) == len(set(names)) == len(tree.of("table"))


def test_every_picture_and_link_has_a_text(tree):
    assert tree.of("img") and all(e["alt"].strip() for e in tree.of("img"))
    assert tree.of("a") and all(e["text"].strip() for e in tree.of("a"))


def luminance(colour):
    parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_text_stands_out_from_what_is_behind_it():
    colours = dict(re.findall(r"--(\w+): (#[0-9a-f]{6})", CSS))
    pairs = [(colours[name], colours["paper"]) for name in ("ink", "soft", "good", "bad", "calm")]
    pairs += [("#ffffff", colours[name]) for name in ("good", "bad", "calm")]
    pairs += [("#ffffff", "#6b5b00"), (colours["ink"], colours["wash"])]
    for text, behind in pairs:
        dark, light = sorted((luminance(text), luminance(behind)))
        assert (light + 0.05) / (dark + 0.05) >= 4.5, (text, behind)  # WCAG 2.1, 1.4.3


def test_nothing_is_wider_than_a_narrow_screen():
    """What has a width of its own is in a part that scrolls, or shrinks to the page."""
    assert "@media (max-width: 30rem)" in CSS
    assert re.search(r"figure img \{[^}]*max-width: 100%", CSS)
    assert re.search(r"pre \{[^}]*white-space: pre-wrap", CSS)
    assert not re.search(r"(?<!max-)(?<!min-)width: \d+(px|rem|em)", CSS)
    text = page("t", section("s", table("name", ("a",), [("x" * 500,)])))
    assert 'name="viewport" content="width=device-width' in text
