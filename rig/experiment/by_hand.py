"""What is said, and left undone, where somebody ends a run beside its loop."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rig.experiment.watcher import Watcher
from rig.report.ready import ReadyReporter
from rig.run_facts import TIMING


@contextmanager
def telling_where(path: Path, watcher: Watcher) -> Iterator[None]:
    """Name the folder of a run that is interrupted before its loop; a later one is only counted."""
    try:
        yield
    except KeyboardInterrupt:
        watcher.said(f"ended before its first cycle: nothing was moved; it left {path}")
        raise


def draw(reporter: ReadyReporter, path: Path, watcher: Watcher, *, by_hand: bool) -> None:
    """Write the report of a run, or say what writes it if somebody wants the prompt back at once.

    Parameters
    ----------
    reporter : ReadyReporter
        Ready to.
    path : Path
        The run folder.
    watcher : Watcher
        Is told.
    by_hand : bool
        Somebody has ended the run.

    Raises
    ------
    KeyboardInterrupt
        Somebody does so while it is drawn.
    """
    later = f"draw them with: rig report {path}"
    if by_hand:
        if (path / TIMING).exists():  # else there was no cycle
            watcher.said(f"ended by hand, so no figures are drawn; {later}")
        return
    watcher.working("drawing figures")
    try:
        for sentence in reporter.write(path):
            watcher.said(sentence)
    except KeyboardInterrupt:
        watcher.said(f"the run is whole in {path}, its figures are not; {later}")
        raise
