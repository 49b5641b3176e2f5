"""What the settings of a device say of its CANopen nodes, and of its EDS."""

from collections.abc import Mapping
from pathlib import Path

from drivers.can.device_settings import CanDeviceSettings
from drivers.canopen.described import DescribedNode
from drivers.canopen.mapping import MappedObjects, layout_size
from rig.hal import DeviceFile, DriverSettings
from rig.hal.driver import Keys, Scalar


class CanopenDeviceSettings(CanDeviceSettings):
    """Base of the settings of a driver of CANopen nodes.

    From `describe_nodes` alone frames are decoded, the bus's load is computed, an EDS is compared,
    and nodes are emulated that have no simulation of their own.
    """

    __slots__ = ()

    def describe_nodes(self, name: str) -> tuple[DescribedNode, ...]:
        """Return what each node exchanges and what its counts mean.

        Parameters
        ----------
        name : str
            The device's name in the profile.
        """
        return ()

    @staticmethod
    def typed_objects(plain: Mapping[str, object]) -> dict[tuple[str, ...], tuple[int, int]]:
        """Return index and sub-index of every object whose type is a setting, by its keys.

        Parameters
        ----------
        plain : mapping
            The settings as they were written; they may have errors.
        """
        return {}

    @staticmethod
    def mapped_settings(plain: Mapping[str, object], objects: MappedObjects) -> dict[Keys, Scalar]:
        """Return the settings by which a device exchanges what it has, by their keys.

        Parameters
        ----------
        plain : mapping
            The settings of a device like it.
        objects : MappedObjects
            What it can exchange.
        """
        return {}

    def cyclic_frames(self) -> tuple[tuple[str, int], ...]:
        """Return every PDO that is exchanged with each SYNC: names and bytes."""
        return tuple(
            (f"{node.name} {kind}{number} {content}".strip(), layout_size(layout))
            for node in self.describe_nodes("")
            for kind, layouts, content in zip(
                ("RPDO", "TPDO"), (node.receive, node.transmit), node.contents, strict=True
            )
            for number, layout in enumerate(layouts, 1)
        )

    def timed_frames(self, heartbeat: float) -> tuple[tuple[str, int, float], ...]:
        """Return one heartbeat per node: names, bytes and rates, Hz."""
        return tuple(
            (f"{node.name} heartbeat".strip(), 1, 1.0 / heartbeat)
            for node in self.describe_nodes("")
        )

    @classmethod
    def read_description(cls, path: Path) -> DeviceFile | None:
        """Read the EDS of the device; its settings have a field ``eds`` for its path.

        Raises
        ------
        EdsError
            It cannot be read or understood.
        """
        from drivers.canopen.eds_check import EdsFile

        return EdsFile(path, cls.typed_objects, nodes_of, cls.mapped_settings)


def nodes_of(device: str, settings: DriverSettings) -> tuple[DescribedNode, ...]:
    """Return the nodes that a device's settings describe; none if they are not of this kind."""
    return settings.describe_nodes(device) if isinstance(settings, CanopenDeviceSettings) else ()
