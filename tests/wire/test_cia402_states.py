"""Status words, control words, error codes and periods of CiA 402, one by one."""

import pytest

from drivers.cia402.errors import describe_error
from drivers.cia402.setup import encode_interpolation_period
from drivers.cia402.states import DriveState, Goal, decode_state, next_control

STATES = [
    (0x0000, "NOT_READY"),
    (0x0250, "SWITCH_ON_DISABLED"),
    (0x0270, "SWITCH_ON_DISABLED"),
    (0x0231, "READY_TO_SWITCH_ON"),
    (0x0233, "SWITCHED_ON"),
    (0x1637, "OPERATION_ENABLED"),
    (0x0217, "QUICK_STOP_ACTIVE"),
    (0x021F, "FAULT_REACTION_ACTIVE"),
    (0x023F, "FAULT_REACTION_ACTIVE"),
    (0x0218, "FAULT"),
    (0x0238, "FAULT"),
]


@pytest.mark.parametrize(("word", "name"), STATES)
def test_states_of_status_words(word, name):
    assert decode_state(word) is DriveState[name]


def test_every_status_word_reads_as_the_canopen_package_reads_it():
    p402 = pytest.importorskip("canopen.profiles.p402")
    for word in range(0x80):
        theirs = next(
            (n for n, (mask, bits) in p402.State402.SW_MASK.items() if word & mask == bits), None
        )
        ours = decode_state(word)
        spelled = {"NOT READY TO SWITCH ON": "NOT_READY"}
        if theirs is None:
            assert ours is None, hex(word)
        else:
            assert ours is not None, hex(word)
            assert ours.name == spelled.get(theirs, theirs.replace(" ", "_"))


def test_no_control_word_resets_a_fault():
    for goal in Goal:
        for state in (*DriveState, None):
            assert not next_control(state, goal) & 0x80


@pytest.mark.parametrize(
    ("period", "expected"),
    [
        (0.005, (5, -3)),
        (0.001, (1, -3)),
        (0.0025, (25, -4)),
        (1 / 400, (25, -4)),
        (0.25, (250, -3)),
    ],
)
def test_the_interpolation_period_is_exact(period, expected):
    assert encode_interpolation_period(period) == expected


@pytest.mark.parametrize("period", [1 / 300, 0.3, 1e-7])
def test_a_period_that_drives_cannot_be_told_is_refused(period):
    with pytest.raises(ValueError, match=r"0x60C2 holds.*another rate"):
        encode_interpolation_period(period)


def test_error_codes_fall_back_to_their_group():
    assert describe_error(0x8611) == "following error too large"
    assert describe_error(0x86FF) == "positioning"
    assert describe_error(0x3299) == "voltage inside the device"
