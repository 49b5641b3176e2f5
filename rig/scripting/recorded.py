"""A run as Python sees it: everything comes from its folder."""

import html
import warnings
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from rig.hal import ConfigurationError
from rig.hal.motion import Segment
from rig.report.data import RunData, load_run
from rig.report.figures import known_figures, own_figures
from rig.report.style import paper_style
from rig.run_facts import REPORT, Event, Manifest, RunStatus
from rig.run_folder import RunFolder
from rig.runtime.log_columns import LogColumns

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


class MetricValue(NamedTuple):
    """A metric of a run.

    Parameters
    ----------
    value : float
        SI; nan if there is none.
    unit : str
        SI unit, empty for a ratio.
    bound : float or None
        SI.
    passed : bool or None
        None without a bound.
    is_nan : bool
        It was computed, and is not a number.
    """

    value: float
    unit: str
    bound: float | None
    passed: bool | None
    is_nan: bool = False

    def __float__(self) -> float:
        return self.value

    def __str__(self) -> str:
        from rig.hal.formats import format_against

        number = None if np.isnan(self.value) and not self.is_nan else self.value
        value, bound = format_against(number, self.bound, self.unit)
        return value if self.bound is None else f"{value} (bound {bound})"


class Metrics(Mapping[str, MetricValue]):
    """The metrics of a run by their names."""

    def __init__(self, values: Mapping[str, MetricValue]) -> None:
        self._values = dict(values)

    def __getitem__(self, name: str) -> MetricValue:
        try:
            return self._values[name]
        except KeyError:
            known = ", ".join(self._values) or "none"
            raise KeyError(f"there is no metric {name!r}; there are {known}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {value}" for name, value in self._values.items())


class Run:
    """A recorded run.

    Parameters
    ----------
    path : Path
        Its folder.

    Raises
    ------
    ConfigurationError
        It is no run folder.
    """

    def __init__(self, path: str | Path) -> None:
        if not isinstance(path, str | Path):
            raise ConfigurationError(f"{path!r} is no path of a run folder")
        self._folder = RunFolder.open(path)

    @property
    def path(self) -> Path:
        """Its folder."""
        return self._folder.path

    @property
    def status(self) -> RunStatus:
        """How it ended: ok, failed (a bound was missed), aborted, faulted, crashed."""
        return self._folder.status

    @property
    def message(self) -> str | None:
        """What ended it early."""
        return self._folder.manifest.get("message")

    @property
    def manifest(self) -> Manifest:
        """What was run, on what, when, and with which versions."""
        return self._folder.manifest

    @property
    def metrics(self) -> Metrics:
        """Its metrics by name, in SI."""
        return Metrics(
            {
                row["name"]: MetricValue(
                    np.nan if row["value"] is None else row["value"], row.get("unit", ""),
                    row.get("bound"), row.get("pass"), row.get("is_nan", False),
                )
                for row in self._folder.metrics()
            }
        )  # fmt: skip

    @property
    def events(self) -> list[Event]:
        """What happened: states, marks, limits, faults; `t` on the rig's clock, s."""
        return self._folder.events()

    @property
    def segments(self) -> tuple[Segment, ...]:
        """The stretches that its metrics look at."""
        return self._data.segments

    @cached_property
    def data(self) -> "NDArray[np.void]":
        """Every cycle: ``run.data["reading.position"]``, in SI, shape (n,).

        Of a log that was cut off after its run what was left, with a warning.

        Raises
        ------
        LogError
            The log is damaged.
        """
        return as_structured(self._data.log)

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column of `data`."""
        return {column.name: column.unit for column in self._data.log.columns}

    def frame(self) -> "pd.DataFrame":
        """Return `data` for pandas, by time since the first cycle, s.

        Raises
        ------
        ConfigurationError
            pandas is not installed.
        """
        try:
            import pandas as pd
        except ImportError as error:
            raise ConfigurationError("pandas is not installed; data is there without it") from error
        log = self._data.log
        index = pd.Index(log.t - log.t[:1], name="t")
        return pd.DataFrame({column.name: log.column(column.name) for column in log.columns}, index)

    def figure(self, name: str) -> "Figure":
        """Draw one of its figures, which a notebook shows; `figures` has the names.

        Raises
        ------
        ConfigurationError
            There is no such figure, or this run has not recorded what it shows.
        """
        from matplotlib.figure import Figure

        kinds = known_figures(self._data.mechanism)
        if name not in kinds:
            of_it = ", ".join(self.figures)
            raise ConfigurationError(f"there is no figure {name!r}; there are {of_it}")
        with paper_style():
            figure = kinds[name].draw(self._data)
        if not isinstance(figure, Figure):
            raise ConfigurationError(f"{self.path.name} has not recorded what {name} shows")
        return figure

    @property
    def figures(self) -> tuple[str, ...]:
        """The names of its rig's figures; what it has not recorded cannot be drawn."""
        return own_figures(self._data.mechanism)

    @property
    def report(self) -> Path:
        """Its page; made when it is asked for first."""
        page = self.path / REPORT
        if not page.exists():
            from rig.report.regenerate import write_report

            write_report(self.path)
        return page

    @cached_property
    def _data(self) -> RunData:
        data = load_run(self.path)
        torn = self._folder.missing_end(complete=data.log.complete)
        if torn is not None:
            warnings.warn(
                f"{torn}: what was left of it is read", stacklevel=5
            )  # to who asked for `data`
        return data

    def __repr__(self) -> str:
        said = f": {self.message}" if self.message else ""
        return f"{self.path.name}: {self.status}{said}\n{self.metrics!r}".rstrip()

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{html.escape(name)}</td><td>{html.escape(str(value))}</td></tr>"
            for name, value in self.metrics.items()
        )
        said = f": {html.escape(self.message)}" if self.message else ""
        head = f"<p><b>{html.escape(self.path.name)}</b>: {self.status}{said}</p>"
        return f"{head}<table>{rows}</table>"


def as_structured(log: LogColumns) -> "NDArray[np.void]":
    """Return all rows as one structured array, with the time and the number of each cycle."""
    names = [column.name for column in log.columns]
    kinds = [("cycle", "u8"), ("t", "f8"), *[(name, "f8") for name in names]]
    rows: NDArray[np.void] = np.empty(len(log.t), np.dtype(kinds))
    rows["cycle"], rows["t"] = log.cycle, log.t
    for name in names:
        rows[name] = log.column(name)
    return rows
