"""Twists as the loop follows them: what was gone through beforehand is what is commanded."""

from dataclasses import dataclass

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import rig
from controllers.arm.kinematics import dimensions_of, forward
from controllers.arm.online.commands import ArmTwists
from controllers.arm.types import AT_REST
from rig.experiment.plan import load_plan

POSTURE = (0.74, -0.26, 1.59, -0.02, -0.52, 0.76)
START = f"[{', '.join(f'{q} rad' for q in POSTURE)}]"


def settings_of(seed, frame):
    """Return a twist of a second and a half, and the settings that ask for it."""
    rng = np.random.default_rng((733, seed))
    v, w = rng.normal(size=3), rng.normal(size=3)
    v, w = 0.08 * v / np.linalg.norm(v), 0.6 * w / np.linalg.norm(w)
    row = ", ".join([*(f"{x!r} m/s" for x in v.tolist()), *(f"{x!r} rad/s" for x in w.tolist())])
    still = ", ".join(["0 m/s"] * 3 + ["0 rad/s"] * 3)
    rows = f"[[0 s, {row}], [1.5 s, {still}]]"
    return v, w, {"reference.frame": frame, "reference.rows": rows, "reference.start": START}


def commanded(run):
    following = (run.data["phase"] == 1.0) & (run.data["reference.time"] >= -1e-9)
    names = [f"command.position_q{number}" for number in range(1, 7)]
    return np.column_stack([run.data[name][following] for name in names])


@pytest.mark.parametrize("frame", ["tool", "base"])
@pytest.mark.parametrize("seed", range(2))
def test_what_is_commanded_is_what_was_planned(seed, frame, tmp_path):
    v, w, settings = settings_of(seed, frame)
    told = [f"{name}={value}" for name, value in settings.items()]
    loaded = load_plan("arm-twist", told)
    planned = np.array(loaded.motion.plan.positions)
    q = commanded(rig.run("arm-twist", on="sim", set=settings, out=tmp_path, progress=False))
    assert np.array_equal(q[: len(planned)], planned)
    if frame == "tool":
        check_screw(loaded, q, v, w, 1.4)


@dataclass(frozen=True)
class Spoken(ArmTwists):
    """Twists that are not known before they come."""

    said: tuple[float, ...] = AT_REST

    def twist(self, t):
        return self.said if t < 1.5 else AT_REST


@pytest.mark.parametrize("seed", range(2))
def test_who_speaks_in_the_tools_axes_has_the_hand_on_the_same_screw(seed, tmp_path):
    v, w, _ = settings_of(seed, "tool")
    spoken = Spoken(start=POSTURE, frame="tool", duration=2.5, said=(*v.tolist(), *w.tolist()))
    q = commanded(rig.run("arm-twist", on="sim", reference=spoken, pace=1e3, out=tmp_path))
    check_screw(load_plan("arm-twist", []), q, v, w, 1.4)


def check_screw(loaded, q, v, w, until):
    """Hold the hand against a screw about the tool's axes, half a second after it was asked for."""
    arm = dimensions_of(loaded.profile.mechanism_settings.geometry)
    period = loaded.profile.loop.period
    first, *poses = [
        forward(arm, tuple(q[k].tolist()))
        for k in range(round(0.5 / period), round(until / period), 10)
    ]
    axes = np.array(first.rotation).T
    for pose in poses:
        turned = Rotation.from_matrix(axes @ np.array(pose.rotation)).as_rotvec()
        angle = float(turned @ w / (w @ w))
        assert np.linalg.norm(turned - angle * w) < 1e-6
        gone = axes @ (np.array(pose.position) - np.array(first.position))
        assert np.linalg.norm(gone - screw(angle, v, w)) < 1e-6


def screw(time, v, w):
    """Return where a body that moves by a twist of its own axes is after a time, by small steps."""
    steps = 20_000
    halves = (np.arange(steps) + 0.5) * time / steps
    return Rotation.from_rotvec(np.outer(halves, w)).apply(v).sum(axis=0) * time / steps
