"""The one place where text becomes HTML: all of it is escaped, whoever wrote it.

A page fetches nothing and runs nothing, and its policy tells the browser so: not even a mistake
here could have it run what a file from elsewhere holds.
"""

import base64
import hashlib
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path
from typing import Final
from urllib.parse import quote

_MANY: Final = 16
"""A table of more columns is set in smaller letters."""
_CSS: Final = Path(__file__).with_name("report.css")


class Html(str):
    """Markup that needs no escaping any more."""

    __slots__ = ()


NOTHING: Final = Html()


def element(name: str, *content: str, **attributes: str | int) -> Html:
    """Return an element.

    Parameters
    ----------
    name : str
        Its tag.
    *content : str
        Texts, which are escaped, and markup.
    **attributes
        Its attributes, which are escaped; ``class_`` is ``class``, ``aria_label`` ``aria-label``.
    """
    said = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"'
        for key, value in attributes.items()
    )
    return Html(f"<{name}{said}>{join(content)}</{name}>")


def join(content: Iterable[str], between: str = "") -> Html:
    """Return texts, which are escaped, and markup, one behind the other."""
    return Html(between.join(c if isinstance(c, Html) else escape(c) for c in content))


def link(path: str, text: str) -> Html:
    """Return a link to a file in the page's own folder; to any other path the text alone."""
    if not path or ".." in Path(path).parts or Path(path).is_absolute():
        return join([text])
    return element("a", text, href=f"./{quote(path)}")


def image(png: bytes, alt: str, width: int | None = None) -> Html:
    """Return a picture that is part of the page."""
    data = base64.b64encode(png).decode()
    size = "" if width is None else f' width="{width}"'
    return Html(f'<img alt="{escape(alt)}"{size} src="data:image/png;base64,{data}">')


def section(title: str, *content: str) -> Html:
    """Return a part of the page under a title."""
    return element("section", Html("\n"), element("h2", title), Html("\n"), *content, Html("\n"))


def items(sentences: Sequence[str], kind: str) -> Html:
    """Return a list of sentences; nothing if there are none."""
    if not sentences:
        return NOTHING
    return element("ul", *(element("li", sentence) for sentence in sentences), class_=kind)


def table(
    name: str,
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    numeric: Sequence[int] = (),
    styles: Iterable[str] = (),
) -> Html:
    """Return a table that can be scrolled, by the keyboard too.

    Parameters
    ----------
    name : str
        What it shows, for who cannot see it.
    head : sequence of str
        Title of each column. Without titles the first cell of each row is its title.
    rows : iterable of sequence of str
        Their cells: texts or markup.
    numeric : sequence of int
        Columns of numbers.
    styles : iterable of str
        Class of each row's cells; default: none.
    """

    def cell(tag: str, column: int, content: str, style: str = "", **more: str) -> Html:
        kinds = " ".join(filter(None, ("number" if column in numeric else "", style)))
        return element(tag, content, **({"class_": kinds} if kinds else {}), **more)

    def row(cells: Sequence[str], style: str) -> Html:
        if head:
            return element("tr", *(cell("td", k, text, style) for k, text in enumerate(cells)))
        title, *rest = cells
        values = (cell("td", k, text, style) for k, text in enumerate(rest, 1))
        return element("tr", cell("th", 0, title, style, scope="row"), *values)

    rows = list(rows)
    kinds = list(styles) or [""] * len(rows)
    body = join(map(row, rows, kinds), "\n")
    titles = (cell("th", k, text, scope="col") for k, text in enumerate(head))
    top = element("thead", element("tr", *titles)) if head else NOTHING
    whole = element("table", top, element("tbody", Html("\n"), body, Html("\n")))
    kind = "wide many" if len(head) > _MANY else "wide"
    return element("div", whole, class_=kind, tabindex=0, role="region", aria_label=name)


def page(title: str, *content: str, width: str = "60rem") -> str:
    """Return a whole page.

    Parameters
    ----------
    title : str
        Its title.
    *content : str
        What stands on it.
    width : str
        Greatest width, of CSS.
    """
    style = f"\n{_CSS.read_text(encoding='utf-8')}main {{ max-width: {width}; }}\n"
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    policy = (
        f"default-src 'none'; style-src 'sha256-{digest}'; img-src data:; base-uri 'none'; "
        "form-action 'none'"
    )
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"{element('title', title)}\n<style>{style}</style>\n</head>\n<body>\n<main>\n"
        f"{join(filter(None, content), chr(10))}\n</main>\n</body>\n</html>\n"
    )
