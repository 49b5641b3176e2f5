"""The objects of an emulated CiA 402 drive.

References
----------
IEC 61800-7-201 (CiA 402-2), object dictionary; defaults of option codes as given there.
"""

from collections.abc import Callable, Collection
from functools import partial

from drivers.sim.nodes.object_dictionary import (
    INTEGER8,
    INTEGER16,
    INTEGER32,
    UNSIGNED8,
    UNSIGNED16,
    UNSIGNED32,
    Abort,
    DataType,
    ObjectDictionary,
    SdoAbortError,
    Variable,
)

_OPTIONS = {
    # index, default, permitted
    "quick stop": (0x605A, 2, (0, 1, 2, 5, 6)),
    "shutdown": (0x605B, 0, (0, 1)),
    "disable operation": (0x605C, 1, (0, 1)),
    "halt": (0x605D, 1, (1, 2)),
    "fault": (0x605E, 2, (0, 1, 2)),
    "abort connection": (0x6007, 1, (0, 1, 2, 3)),
}


class DriveObjects:
    """Enter the objects of a drive into a dictionary and keep them by name.

    Parameters
    ----------
    dictionary : ObjectDictionary
        Of the node.
    turn : tuple of int
        Position units and turns of the shaft: their ratio is the scale.
    rated_torque : int
        mN m.
    modes : collection of int
        The modes of operation that the drive knows.
    sample : callable
        Brings the measured objects up to date before an SDO reads them.
    command : callable
        Obeys control word, mode or target after an SDO wrote one.
    cap : callable
        Has the motor obey its limits of torque and speed after one was written.
    """

    def __init__(
        self,
        dictionary: ObjectDictionary,
        *,
        turn: tuple[int, int],
        rated_torque: int,
        modes: Collection[int],
        sample: Callable[[], None],
        command: Callable[[], None],
        cap: Callable[[], None],
    ) -> None:
        add, add_array = dictionary.add, dictionary.add_array

        def measured(index: int, kind: DataType) -> Variable:
            return add(index, 0, Variable(kind, 0, "ro", mapping="t", refresh=sample))

        def commanded(index: int, kind: DataType, default: int = 0) -> Variable:
            return add(index, 0, Variable(kind, default, mapping="r", changed=command))

        self.error_code = measured(0x603F, UNSIGNED16)
        self.control_word = commanded(0x6040, UNSIGNED16)
        self.status_word = measured(0x6041, UNSIGNED16)
        self.options = {
            reason: add(
                index,
                0,
                Variable(INTEGER16, default, check=partial(_one_of, permitted)),
            )
            for reason, (index, default, permitted) in _OPTIONS.items()
        }
        self.mode = commanded(0x6060, INTEGER8)
        self.mode.check = partial(_one_of, (0, *modes))
        self.mode_display = measured(0x6061, INTEGER8)
        self.demand = measured(0x6062, INTEGER32)
        self.position = measured(0x6064, INTEGER32)
        self.following_window = add(0x6065, 0, Variable(UNSIGNED32, 0xFFFF_FFFF))
        self.following_time = add(0x6066, 0, Variable(UNSIGNED16, 0))
        self.velocity = measured(0x606C, INTEGER32)
        self.torque_limit = add(0x6072, 0, Variable(UNSIGNED16, 0xFFFF, changed=cap))
        self.rated_torque = add(0x6076, 0, Variable(UNSIGNED32, rated_torque, "ro"))
        self.torque = measured(0x6077, INTEGER16)
        self.target_position = commanded(0x607A, INTEGER32)
        self.position_limits = add_array(
            0x607D, [Variable(INTEGER32, INTEGER32.low), Variable(INTEGER32, INTEGER32.high)]
        )
        self.greatest_speed = add(0x6080, 0, Variable(UNSIGNED32, 0xFFFF_FFFF, changed=cap))
        self.slow_down_ramp = add(0x6084, 0, Variable(UNSIGNED32, turn[0]))
        self.quick_stop_ramp = add(0x6085, 0, Variable(UNSIGNED32, turn[0]))
        for index, ratio in ((0x608F, turn), (0x6091, (1, 1)), (0x6092, turn)):
            add_array(index, [Variable(UNSIGNED32, part, "ro") for part in ratio])
        self.position_offset = commanded(0x60B0, INTEGER32)
        self.velocity_offset = commanded(0x60B1, INTEGER32)
        self.interpolation = add_array(
            0x60C2, [Variable(UNSIGNED8, 1, low=1), Variable(INTEGER8, -3, low=-6, high=0)]
        )
        self.following_error = measured(0x60F4, INTEGER32)
        measured(0x60FD, UNSIGNED32)  # inputs, to which something may be wired
        self.target_velocity = commanded(0x60FF, INTEGER32)
        supported = sum(1 << mode - 1 for mode in modes)
        add(0x6502, 0, Variable(UNSIGNED32, supported, "ro"))


def error_register(code: int) -> int:
    """Return the bit of 0x1001 for an error code."""
    groups: dict[int, int] = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08}
    if code >> 8 in (0x81, 0x82):
        return 0x10
    return groups.get(code >> 12, 0x20)


def _one_of(permitted: Collection[int], value: int) -> None:
    if value not in permitted:
        raise SdoAbortError(Abort.RANGE)
