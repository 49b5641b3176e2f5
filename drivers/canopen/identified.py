"""Devices that tell who they are, and what was written to them, by their node."""

from collections.abc import Mapping
from typing import Final

from drivers.canopen.node import CanopenNode

_PARTS: Final = {1: "vendor", 2: "product", 3: "firmware", 4: "serial"}
"""Of 0x1018."""


def ask_identity(node: CanopenNode) -> dict[str, int]:
    """Return the parts of a node's identity object that it has."""
    found = {what: node.read_if_present(0x1018, sub, "u32") for sub, what in _PARTS.items()}
    return {what: int(value) for what, value in found.items() if value is not None}


class IdentifiedDevice:
    """A device on one CANopen node."""

    _node: CanopenNode

    def identity(self) -> Mapping[str, int]:
        """Ask for its identity object; see `rig.hal.Device.identity`."""
        return ask_identity(self._node)

    def written(self) -> Mapping[str, float]:
        """Return the objects that were read back; see `rig.hal.Device.written`."""
        return self._node.written
