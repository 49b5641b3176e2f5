"""MuJoCo's own language for models: elements with attributes, as XML."""

from xml.etree.ElementTree import Element, SubElement

Attribute = str | bool | float | tuple[float, ...]


def add(parent: Element, tag: str, **attributes: Attribute) -> Element:
    """Add an element and return it; numbers keep all their digits."""
    return SubElement(parent, tag, {name: _text(value) for name, value in attributes.items()})


def _text(value: Attribute) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_text, value))
    if isinstance(value, bool):
        return "true" if value else "false"
    # A numpy number is a float and would write its type, too.
    return repr(float(value)) if isinstance(value, float) else str(value)
