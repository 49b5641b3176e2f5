"""What an axis is, what it was told, and whether it still obeys: as it says by itself."""

from collections.abc import Mapping

from drivers.odrive.client import OdriveClient
from drivers.odrive.codec import AxisState


class AxisPapers:
    """Part of a `drivers.odrive.axis.OdriveAxis`."""

    client: OdriveClient

    def identity(self) -> Mapping[str, int]:
        """Return serial number and firmware, as `connect` got them; see `AxisDrive.identity`."""
        major, minor, revision = self.client.firmware
        firmware = 10_000 * major + 100 * minor + revision
        # Two that have one number are refused before.
        return {"serial": min(self.client.serials, default=0), "firmware": firmware}

    @property
    def written(self) -> Mapping[str, float]:
        """The parameters that were read back; see `AxisDrive.written`."""
        return self.client.written

    def follows_still(self) -> bool:
        """Say it by its next heartbeat; see `AxisDrive.follows_still`."""
        self.client.wait_for_heartbeat()
        return self.client.state == AxisState.CLOSED_LOOP_CONTROL
