"""Devices of `--on sim`: the capabilities straight on a plant, without a bus.

They behave as the production drivers do on their bus: a reading is quantised and one cycle old
(it was sampled when the cycle before it ended), a setpoint acts in its own cycle. The loop calls
`check` once a cycle after it has taken its readings; that is when the next ones are sampled.
"""

from drivers.sim.breakable import Breakable
from rig.hal import Clock, Device


class SimulatedDevice(Breakable, Device):
    """Base of the devices: faults by name, and silence."""

    def __init__(self, name: str, clock: Clock) -> None:
        super().__init__()
        self.name = name
        self._clock = clock
        self._silent_until = 0.0
        self.add_fault("silent", self._fall_silent, self._end_silence)

    def close(self) -> None:
        """Release nothing: there is no bus."""

    def _is_silent(self) -> bool:
        return self._clock.now() < self._silent_until

    def _until(self, fault: str, duration: float | None) -> float:
        return self._clock.now() + self.lasting_time(fault, duration)

    def _fall_silent(self, duration: float | None) -> None:
        self._silent_until = self._until("silent", duration)

    def _end_silence(self) -> None:
        self._silent_until = 0.0
