"""Sensors on the legs: four load cells under each foot, and an inertial sensor at the waist.

A sole is a stiff plate that four cells at its corners bear. What they share of its force and
moments is statically undetermined, and shared out evenly here. Every reading is late, noisy, and
off by what the unit was drawn with; counts are the device's business.
"""

import math
from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final, Protocol

import numpy as np
from annotated_types import Ge, Interval, Unit

if TYPE_CHECKING:
    import mujoco
    from numpy.typing import NDArray

_CORNERS: Final = ("front_left", "front_right", "back_left", "back_right")
CELLS: Final = tuple(f"{leg}_{corner}" for leg in ("right", "left") for corner in _CORNERS)
LEANS: Final = ("waist_roll", "waist_pitch", "waist_roll_rate", "waist_pitch_rate")
SENSORS: Final = (*CELLS, *LEANS)
_WEAR: Final = ("frozen", "offset", "scale", "noisy")
_KINDS: Final = ("cell",) * 8 + ("lean",) * 2 + ("gyro",) * 2
OF_SENSOR: Final = tuple(
    f"{sensor}.{kind}_{wear}"
    for sensor, kind in zip(SENSORS, _KINDS, strict=True)
    for wear in _WEAR
)
"""Faults of one sensor, as in ``waist_roll.lean_offset``."""
FAULTS: Final = (
    "feet_frozen", "feet_offset", "cell_dead", "waist_frozen", "waist_offset", "gyro_offset",
    *OF_SENSOR,
)  # fmt: skip
"""Names of `LegSensors.break_by`."""

_SEED: Final = 0x5E
"""Beside the unit's, so that a unit is the same whether or not anybody measures it."""
_OFFSET: Final = {"feet_offset": 10.0, "waist_offset": 0.2, "gyro_offset": 0.3}
"""Of a fault without a value: N for each cell, rad, rad/s."""
_WORN: Final = {"cell_offset": 10.0, "lean_offset": 0.2, "gyro_offset": 0.3,
                "cell_noisy": 5.0, "lean_noisy": 0.05, "gyro_noisy": 0.2}  # fmt: skip
"""The same of one sensor; a scale that is not said is 2."""


@dataclass(frozen=True, slots=True)
class LegSensorSettings:
    """The errors of the sensors.

    Sources of the defaults: E, estimates; data sheets give less for a body at rest.

    Parameters
    ----------
    inset : float
        Of the cells from the sole's edges, m.
    force_noise, force_offset : float
        Standard deviation of a cell, and bound of its drawn offset, N. E.
    lean_noise, lean_offset : float
        The same of roll and pitch, rad. E.
    rate_noise, rate_offset : float
        The same of the rates, rad/s. E.
    delay : float
        By which readings are late, in steps of what the plant is advanced by, s. E.
    """

    inset: Annotated[float, Unit("m"), Interval(ge=0.0, le=0.02)] = 0.005
    force_noise: Annotated[float, Unit("N"), Ge(0)] = 0.2
    force_offset: Annotated[float, Unit("N"), Ge(0)] = 0.5
    lean_noise: Annotated[float, Unit("rad"), Ge(0)] = math.radians(0.05)
    lean_offset: Annotated[float, Unit("rad"), Ge(0)] = math.radians(0.3)
    rate_noise: Annotated[float, Unit("rad/s"), Ge(0)] = math.radians(0.3)
    rate_offset: Annotated[float, Unit("rad/s"), Ge(0)] = math.radians(0.2)
    delay: Annotated[float, Unit("s"), Interval(ge=0.0, le=0.05)] = 0.005


class SoleEdges(Protocol):
    """A sole's rectangle, from under the ankle, m."""

    front: float
    back: float
    half_width: float


class SoledLegs(Protocol):
    """The part of the legs' dimensions that the sensors need."""

    @property
    def sole(self) -> SoleEdges:
        """What a foot stands on."""


