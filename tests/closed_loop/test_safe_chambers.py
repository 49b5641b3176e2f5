"""Vent, hold or lock: what becomes of each chamber when the rig is made safe or falls silent."""

from pathlib import Path

import pytest

from rig.assembly import Backend, build_rig
from rig.experiment.plan import load_plan

CONFIGS = Path(__file__).parents[2] / "configs"
CHANNELS = "devices.regulators.channels"
SAFE = (
    f"{CHANNELS}.ch2.safe=hold",
    f"{CHANNELS}.ch3.safe=lock",
    f"{CHANNELS}.ch3.lock_bit=1",
    f"{CHANNELS}.ch4.lock_bit=2",
)
SETPOINTS = (120e3, 130e3, 140e3, 150e3)


class Bench:
    """The joint, without camera and loop: its regulators follow setpoints until told otherwise."""

    def __init__(self, backend, options=SAFE):
        plan = load_plan("joint-ideal-circle", [*options, "joint.camera=null"], configs=CONFIGS)
        self.rig = build_rig(plan.profile, backend)
        del self.rig.devices["camera"]
        self.regulators = self.rig.devices["regulators"]

    def __enter__(self):
        self.rig.__enter__()
        self.rig.arm()
        return self

    def __exit__(self, *_):
        self.rig.close()

    def follow(self, seconds, setpoints=SETPOINTS):
        for _ in range(round(seconds * 1e3)):
            now = self.rig.clock.now()
            for bus in self.rig.buses.values():
                bus.receive(now)
            for device in self.rig.devices.values():
                device.check(now)
            if setpoints is not None:
                self.regulators.set_pressure(setpoints)
            for bus in self.rig.buses.values():
                bus.transmit(now)
            self.rig.clock.sleep_until(now + 1e-3)

    def make_safe(self, seconds):
        for _ in range(round(seconds * 1e3)):
            now = self.rig.clock.now()
            self.regulators.make_safe()
            for bus in self.rig.buses.values():
                bus.transmit(now)
            self.rig.clock.sleep_until(now + 1e-3)

    def fall_silent(self, seconds):
        """Let time pass as when this process was killed: nothing is sent any more."""
        for _ in range(round(seconds * 10)):
            self.rig.clock.sleep_until(self.rig.clock.now() + 0.1)

    def truth(self, name):
        names = [column.name for column in self.rig.truth_columns]
        return self.rig.truth()[names.index(f"truth.{name}")]

    def pressures(self):
        return [self.truth(f"pressure_ch{k}") for k in (1, 2, 3, 4)]

    def air(self):
        """Return pressure times volume of ch3, J, which tells how much air is in it."""
        volume = 5.9e-6 + 181.4e-6 * (60e-3 - self.truth("extension_ch3"))
        return (self.truth("pressure_ch3") + 101325.0) * volume


class Broken:
    """A device of which one step raises."""

    def __init__(self, step):
        self._step = step

    def make_safe(self):
        self._do("make_safe")

    def close(self):
        self._do("close")

    def _do(self, step):
        if step == self._step:
            raise RuntimeError(f"{step} has a bug")


def assert_each_is_safe(bench, air):
    vented, held, locked, other = bench.pressures()
    assert vented == pytest.approx(0.0, abs=3e3)
    assert held == pytest.approx(SETPOINTS[1], abs=5e3)
    # Shut in: as the ring gives way the air expands, and cools a little, but it is all there.
    assert locked > 30e3
    assert 0.85 * air < bench.air() < 1.02 * air
    assert other == pytest.approx(0.0, abs=3e3)  # its lock valve stays open, so that it vents
    assert bench.truth("supply") > 500e3  # what is held needs it


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_made_safe_each_chamber_vents_holds_or_locks_as_the_profile_says(backend):
    with Bench(backend) as bench:
        bench.follow(0.6)
        air = bench.air()
        assert bench.pressures() == pytest.approx(SETPOINTS, abs=10e3)
        bench.make_safe(1.0)
        assert_each_is_safe(bench, air)


