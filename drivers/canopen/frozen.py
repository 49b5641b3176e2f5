"""Readings that stay the same to the last count, as no sensor's do that lives."""

from collections.abc import Sequence
from math import inf

from rig.hal import DeviceFault


class FrozenInputs:
    """Finds out that none of a node's values changes any more.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    timeout : float or None
        For how long all values may be the same, s; None: for ever.
    """

    def __init__(self, name: str, timeout: float | None) -> None:
        self._name = name
        self._timeout = inf if timeout is None else timeout
        self.restart()

    def restart(self) -> None:
        """Forget what came before."""
        self._values: tuple[float, ...] = ()
        self._changed = self._seen = 0.0

    def see(self, values: tuple[float, ...], t: float) -> None:
        """Take a sample, in counts, and its time, s. Hot path."""
        self._seen = t
        if values != self._values:
            self._values, self._changed = values, t

    def check(self) -> None:
        """Raise if they have been the same for too long.

        Raises
        ------
        DeviceFault
            With for how long, and how long they may.
        """
        same = self._seen - self._changed
        if same > self._timeout:
            raise DeviceFault(
                self._name,
                "its readings are frozen: no count has changed",
                value=f"{same:.3g} s",
                bound=f"{self._timeout:g} s",
            )


class FrozenChannels(FrozenInputs):
    """Finds out that one of a node's values does not change any more, while others may.

    Parameters
    ----------
    name : str
        The device's name in the profile.
    timeout : float or None
        For how long a value may be the same, s; None: for ever.
    channels : sequence of str
        What each value is of.
    """

    def __init__(self, name: str, timeout: float | None, channels: Sequence[str]) -> None:
        self._channels = tuple(channels)
        super().__init__(name, timeout)

    def restart(self) -> None:
        """See `FrozenInputs.restart`."""
        super().restart()
        self._changes = [0.0] * len(self._channels)

    def see(self, values: tuple[float, ...], t: float) -> None:
        """See `FrozenInputs.see`. Hot path."""
        before = self._values
        super().see(values, t)
        if not before:
            self._changes = [t] * len(self._channels)
            return
        changes = self._changes
        for k, value in enumerate(values):
            if value != before[k]:
                changes[k] = t

    def check(self) -> None:
        """Raise if all values or some have been the same for too long; see `FrozenInputs.check`."""
        longest = self._seen - min(self._changes, default=self._seen)
        if longest <= self._timeout:
            return
        # A live value may be the same twice by chance, and so one may seem to freeze before others.
        limit = self._seen - 0.5 * self._timeout
        still = [name for name, t in zip(self._channels, self._changes, strict=True) if t < limit]
        of_all = len(still) == len(self._channels)
        raise DeviceFault(
            self._name,
            "its readings are frozen: no count has changed"
            if of_all
            else f"frozen: no count has changed of {', '.join(still)}",
            value=f"{longest:.3g} s",
            bound=f"{self._timeout:g} s",
        )
