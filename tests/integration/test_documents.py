"""What is written for people: links lead somewhere, and what is made from code is what it says."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    path
    for path in ROOT.rglob("*.md")
    if not {"runs", "build", "node_modules"} & set(path.relative_to(ROOT).parts)
    and not any(part.startswith(".venv") for part in path.relative_to(ROOT).parts)
)


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    for title in re.findall(r"^#+ (.+)$", page.read_text(), re.M):
        kept = re.sub(r"[^\w\- ]", "", title.strip().lower())
        yield kept.replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_link_leads_somewhere(page):
    text = re.sub(r"```.*?```|`[^`\n]*`", "", page.read_text(), flags=re.S)
    broken = []
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", link):
            continue
        where, _, anchor = link.partition("#")
        target = page.parent / where if where else page
        there = target.exists() and (not anchor or anchor in anchors(target))
        broken += [] if there else [link]
    assert broken == []


def test_the_reference_is_what_the_code_says():
    made = subprocess.run([sys.executable, ROOT / ".readme/reference.py", "--check"], check=False)
    assert made.returncode == 0, "python .readme/reference.py writes it again"