def test_module_does_the_same_by_itself_when_the_master_is_killed():
    with Bench(Backend.VIRTUAL) as bench:
        bench.follow(0.6)
        air = bench.air()
        bench.fall_silent(1.5)
        assert_each_is_safe(bench, air)


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_everything_vents_if_the_profile_says_nothing(backend):
    with Bench(backend, ()) as bench:
        bench.follow(0.6)
        bench.make_safe(1.0) if backend is Backend.SIM else bench.fall_silent(1.5)
        assert bench.pressures() == pytest.approx([0.0] * 4, abs=3e3)
        assert bench.truth("supply") == pytest.approx(0.0, abs=3e3)


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
@pytest.mark.parametrize("broken", ["make_safe", "close"])
def test_device_that_raises_on_the_way_out_keeps_no_other_from_being_made_safe(
    monkeypatch, backend, broken
):
    with Bench(backend, ()) as bench:
        bench.follow(0.6)
        last = [*bench.rig.devices.values()][-1]
        closed = []
        monkeypatch.setattr(last, "close", lambda: closed.append(last))
        others = dict(bench.rig.devices)
        bench.rig.devices.clear()
        bench.rig.devices.update({"broken": Broken(broken)} | others)
        with pytest.raises(RuntimeError, match=f"{broken} has a bug"):
            bench.rig.close()
        assert closed == [last]
        bench.rig.clock.sleep_until(bench.rig.clock.now() + 1.0)
        assert bench.pressures() == pytest.approx([0.0] * 4, abs=3e3)
        bench.rig.devices.clear()


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_nothing_is_held_open_that_was_never_commanded(backend):
    with Bench(backend) as bench:
        bench.make_safe(0.3)
        assert bench.pressures() == pytest.approx([0.0] * 4, abs=3e3)
        if backend is Backend.VIRTUAL:  # the other opens its supply as it is armed
            assert bench.truth("supply") == pytest.approx(0.0, abs=3e3)


def test_locked_chamber_opens_again_with_the_first_setpoints():
    with Bench(Backend.VIRTUAL) as bench:
        bench.follow(0.6)
        bench.make_safe(0.2)
        for device in bench.rig.devices.values():
            device.connect()
        bench.rig.arm()
        bench.follow(0.8)
        assert bench.pressures() == pytest.approx(SETPOINTS, abs=10e3)


LOCKABLE = tuple(f"{CHANNELS}.ch{k}.lock_bit={k}" for k in (1, 2, 3, 4))


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_valves_shut_on_demand_keep_what_is_in_whatever_the_regulators_do(backend):
    with Bench(backend, LOCKABLE) as bench:
        bench.follow(0.6)
        assert bench.regulators.lockable == (True,) * 4
        kept = bench.pressures()
        bench.regulators.lock((False, True, True, True))
        bench.follow(0.4, (90e3,) * 4)
        assert bench.pressures()[0] == pytest.approx(90e3, abs=10e3)
        assert bench.pressures()[1:] == pytest.approx(kept[1:], rel=0.1)
        shown, _ = bench.regulators.pressure()
        assert shown == pytest.approx((90e3,) * 4, abs=10e3)  # the other side of the valve
        bench.regulators.lock((False,) * 4)
        bench.follow(0.4, (90e3,) * 4)
        assert bench.pressures() == pytest.approx([90e3] * 4, abs=10e3)
        bench.regulators.lock((True,) * 4)
        bench.make_safe(1.0)
        assert bench.pressures() == pytest.approx([0.0] * 4, abs=3e3)  # safe is still to vent


@pytest.mark.parametrize("backend", [Backend.SIM, Backend.VIRTUAL])
def test_a_chamber_without_a_valve_cannot_be_shut(backend):
    with Bench(backend) as bench, pytest.raises(ValueError, match="no valve locks ch1"):
        bench.regulators.lock((True, False, False, False))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((f"{CHANNELS}.ch3.safe=lock",), ("ch3", "lock", "lock_bit")),
        ((f"{CHANNELS}.ch3.lock_bit=0",), ("ch3.lock_bit", "supply_bit")),
        (
            (f"{CHANNELS}.ch1.safe=hold", "devices.regulators.error_mode=null"),
            ("ch1", "hold", "error_mode"),
        ),
    ],
)
def test_safe_state_that_the_device_cannot_take_is_refused(options, words):
    from rig.config import ProfileError

    with pytest.raises(ProfileError) as caught:
        load_plan("joint-ideal-circle", list(options), configs=CONFIGS)
    for word in words:
        assert word in str(caught.value)
