"""What a tune came to, kept among the runs: gains that were not put in force are known, too."""

import contextlib
import shlex
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple, TypedDict

from rig.hal import ConfigurationError
from rig.json_file import write_json
from rig.typed_json import read_json

_FILE = "verdict.json"


class _Kept(TypedDict):
    """The content of the file."""

    law: str
    date: str
    generations: int
    objections: list[str]
    options: list[str]
    is_put: bool


class Attempt(NamedTuple):
    """A tune that came to its end.

    Parameters
    ----------
    law : str
        Whose gains.
    date : str
        UTC, ISO 8601.
    generations : int
        As ``--generations`` said.
    objections : tuple of str
        What spoke against the gains that were found.
    options : tuple of str
        The words of its command line that say what is tuned, and where what is tried is kept.
    is_put : bool
        Whether they were put in force.
    """

    law: str
    date: str
    generations: int
    objections: tuple[str, ...]
    options: tuple[str, ...]
    is_put: bool

    def for_more(self, rig: str) -> str:
        """Return the command that goes on with twice as many generations, as a shell takes it.

        Parameters
        ----------
        rig : str
            What names the rig on a command line.
        """
        words = shlex.join([*self.options, "--generations", str(2 * self.generations)])
        return f"rig tune {rig} {words}"


def folder_prefix(rig: str, law: str) -> str:
    """Return how the names of the folders begin in which tunes of a law keep what they try."""
    return f"tune-{rig}-{law}-"


def keep_attempt(
    folder: Path,
    law: str,
    generations: int,
    objections: Sequence[str],
    options: Sequence[str] = (),
    *,
    is_put: bool,
) -> Attempt:
    """Keep what a tune came to in its folder; nobody hears of it where that cannot be written.

    Parameters
    ----------
    folder : Path
        Of what it has tried.
    law, generations, objections, options, is_put
        See `Attempt`.
    """
    date = datetime.now(UTC).isoformat(timespec="seconds")
    made = Attempt(law, date, generations, tuple(objections), tuple(options), is_put)
    with contextlib.suppress(OSError):  # a convenience of `rig status`
        write_json(folder / _FILE, made._asdict())
    return made


def last_attempt(out: Path, rig: str) -> Attempt | None:
    """Return the last tune of a rig of any law that came to its end; None: there was none.

    Parameters
    ----------
    out : Path
        Where runs are kept.
    rig : str
        The profile's name.
    """
    found = []
    for path in out.glob(f"tune-*/{_FILE}"):
        try:
            kept = read_json(path, _Kept)
        except (ConfigurationError, OSError):  # somebody else's, or damaged
            continue
        if path.parent.name.startswith(folder_prefix(rig, kept["law"])):
            found.append(
                Attempt(
                    kept["law"], kept["date"], kept["generations"], tuple(kept["objections"]),
                    tuple(kept["options"]), kept["is_put"],
                )
            )  # fmt: skip
    return max(found, key=lambda attempt: attempt.date, default=None)
