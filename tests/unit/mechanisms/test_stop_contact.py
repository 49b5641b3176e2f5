"""The emergency-stop contact: pressed, pressed meanwhile, not read any more, not there."""

import pytest
from pneumatic_fakes import FakeStop

from rig.hal import EmergencyStop, StaleReading
from rig.mechanisms.stop_contact import StopContact

OLDEST = 2.0**-5


class LatchedStop(FakeStop):
    """Keeps a press that nobody saw in a cycle."""

    latched = False

    def was_pressed(self):
        return self.latched


def test_a_closed_contact_that_is_read_says_nothing():
    stop = LatchedStop()
    contact = StopContact(stop, OLDEST)
    assert contact.device is stop
    contact.check(OLDEST)


@pytest.mark.parametrize(("pressed", "latched"), [(True, False), (False, True), (True, True)])
@pytest.mark.parametrize("now", [0.0, 100.0])
def test_a_press_counts_now_or_earlier_and_however_old_it_is(pressed, latched, now):
    stop = LatchedStop()
    stop.pressed, stop.latched = pressed, latched
    with pytest.raises(EmergencyStop, match=r"circuit is open; .* read by stop"):
        StopContact(stop, OLDEST).check(now)


def test_a_contact_that_is_not_read_any_more_is_a_fault_of_its_own():
    stop = LatchedStop()
    stop.t = 4.0
    StopContact(stop, OLDEST).check(4.0 + OLDEST)
    with pytest.raises(StaleReading) as caught:
        StopContact(stop, OLDEST).check(4.0 + OLDEST + 2.0**-20)
    error = caught.value
    place = "the emergency stop that stop reads"
    assert (error.device, error.age, error.bound) == (place, OLDEST + 2.0**-20, OLDEST)


def test_a_rig_without_a_contact_is_not_judged_by_one():
    contact = StopContact(None, OLDEST)
    contact.check(1e9)
    assert contact.device is None


def test_a_contact_that_a_log_does_not_have_is_not_asked():
    stop = LatchedStop()
    stop.pressed = stop.latched = True
    contact = StopContact(stop, OLDEST)
    contact.ignore()
    contact.check(1e9)
    assert contact.device is None