class LegSensors:
    """The readings of the sensors of one robot; nothing is computed until somebody asks.

    Parameters
    ----------
    settings : LegSensorSettings
        How they err.
    seed : int
        Of the unit.
    geometry : SoledLegs
        Where the soles' corners are.
    model, data : mujoco.MjModel and MjData
        The robot.
    """

    def __init__(
        self,
        settings: LegSensorSettings,
        seed: int,
        geometry: SoledLegs,
        model: "mujoco.MjModel",
        data: "mujoco.MjData",
    ) -> None:
        import mujoco

        self._contact_force = mujoco.mj_contactForce
        self._model, self._data = model, data
        self._settings = settings
        sole, inset = geometry.sole, settings.inset
        front, back = sole.front - inset, inset - sole.back
        half = sole.half_width - inset
        corners = np.array([(front, half), (front, -half), (back, half), (back, -half)])
        # Force and moments of a sole to its cells, by the least sum of squares.
        of_cells = np.vstack((np.ones(4), corners[:, 1], -corners[:, 0]))
        self._shares = np.linalg.pinv(of_cells)
        self._soles = [model.geom("right_sole").id, model.geom("left_sole").id]
        self._waist = model.body("waist").id
        self._sites = [model.site("right_sole").id, model.site("left_sole").id]
        self._rng = np.random.default_rng((_SEED, seed % 2**32))
        bounds = [settings.force_offset] * 8 + [settings.lean_offset] * 2
        bounds += [settings.rate_offset] * 2
        self._offsets = np.array(bounds) * self._rng.uniform(-1.0, 1.0, 12)
        self._noise = np.array(
            [settings.force_noise] * 8 + [settings.lean_noise] * 2 + [settings.rate_noise] * 2
        )
        self._scales = np.ones(12)
        self._frozen = np.zeros(12, bool)
        self._by_hand = np.zeros(12)
        self._shown = np.zeros(12)
        self._late: deque[tuple[float, NDArray[np.float64]]] = deque()
        self._used = False

    def show(self, sensor: int) -> float:
        """Return what one of `SENSORS` shows, N, rad or rad/s."""
        if not self._used:
            self._used = True
            self._shown = self._measure()
        return float(self._shown[sensor])

    def sample(self, t: float) -> None:
        """Measure what there is at `t` (s), and show what there was a delay ago."""
        if not self._used:
            return
        late = self._late
        late.append((t, self._measure()))
        while len(late) > 1 and late[1][0] <= t - self._settings.delay + 1e-9:
            late.popleft()
        if late[0][0] <= t - self._settings.delay + 1e-9:
            self._shown = np.where(self._frozen, self._shown, late[0][1])

    def press(self, sensor: str, by: float) -> None:
        """Press a cell, or lean the waist, by hand: N or rad more from now on."""
        self._by_hand[SENSORS.index(sensor)] += by

    def break_by(self, fault: str, value: float | None) -> None:
        """Break a sensor: see `FAULTS`. `cell_dead` takes the cell's number in `CELLS`.

        Of one sensor, ``offset`` and ``noisy`` (standard deviation) take N, rad or rad/s, and
        ``scale`` a factor on what it shows.

        Raises
        ------
        ValueError
            The value does not fit the fault.
        """
        if fault in OF_SENSOR:
            sensor, _, wear = fault.partition(".")
            self._wear(SENSORS.index(sensor), wear, value)
        elif fault == "feet_frozen":
            self._frozen[:8] = True
        elif fault == "waist_frozen":
            self._frozen[8:] = True
        elif fault == "cell_dead":
            cell = 0.0 if value is None else value
            if cell not in range(len(CELLS)):
                raise ValueError(f"plant: cell_dead takes 0 … {len(CELLS) - 1}, not {cell:g}")
            self._scales[int(cell)] = 0.0
        else:
            offset = _OFFSET[fault] if value is None else value
            if not math.isfinite(offset):
                raise ValueError(f"plant: {fault} takes a finite number, not {offset:g}")
            first, last = {"feet_offset": (0, 8), "waist_offset": (8, 10)}.get(fault, (10, 12))
            self._offsets[first:last] += offset

    def _wear(self, sensor: int, wear: str, value: float | None) -> None:
        size = _WORN.get(wear, 2.0) if value is None else value
        if not math.isfinite(size):
            raise ValueError(f"plant: {wear} takes a finite number, not {size:g}")
        if wear.endswith("frozen"):
            self._frozen[sensor] = True
        elif wear.endswith("offset"):
            self._offsets[sensor] += size
        elif wear.endswith("scale"):
            self._scales[sensor] = size
        else:
            self._noise[sensor] = abs(size)

    def _measure(self) -> "NDArray[np.float64]":
        # What is up, as the waist sees it: the ground may be inclined.
        up_x, up_y, up_z = (
            -self._model.opt.gravity @ self._data.xmat[self._waist].reshape(3, 3)
        ).tolist()
        roll, pitch = math.atan2(up_y, up_z), -math.atan2(up_x, math.hypot(up_y, up_z))
        # Of a free joint MuJoCo has the angular velocity along the body's own axes.
        true = [*self._cells(), roll, pitch, *self._data.qvel[3:5].tolist()]
        noise = self._noise * self._rng.standard_normal(12)
        return (np.array(true) + self._by_hand) * self._scales + self._offsets + noise

    def _cells(self) -> list[float]:
        data, force = self._data, np.zeros(6)
        loads = np.zeros((2, 3))
        for number, geoms in enumerate(data.contact.geom.tolist()):
            for foot, geom in enumerate(self._soles):
                if geom in geoms:
                    self._contact_force(self._model, data, number, force)
                    # It acts on the second geometry, along the contact's axes.
                    acts = data.contact.frame[number].reshape(3, 3).T @ force[:3]
                    if geoms[0] == geom:
                        acts = -acts
                    turned = data.site_xmat[self._sites[foot]].reshape(3, 3).T
                    at = turned @ (data.contact.pos[number] - data.site_xpos[self._sites[foot]])
                    fx, fy, fz = turned @ acts
                    loads[foot] += (fz, at[1] * fz - at[2] * fy, at[2] * fx - at[0] * fz)
        return [float(cell) for foot in loads for cell in self._shares @ foot]
