"""Extension at which each single wire of a joint is taut.

A rod's extension gives its wire's length only if it is known how the ring stands. The rods cannot
show that while the lengths are unknown, so an inclinometer on the ring is read, along the ball's x
and y axes. With the ring's axis u, a rod stands out by

    x_k = h_k - s_k(u) - A p_k / k + side (f_k + g_k A p_k),

s_k being the shortening by the pose, k the wires' stiffness and side +1 on the way up, where the
seals keep a part of the pull from the wire. `rig.mechanisms.pneumatic.calibration.wire_fit` finds
the mean of all rods. Here the differences from it are found, in which the seals' bristles cancel
to second order. Readings of the inclinometer err independently.

The shortening is the drawing's. Where the ring leans, a joint that was made differently shifts the
rods, in proportion to the lean. So everything within `joint.tolerance` is part of the intervals,
equally likely (JCGM 101); with the ring upright nothing of it is left. A wire has the whole of what
the readings of its rod and of its chamber are off by, the mean of all a part of it.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from rig.calibration.arrays import Array
from rig.calibration.error_sums import estimate_of_sum
from rig.calibration.estimates import Estimate, Fit, fit, welch
from rig.calibration.instruments import Instrument, Readings, shown_in
from rig.calibration.recording import CalibrationRefused, Recording
from rig.config import Profile
from rig.mechanisms.joint.calibration import sighting_model
from rig.mechanisms.joint.calibration.parameters import ANGLES, LENGTHS, PARTS, WIRES, made_of
from rig.mechanisms.joint.calibration.pneumatics import JointPneumatics
from rig.mechanisms.pneumatic.calibration.rod_readings import Part, in_mean, rod_errors
from rig.mechanisms.pneumatic.calibration.wires import WireEstimates, WireSweeps, ends_of_sweeps

INCLINOMETER_ACCURACY: Final = 2e-4
"""Standard uncertainty of a reading, rad: a digital one of 0.01 deg, turned round to lose its zero.
"""

_AXES: Final = ("x", "y")
_MOST: Final = math.radians(10.0)
"""A ring that leans more does not stand upright."""


class JointWires(WireSweeps):
    """Procedure for wire offsets, stiffness and pretension of a joint, each wire by itself."""

    def instruments(self, profile: Profile) -> Sequence[Instrument]:
        """Return the inclinometer on the ring, read along both axes where sweeps end."""
        stretches = tuple(ends_of_sweeps())
        return tuple(
            Instrument(
                f"inclinometer {axis}", "rad", INCLINOMETER_ACCURACY, stretches, f"axis_{axis}"
            )
            for axis in _AXES
        )

    def believed_stiffness(self, profile: Profile) -> float | None:
        """Return the wires' stiffness that the profile has, N/m."""
        return float(profile.mechanism_settings.wire_stiffness)

    def with_single_wires(
        self, profile: Profile, data: Recording, readings: Readings, found: Fit, mean: WireEstimates
    ) -> WireEstimates:
        """Return what the inclinometer tells of each wire, or that nobody read it."""
        sides = ends_of_sweeps()
        axes = _axes(readings, sides)
        if axes is None:
            note = "nobody read the inclinometer on the ring: single wires are not told"
            return mean._replace(notes=(*mean.notes, note))
        return wire_offsets(profile, data, axes, sides, found)._replace(notes=mean.notes)


