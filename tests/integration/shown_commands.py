"""The commands that pages show, as words: in blocks, in tables and between backticks."""

import itertools
import re
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[2]
PAGES = sorted(
    path
    for path in ROOT.rglob("*.md")
    if not {"runs", "build", "node_modules"} & set(path.relative_to(ROOT).parts)
    and not any(part.startswith(".venv") for part in path.relative_to(ROOT).parts)
)
PROGRAMS = ("rig", "python", "pytest", "pip", "coverage")
_BEGINS = re.compile(rf"(?:[A-Z_]+=\S+ +)*(?:{'|'.join(PROGRAMS)})(?= |$)")
_FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^ *```$", re.M | re.S)
_INLINE = re.compile(r"(?<!`)`([^`]+)`(?!`)")
_ENDS = {"&&", "&", ";", ">"}


class ShownCommand(NamedTuple):
    """A command of a page.

    Parameters
    ----------
    page : Path
        Which.
    text : str
        As it is written, in one line.
    words : tuple of str
        What a shell makes of it, with one of its alternatives and without variables before it.
    is_inline : bool
        It stands in a sentence or a table, where a name alone may be meant.
    """

    page: Path
    text: str
    words: tuple[str, ...]
    is_inline: bool

    @property
    def place(self) -> str:
        """What a failing test calls it."""
        return f"{self.page.relative_to(ROOT)}: {self.text}"


def commands_of(page: Path) -> Iterator[ShownCommand]:
    """Return every command of a page, each alternative of one by itself."""
    for text, is_inline in _texts(page.read_text()):
        for variant in _alternatives(text):
            yield ShownCommand(page, text, _words(variant), is_inline)


def _texts(page: str) -> Iterator[tuple[str, bool]]:
    """Return what begins as a command, and whether it stands in a sentence or a table."""
    page = re.sub(r"<!--.*?-->", "", page, flags=re.S)
    lines = []
    for _, kind, content in _FENCE.findall(page):
        if kind in ("console", "terminal"):
            lines += re.findall(r"^ *\$ (.*)$", content, re.M)
    page = _FENCE.sub("", page)
    lines += re.findall(r"^    +(\S.*)$", re.sub(r"\\\n *", "", page), re.M)
    for line in lines:
        for part in re.split(r" && ", line):
            if _BEGINS.match(part):
                yield part, False
    prose = re.sub(r"^    .*$", "", page, flags=re.M)
    for found in _INLINE.findall(prose):
        text = " ".join(found.split())
        if _BEGINS.match(text):
            yield text, True


def _alternatives(text: str) -> Iterator[str]:
    """Return a command with each of the alternatives that brackets and bars leave open."""
    parts = re.split(r"(?<=\s)\[([^\]]+)\]", text.replace("\\|", "|"))
    options = [("", part) if k % 2 else (part,) for k, part in enumerate(parts)]
    for chosen in itertools.product(*options):
        words = "".join(chosen).replace(" | ", "|").split(" ")
        choices = [word.split("|") if re.fullmatch(r"[\w|-]+", word) else [word] for word in words]
        for alternative in itertools.product(*choices):
            yield " ".join(alternative)


def _words(text: str) -> tuple[str, ...]:
    lexer = shlex.shlex(text, posix=True, punctuation_chars="&;>")
    lexer.whitespace_split = True
    words = itertools.takewhile(lambda word: word not in _ENDS, lexer)
    return tuple(itertools.dropwhile(lambda word: re.match(r"[A-Z_]+=", word), words))
