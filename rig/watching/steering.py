"""The way from a page to the gains of a run that goes on."""

from pathlib import Path

from rig.watching.messages import Request


class Steering:
    """Checks what a page asks for, and puts it where the loop looks once a cycle.

    Parameters
    ----------
    run : Path
        The run's folder.
    """

    def __init__(self, run: Path) -> None:
        self._path = run

    def described(self) -> list[dict[str, object]]:
        """Return what may be changed, and within which bounds."""
        return []

    def answer(self, request: Request) -> str | None:
        """Hand a change on; return what is to be said of it."""
        return "there is no gain to be changed"
