"""Ask a chain of Dynamixel servos who is there, without changing anything on it.

References
----------
ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0": Ping to the broadcast id, which every servo answers in
turn.
"""

from collections import Counter
from collections.abc import Collection
from typing import Final

from drivers.dynamixel.bus import SerialBus
from drivers.dynamixel.client import SCAN_TIME
from drivers.dynamixel.codec import BROADCAST_ID, encode_ping
from drivers.dynamixel.registers import describe_model
from rig.hal import Clock
from rig.hal.frames import Found

_ROUNDS: Final = 3
"""An answer that gets lost comes in the next one."""


def survey_chain(bus: SerialBus, clock: Clock, expected: Collection[int] = ()) -> list[Found]:
    """Return who answers on an open chain, by id.

    Two servos of one id that answer at once garble each other: they are told as none, or as two.

    Parameters
    ----------
    bus : SerialBus
        Open, and in nobody's cycle.
    clock : Clock
        The bus has the same.
    expected : collection of int
        A servo answers whether it is expected or not.
    """
    del clock, expected
    models: dict[int, int] = {}
    answers: Counter[int] = Counter()
    for _ in range(_ROUNDS):
        found, _ = bus.ask(encode_ping(BROADCAST_ID), lambda said: False, SCAN_TIME)
        heard = [status for status in found if len(status.data) == 3]
        answers |= Counter(status.id for status in heard)
        models |= {status.id: int.from_bytes(status.data[:2], "little") for status in heard}
    return [
        Found(servo, describe_model(number), answers=answers[servo])
        for servo, number in sorted(models.items())
    ]
