"""How long a loop took, by its own clock and by the wall's."""

from time import perf_counter

from rig.hal import Clock


class Stopwatch:
    """Takes the loop's time by its own clock and by the wall's, however it ends."""

    def __init__(self, clock: Clock) -> None:
        self._clock = clock
        self._took = self._covered = 0.0

    def __enter__(self) -> None:
        self._took, self._covered = -perf_counter(), -self._clock.now()

    def __exit__(self, *_: object) -> None:
        self._took += perf_counter()
        self._covered += self._clock.now()

    @property
    def facts(self) -> dict[str, float]:
        """How long the loop took, s, and how many times real time that is."""
        return {"took": self._took, "speed": self._covered / self._took} if self._took else {}

    def __str__(self) -> str:
        factor = self._covered / self._took if self._took else 0.0
        return f"{self._covered:.1f} s took {self._took:.1f} s: {factor:.3g} times real time"
