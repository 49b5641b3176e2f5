"""What ends a program during an acceptance test ends a step of it, and its rig is made safe."""

from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from types import FrameType

from rig.runtime.stop import PATIENCE, StopRequests


class StepInterrupts(StopRequests):
    """Ends a step at the first request, and whatever closes its rig is not torn by the next one.

    A further request interrupts again only `PATIENCE` after the last one that did: something may
    have swallowed that. A run that is part of a step hears its own requests.
    """

    def __init__(self) -> None:
        super().__init__()
        self._raised = -PATIENCE

    @contextmanager
    def held_back(self) -> Iterator[None]:
        """Hold requests back; one that has come ends the test after the block.

        Raises
        ------
        KeyboardInterrupt
            There was a request; it says what the block raised, if it did.
        """
        was_held, self.shielded = self.shielded, True
        trouble = ""
        try:
            yield
        except Exception as error:
            if not self.count:
                raise
            trouble = str(error) or type(error).__name__
        finally:
            self.shielded = was_held
        if self.count and not was_held:
            raise KeyboardInterrupt(*([trouble] if trouble else []))

    def _handle(self, number: int, frame: FrameType | None) -> None:
        self.request()
        now = monotonic()
        if not self.shielded and now - self._raised >= PATIENCE:
            self._raised = now
            raise KeyboardInterrupt
