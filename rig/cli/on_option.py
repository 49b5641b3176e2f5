"""The options ``--on``, a backend or a CAN interface, and ``--frames``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

BACKENDS = ("sim", "virtual", "vcan", "hardware")


class _Completed(click.ParamType):  # type: ignore[type-arg, unused-ignore]
    """A value that is completed from a few names."""

    def names(self) -> Iterable[str]:
        """Return the names."""
        return ()

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Complete a name."""
        from click.shell_completion import CompletionItem

        return [CompletionItem(name) for name in self.names() if name.startswith(incomplete)]


class OnBackend(_Completed):
    """One of the backends, or the CAN interface to run on; what is neither is told here."""

    name = "backend"

    def get_metavar(self, *_: object, **__: object) -> str:
        """Return what the help calls the value."""
        return f"[{'|'.join(BACKENDS)}|INTERFACE]"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the value if it may be a backend or an interface."""
        text = str(value)
        if text not in BACKENDS:
            from rig.assembly import backend_of
            from rig.hal import ConfigurationError

            try:
                backend_of(text)
            except ConfigurationError as error:
                self.fail(str(error), param, ctx)
        return text

    def names(self) -> Iterable[str]:
        """Return the backends."""
        return BACKENDS


class FrameFormat(_Completed):
    """A format of frames on file."""

    name = "format"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> str:
        """Return the value if it is a format."""
        from rig.assembly.frame_recording import FORMATS

        text = str(value)
        if text not in FORMATS:
            self.fail(
                f"{text!r} is no format of frames, which are {', '.join(FORMATS)}; without one, "
                "write --frames last.",
                param,
                ctx,
            )
        return text

    def names(self) -> Iterable[str]:
        """Return the formats."""
        from rig.assembly.frame_recording import FORMATS

        return FORMATS
