"""Reference instruments: what somebody reads off a gauge while the rig holds still.

On a rig a person reads them, and types or hands over what was read. In simulation a simulated
instrument does it: it looks at the plant through the truth that the log of a simulated run holds,
with an error of its own, and the identification is given its readings and nothing else.
"""

import zlib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from rig.calibration.recording import TRUTH, CalibrationRefused
from rig.config.quantities import UnitError, parse_reading
from rig.experiment.metrics import Evaluation, evaluation_from_json
from rig.run_facts import EVALUATION
from rig.run_folder import RunFolder
from rig.runtime.log import read_log

Readings = Mapping[str, Mapping[str, float]]
"""What reference instruments showed: by quantity, then by stretch; SI."""


class Instrument(NamedTuple):
    """One quantity to be read in several stretches.

    Parameters
    ----------
    name : str
        Of the quantity, e.g. ``"gauge agonist"``.
    unit : str
        SI unit.
    accuracy : float
        Standard uncertainty of a reading, in `unit`.
    stretches : tuple of str
        When it is read.
    truth : str
        What it shows, by the name of the simulated plant's column.
    expected : tuple of float
        What it is made to, in each of the stretches: a jig is not read. Empty if it is.
    """

    name: str
    unit: str
    accuracy: float
    stretches: tuple[str, ...]
    truth: str
    expected: tuple[float, ...] = ()


def simulate(instruments: Sequence[Instrument], folders: Sequence[Path], seed: int) -> Readings:
    """Return what simulated instruments show during recorded runs of a simulated rig."""
    readings: dict[str, dict[str, float]] = {instrument.name: {} for instrument in instruments}
    for path in folders:
        folder = RunFolder.open(path)
        log = read_log(folder.log_path)
        segments, _ = evaluation_from_json(folder.read_json(EVALUATION, Evaluation))
        t = log.column("reference.time")
        bounds = {segment.name: (segment.start, segment.end) for segment in segments}
        for instrument in instruments:
            shown = log.column(TRUTH + instrument.truth)
            own = zlib.crc32(f"{seed}/{instrument.name}".encode())
            errors = np.random.default_rng(own).normal(
                0.0, instrument.accuracy, len(instrument.stretches)
            )
            for stretch, error in zip(instrument.stretches, errors.tolist(), strict=True):
                if stretch in bounds:
                    start, end = bounds[stretch]
                    inside = (t >= start) & (t < end)
                    if inside.any():
                        readings[instrument.name][stretch] = float(shown[inside].mean()) + error
    return readings


def made_to(instruments: Sequence[Instrument]) -> dict[str, dict[str, float]]:
    """Return what instruments show that are made to it."""
    return {
        instrument.name: dict(zip(instrument.stretches, instrument.expected, strict=True))
        for instrument in instruments
        if instrument.expected
    }


def ask(instruments: Sequence[Instrument], prompt: Callable[[str], str]) -> Readings:
    """Ask a person for every reading; what is no quantity is asked for once more."""
    readings: dict[str, dict[str, float]] = made_to(instruments)
    for instrument in instruments:
        for stretch in () if instrument.expected else instrument.stretches:
            while True:
                text = prompt(f"{instrument.name} during {stretch!r} ({instrument.unit})")
                try:
                    value = parse_reading(text, instrument.unit)
                except UnitError:
                    continue
                readings.setdefault(instrument.name, {})[stretch] = value
                break
    return readings


def shown_in(
    readings: Readings, name: str, stretches: Sequence[str], lack: str, of: str = "stretches"
) -> list[float]:
    """Return what an instrument showed in stretches.

    Parameters
    ----------
    readings : mapping
        Of all instruments.
    name : str
        Of the instrument.
    stretches : sequence of str
        Where it was to be read.
    lack, of : str
        Beginning of the sentence that says that it was not read, and what stretches are.

    Raises
    ------
    CalibrationRefused
        It was not read everywhere.
    """
    shown = readings.get(name, {})
    lacking = [stretch for stretch in stretches if stretch not in shown]
    if lacking:
        raise CalibrationRefused(
            f"{lack} in {len(lacking)} of {len(stretches)} {of}, first in {lacking[0]!r}"
        )
    return [shown[stretch] for stretch in stretches]
