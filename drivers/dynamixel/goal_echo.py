"""Whether servos have been told what they were sent: the goals that they hold."""

from collections.abc import Sequence

from drivers.dynamixel.bus import SerialBus
from drivers.dynamixel.health import HealthWatch
from drivers.dynamixel.registers import MOTION, Register
from drivers.servos.setpoint_echo import SetpointEcho


class GoalEcho:
    """Compares the goals that servos hold with the setpoints that they were sent, in counts.

    Goals are read behind the setpoints of the same cycle, so that each is the very setpoint.

    Parameters
    ----------
    goal : Register
        Of the goals.
    bus : SerialBus
        It counts the setpoints that were lost.
    count : int
        Of the servos that tell their goals; without any there is nothing to compare.
    """

    def __init__(self, goal: Register, bus: SerialBus, count: int) -> None:
        self._goal = goal
        period = bus.period or 0.0
        self._echoes = tuple(SetpointEcho(period, 0.0, exact=True, transit=1) for _ in range(count))
        bus.lost_setpoints += [echo.count_lost for echo in self._echoes]

    def reset(self) -> None:
        """Forget what was sent."""
        for echo in self._echoes:
            echo.reset()

    def send(self, goals: Sequence[int]) -> None:
        """Take the setpoints of this cycle."""
        for echo, goal in zip(self._echoes, goals, strict=False):
            echo.send(goal)

    def hear(self, samples: Sequence[tuple[int, ...]]) -> None:
        """Take what the servos tell of themselves: their goals stand behind their motion."""
        for echo, sample in zip(self._echoes, samples, strict=False):
            echo.hear(sample[len(MOTION)])

    def check(self, health: HealthWatch) -> None:
        """Raise if a servo holds a goal that is older than all setpoints of the last cycles.

        Raises
        ------
        DeviceFault
            Which servo, and by how much.
        """
        for k, echo in enumerate(self._echoes):
            missing = echo.missing
            if missing is not None:
                what = "does not get its setpoints, or gets them late"
                raise health.describe(k, what, self._goal, f"{missing:+g} counts behind")
