"""What may break of the interfaces to a rig's buses and lines."""

from functools import partial

from rig.faults.kind import Magnitudes, either, ride
from rig.faults.world_kinds import MOMENT, outlasts_readings, row_of, whole

KINDS = (
    row_of("frame_loss", "Frames are lost at random.", partial(whole, "frame_loss", ()), either,
          magnitude=Magnitudes(1e-3, 0.5, "1"),
          why="a few in a row are bridged; whether there are more is chance"),
    row_of("foreign_frame", "Somebody else sends a frame.",
          partial(whole, "foreign_frame", ()), ride),
    row_of("flood", "Somebody else fills the bus.", partial(whole, "flood", ()), either,
          magnitude=Magnitudes(8.0, 4000.0, "1"), why="frames that nobody wants cost time only"),
    row_of("no_buffers", "Nothing can be sent any more.", partial(whole, "no_buffers", ())),
    row_of("no_buffers_burst", "Nothing can be sent for a moment.",
          partial(whole, "no_buffers", ()), outlasts_readings, fault="no_buffers", lasts=MOMENT,
          why="a gap within the age that a reading may have is bridged"),
    row_of("bus_off", "The CAN controller leaves the bus.", partial(whole, "bus_off", ())),
    row_of("error_passive", "The CAN controller counts errors.",
          partial(whole, "error_passive", ()), either, why="frames still pass"),
    row_of("link_down", "The interface is taken down.", partial(whole, "link_down", ())),
    row_of("unplugged", "The serial adapter is pulled out.", partial(whole, "unplugged", ())),
    row_of("noise", "A serial line brings bytes that mean nothing.",
          partial(whole, "noise", ()), either, magnitude=Magnitudes(1.0, 300.0, "1"),
          why="an answer that is spoilt is a gap"),
)  # fmt: skip
