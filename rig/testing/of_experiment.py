"""What the suites about an experiment share: its rehearsal, made once for all of them."""

import functools
from pathlib import Path
from typing import ClassVar

import pytest

from rig.testing.rehearsal import Rehearsal, rehearse

_rehearsed = functools.cache(rehearse)


class OfExperiment:
    """Base of the suites about what an experiment names.

    Attributes
    ----------
    configs, experiment : Path and str
        The folder of the configurations (None: ``configs`` where pytest runs, then the program's
        own), and the experiment.
    options : tuple of str
        ``a.b=c``, as on the command line: another controller, say.
    """

    configs: ClassVar[Path | None]
    experiment: ClassVar[str]
    options: ClassVar[tuple[str, ...]] = ()

    @pytest.fixture
    def rehearsal(self) -> Rehearsal:
        """Return the beginning of the experiment, on `sim`."""
        return _rehearsed(self.configs, self.experiment, self.options)
