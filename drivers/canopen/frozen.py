"""Readings that stay the same to the last count, as no sensor's do that lives."""

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
