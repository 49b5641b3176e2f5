"""The sensors that a pair of legs may have for its balance, as the loop reads them."""

from collections.abc import Mapping, Sequence
from typing import Final

from controllers.gait.geometry import LEGS, SoleGeometry
from controllers.gait.sensing import FootLoad, Sensing, weighed_point
from rig.hal import Device, InertialSensor, LoadCells, SeveralErrors, StaleReading
from rig.hal.columns import Column
from rig.hal.picking import DevicePicker
from rig.mechanisms.legs.settings import LegsSettings

_CORNERS: Final = ("front_left", "front_right", "back_left", "back_right")
CELLS: Final = tuple(f"{leg}_{corner}" for leg in LEGS for corner in _CORNERS)
"""The load cells that the feet have, by the names that their devices must use."""

_LEAST_LOAD: Final = 5.0
"""Of both feet, below which they stand nowhere, N."""
_LEANS: Final = ("roll", "pitch", "roll_rate", "pitch_rate")

COLUMNS: Final = (
    *(Column(f"reading.force_{cell}", "N", f"on the load cell {cell}") for cell in CELLS),
    Column("reading.waist_roll", "rad", "measured roll of the waist"),
    Column("reading.waist_pitch", "rad", "measured pitch of the waist"),
    Column("reading.waist_roll_rate", "rad/s", "measured rate of the waist about its x"),
    Column("reading.waist_pitch_rate", "rad/s", "measured rate of the waist about its y"),
    Column("balance.pressure_x", "m", "where the feet are pressed, if they stand as planned"),
    Column("balance.pressure_y", "m", "where the feet are pressed, if they stand as planned"),
)


class BalanceSensors:
    """Load cells under both feet and an inertial sensor at the waist.

    Parameters
    ----------
    cells : sequence of LoadCells
        Devices that have all of `CELLS` once.
    inertial : InertialSensor
        At the waist.
    sole : SoleGeometry
        What a foot stands on.
    inset : float
        Of the cells from its edges, m.
    max_age : float
        Oldest reading that control may use, s.

    Raises
    ------
    ConfigurationError
        A cell is missing, twice, or under no foot.
    """

    def __init__(
        self,
        cells: Sequence[LoadCells],
        inertial: InertialSensor,
        sole: SoleGeometry,
        inset: float,
        max_age: float,
    ) -> None:
        self._cells = tuple(cells)
        self._inertial = inertial
        self._max_age = max_age
        offered = [channel for device in cells for channel in device.channels]
        wrong = [f"the feet have no load cell {c}" for c in offered if c not in CELLS]
        wrong += [f"two load cells are called {c}" for c in CELLS if offered.count(c) > 1]
        wrong += [
            f"no load cell is called {c}; there are {', '.join(offered)}"
            for c in CELLS
            if c not in offered
        ]
        SeveralErrors.raise_if_any(wrong)
        self._order = tuple(offered.index(cell) for cell in CELLS)
        ahead, behind = sole.front - inset, inset - sole.back
        aside = sole.half_width - inset
        corners = ((ahead, aside), (ahead, -aside), (behind, aside), (behind, -aside))
        self._places = corners * len(LEGS)
        self._pressed = (0.0, 0.0)
        self.age = 0.0
        self.forces: tuple[float, ...] = (0.0,) * len(CELLS)
        self.leans: tuple[float, ...] = (0.0,) * len(_LEANS)

    @classmethod
    def pick(cls, settings: LegsSettings, devices: Mapping[str, Device]) -> "BalanceSensors | None":
        """Return those that the settings name; None: they name none."""
        if settings.inertial is None:
            return None
        with DevicePicker("legs", devices) as pick:
            cells = [pick("load_cells", name, LoadCells) for name in settings.load_cells]
            inertial = pick("inertial", settings.inertial, InertialSensor)
        limits = settings.limits
        return cls(cells, inertial, settings.geometry.sole, settings.cell_inset, limits.reading_age)

    def read(self, now: float) -> Sensing:
        """Return what they measure.

        Raises
        ------
        StaleReading
            With the device whose reading is too old.
        """
        forces: list[float] = []
        (roll, pitch), oldest = self._inertial.lean()
        device = self._inertial.name
        for cells in self._cells:
            measured, t = cells.forces()
            forces += measured
            if t < oldest:
                oldest, device = t, cells.name
        self.age = now - oldest
        if self.age > self._max_age:
            raise StaleReading(device, self.age, self._max_age)
        self.forces = tuple([forces[k] for k in self._order])
        self.leans = (roll, pitch, *self._inertial.turning().value)
        return self._sensing()

    def recall(self, logged: Mapping[str, float]) -> Sensing:
        """Return what was measured, from the log."""
        self.forces = tuple([logged[f"reading.force_{cell}"] for cell in CELLS])
        self.leans = tuple([logged[f"reading.waist_{lean}"] for lean in _LEANS])
        return self._sensing()

    def row(self, feet: tuple[Sequence[float], Sequence[float]]) -> tuple[float, ...]:
        """Return the last measurements, one for each of `COLUMNS`.

        Parameters
        ----------
        feet : tuple
            Where right and left foot are planned to be, m.
        """
        # In the air there is no such point: the last one stays.
        self._pressed = weighed_point(self._sensing(), feet, _LEAST_LOAD) or self._pressed
        return (*self.forces, *self.leans, *self._pressed)

    def _sensing(self) -> Sensing:
        roll, pitch, roll_rate, pitch_rate = self.leans
        count = len(CELLS) // len(LEGS)
        right = self._load(self.forces[:count], self._places[:count])
        left = self._load(self.forces[count:], self._places[count:])
        return Sensing((right, left), (roll, pitch), (roll_rate, pitch_rate))

    @staticmethod
    def _load(forces: Sequence[float], places: Sequence[tuple[float, float]]) -> FootLoad:
        ahead = aside = 0.0
        for force, (x, y) in zip(forces, places, strict=True):
            ahead += force * x
            aside += force * y
        return FootLoad(sum(forces), (ahead, aside))
