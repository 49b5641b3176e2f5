"""Faults of a device that has several joints, addressed by joint."""

from collections.abc import Iterable, Mapping
from typing import Protocol

from drivers.sim.faults import Faulty


class NamedFaulty(Faulty, Protocol):
    """Something with a name that can be broken on purpose."""

    name: str


class AxisFaults:
    """The joints of one device as one target of faults.

    ``q3.drive_fault`` happens to joint q3, ``drive_fault`` to every joint that knows it.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    joints : mapping of str to Faulty
        What stands for each joint: its emulated drive, or the joint of a simulated device.
    """

    def __init__(self, name: str, joints: Mapping[str, Faulty]) -> None:
        self.name = name
        self._joints = dict(joints)

    @property
    def known_faults(self) -> tuple[str, ...]:
        """Names that `inject` understands."""
        common = dict.fromkeys(
            fault for joint in self._joints.values() for fault in joint.known_faults
        )
        own = [
            f"{name}.{fault}"
            for name, joint in self._joints.items()
            for fault in joint.known_faults
        ]
        return (*common, *own)

    def inject(self, fault: str, value: float | None = None) -> None:
        """Make a fault happen now, to one joint or to all.

        Raises
        ------
        ValueError
            There is no such joint or fault, or the value does not fit it.
        """
        name, dot, own = fault.partition(".")
        if not dot:
            joints = self._joints.values()
            # One drive reads the emergency stop, say: then it alone can suffer what it knows.
            for joint in [one for one in joints if fault in one.known_faults] or joints:
                joint.inject(fault, value)
        elif name in self._joints:
            self._joints[name].inject(own, value)
        else:
            known = ", ".join(self._joints)
            raise ValueError(f"{self.name}: no joint {name!r} to fail; there are {known}")


def faults_by_joint(nodes: Iterable[NamedFaulty]) -> dict[str, Faulty]:
    """Return the devices whose joints are nodes of their own, named ``device.joint``."""
    devices: dict[str, dict[str, Faulty]] = {}
    for node in nodes:
        device, dot, joint = node.name.partition(".")
        if dot:
            devices.setdefault(device, {})[joint] = node
    return {device: AxisFaults(device, joints) for device, joints in devices.items()}
