"""The joint's log as its diagnosis takes it, and what else it tells."""

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from controllers.spherical_joint.geometry import PAIRS
from rig.hal.hindsight import Suspect
from rig.hal.motion import Note
from rig.mechanisms.joint.camera_latency import remark_on_latency
from rig.mechanisms.joint.columns import CHANNELS
from rig.mechanisms.joint.pulls import ring_falls
from rig.mechanisms.joint.settings import JointSettings
from rig.mechanisms.joint.wire_causes import wire_causes
from rig.mechanisms.pneumatic.diagnosis.evidence import Signals
from rig.mechanisms.pneumatic.hindsight import stacked, suspects
from rig.mechanisms.pneumatic.hunting import remarks_on_hunting

if TYPE_CHECKING:
    from rig.hal.devices import MarkerCamera
    from rig.hal.hindsight import Logged

_RODS = {f"the rod of {n}": (f"reference.rod_{n}", f"reading.rod_{n}") for n in CHANNELS}


def joint_suspects(logged: "Logged", settings: JointSettings) -> tuple[Suspect, ...]:
    """Return what explains the end of the joint's log best."""
    pressures = stacked(logged, "reading.pressure_", CHANNELS)
    homes = np.array([settings.home + offset for offset in settings.wire_offsets])
    friction, tensions = settings.friction, settings.area * pressures
    ring = friction.ring * tensions.sum(axis=1)
    loads = [ring + friction.wire * (tensions[:, a] + tensions[:, b]) for a, b in PAIRS]
    rods = stacked(logged, "reading.rod_", CHANNELS)
    offs = [0.5 * (rods[:, a] - rods[:, b]) for a, b in PAIRS]
    pull, even = ring_falls(settings).pull, tensions.mean(axis=1)
    signals = Signals(
        logged("clock"),
        stacked(logged, "applied.", CHANNELS),
        pressures,
        homes - rods,
        np.column_stack(loads),
        np.column_stack([even * pull(*offs), even * pull(*offs[::-1])]),
    )
    of_wires = partial(wire_causes, settings=settings)
    return suspects(signals, CHANNELS, PAIRS, settings, of_wires)


def joint_remarks(logged: "Logged", camera: "MarkerCamera | None") -> tuple[Note, ...]:
    """Return which rods never came to rest, and that the camera's latency is wrong, if it is."""
    latency = () if camera is None else remark_on_latency(logged, camera.name, camera.latency)
    return (*remarks_on_hunting(logged, _RODS), *latency)
