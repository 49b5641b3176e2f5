"""What a mechanism says of a rig that is stopped: part of `rig.hal.Mechanism`."""

from typing import Protocol, TypeVar

State = TypeVar("State", contravariant=True)


class Standing(Protocol[State]):
    """A mechanism while it is released and made safe, and after it."""

    def strays(self, state: State) -> bool:
        """Return whether it moves off while an orderly stop releases it, which is then cut short.

        Called in each cycle of the release. Default: what is released is free to move.
        """
        return False

    def unsafe(self, now: float) -> str:
        """Return why the rig is not known to be safe though its devices say so; empty: it is.

        Called in each cycle of the safe stop, which goes on until nobody has anything to say.
        Default: what the devices say is all that is known.
        """
        return ""

    def pose_held(self) -> str | None:
        """Say how the mechanism is held after a fault, for the operator; None: it is not."""
        return None
