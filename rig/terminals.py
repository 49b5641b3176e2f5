"""Whether somebody sits at a terminal."""

from typing import TextIO


def is_terminal(stream: TextIO | None) -> bool:
    """Return whether a standard stream is a terminal; None: whoever began this has closed it."""
    return stream is not None and stream.isatty()
