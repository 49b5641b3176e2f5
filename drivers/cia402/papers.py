"""What a drive is, what it was told, and whether it still obeys: asked outside of the cycle."""

from collections.abc import Mapping

from drivers.canopen.identified import ask_identity
from drivers.canopen.node import CanopenNode
from drivers.cia402.states import DriveState, decode_state


class DrivePapers:
    """Part of a `drivers.cia402.drive.Cia402Drive`."""

    node: CanopenNode

    def identity(self) -> Mapping[str, int]:
        """Ask for its identity object; see `AxisDrive.identity`."""
        return ask_identity(self.node)

    @property
    def written(self) -> Mapping[str, float]:
        """The objects that were read back; see `AxisDrive.written`."""
        return self.node.written

    def follows_still(self) -> bool:
        """Ask for the status word by SDO; see `AxisDrive.follows_still`."""
        status = int(self.node.read(0x6041, 0, "u16"))
        return decode_state(status) is DriveState.OPERATION_ENABLED