def wire_offsets(
    profile: Profile,
    recording: Recording,
    axes: Array,
    sides: Mapping[str, int],
    found: Fit,
) -> WireEstimates:
    """Return where the wires are taut, in their mean and each by itself.

    Parameters
    ----------
    profile : Profile
        Of a joint.
    recording : Recording
        What was recorded.
    axes : ndarray, shape (n, 3)
        The ring's in each stretch, by the inclinometer.
    sides : mapping of str to int
        The n stretches in which it was read: +1 on the way up.
    found : Fit
        Of the mean of all rods while the ring leans as it does: home (mm), compliance (mm/N).
    """
    pneumatics = JointPneumatics(profile)
    recorded = [recording[name] for name in sides]
    extension = np.array(
        [[pneumatics.extension(p, c).mean() for c in pneumatics.channels] for p in recorded]
    )
    pull = pneumatics.area * np.array(
        [[p.mean(f"reading.pressure_{c}") for c in pneumatics.channels] for p in recorded]
    )
    side, mean_pull = np.array([float(value) for value in sides.values()]), pull.mean(axis=1)
    believed = _believed(profile)
    shortened = _shortened(believed, axes)
    made = _made(profile, believed, axes)

    # The lean's part of both lines, up and down; it changes a little with the pull.
    lines = np.column_stack([np.ones(len(side)), -mean_pull, side, side * mean_pull])
    lean = fit(
        lambda q: 1e3 * shortened.mean(axis=1) - lines @ q, (0.0,) * 4, (1e-3, 1e-5, 1e-3, 1e-5)
    )
    leaning = np.linalg.lstsq(lines, made.mean(axis=2).T, rcond=None)[0]
    parts = [
        [
            (f.parameter(k, "", "").std, f.freedom_of(np.eye(len(f.values))[k]))
            for f in (found, lean)
        ]
        for k in (0, 1)
    ]
    rods = rod_errors(profile, pneumatics)
    give = 1e-3 * float(found.values[1] + lean.values[1])
    own_home = [_in_thousandths(rod.home(pneumatics.area, give)) for rod in rods]
    own_give = [_in_thousandths(rod.compliance(give)) for rod in rods]
    scattered = parts[0]
    parts = [[*scattered, *in_mean(own_home)], [*parts[1], *in_mean(own_give)]]
    home, compliance = (
        _sum(name, unit, 1e-3 * float(found.values[k] + lean.values[k]), parts[k], leaning[k])
        for k, (name, unit) in enumerate((("home", "m"), ("compliance", "m/N")))
    )

    taut = extension + shortened + pull * compliance.value
    apart = 1e3 * (taut - taut.mean(axis=1)[:, None])
    share = mean_pull / mean_pull.mean()
    own_made = made.mean(axis=1) - made.mean(axis=(1, 2))[:, None] + leaning[0][:, None]
    offsets, each = [], []
    for k, channel in enumerate(pneumatics.channels):
        own = fit(
            lambda q: apart[:, k] - q[0] - side * (q[1] + q[2] * share),  # noqa: B023
            (0.0, 0.0, 0.0), (0.1, 0.01, 0.01),
        ).parameter(0, "", "mm")  # fmt: skip
        offsets.append(1e-3 * own.value)
        others = [*scattered, *own_home[k], (own.std, len(side) - 3.0)]
        value = home.value + offsets[-1]
        each.append(_sum(f"home.{channel}", "m", value, others, own_made[:, k]))
    return WireEstimates(home, compliance, tuple(each), tuple(offsets))


def _axes(readings: Readings, sides: Mapping[str, int]) -> Array | None:
    """Return the ring's axis in each stretch, shape (n, 3); None if nobody read the inclinometer.

    Raises
    ------
    CalibrationRefused
        It was not read everywhere, or the ring does not stand upright.
    """
    if not any(readings.get(f"inclinometer {axis}") for axis in _AXES):
        return None
    leaning = np.column_stack(
        [
            shown_in(
                readings, f"inclinometer {axis}", tuple(sides),
                f"the inclinometer along {axis} was not read",
            )
            for axis in _AXES
        ]
    )  # fmt: skip
    if float(np.hypot(*leaning.T).max()) > _MOST:
        raise CalibrationRefused(
            f"the ring leans by {math.degrees(float(np.hypot(*leaning.T).max())):.3g} deg: put it "
            "upright before its wires are measured"
        )
    x, y = np.sin(leaning).T
    return np.column_stack([x, y, np.sqrt(1.0 - x * x - y * y)])


def _sum(
    name: str, unit: str, value: float, parts: Sequence[tuple[float, float]], made: Array
) -> Estimate:
    """Return an estimate whose error has scattering parts and parts by tolerances.

    Parameters
    ----------
    name, unit, value
        See `Estimate`.
    parts : sequence of tuple
        Standard deviation, in thousandths of `unit`, and degrees of freedom of each part.
    made : ndarray, shape (m,)
        Standard deviation by each tolerance, in `unit`.
    """
    std, freedom = welch([(1e-3 * part, freedom) for part, freedom in parts])
    return estimate_of_sum(name, value, unit, std, freedom, even=made.tolist())


def _in_thousandths(parts: Sequence[Part]) -> tuple[Part, ...]:
    return tuple([(1e3 * std, freedom) for std, freedom in parts])


def _believed(profile: Profile) -> dict[str, float]:
    """Return every dimension of the joint as its profile has it, with parts in their places."""
    geometry = profile.mechanism_settings.geometry
    return {
        **{name: getattr(geometry, name) for name in LENGTHS},
        **dict(zip(ANGLES, geometry.anchor_angles, strict=True)),
        **{f"{name}_{k}": 0.0 for k in WIRES for name in PARTS},
    }


def _shortened(values: Mapping[str, float], axes: Array) -> Array:
    """Return by how much shorter than upright each wire is for axes of shape (n, 3), m."""
    wires = sighting_model.WireEnds.of(values)
    return np.asarray(wires.lengths(np.array([[0.0, 0.0, 1.0]])) - wires.lengths(axes))


def _made(profile: Profile, believed: Mapping[str, float], axes: Array) -> Array:
    """Return each wire's change by a standard deviation of each tolerance, m, shape (m, n, 4)."""
    rows = {
        prior.name: 0.5 * (ahead - behind)
        for priors in made_of(profile)
        for prior in priors
        if prior.name in believed
        for behind, ahead in [
            [_shortened({**believed, prior.name: believed[prior.name] + side * prior.std}, axes)
             for side in (-1.0, 1.0)]
        ]
    }  # fmt: skip
    # Angles count from the anchors' mean.
    turned = np.mean([rows[name] for name in ANGLES], axis=0)
    return np.array([row - turned if name in ANGLES else row for name, row in rows.items()])
