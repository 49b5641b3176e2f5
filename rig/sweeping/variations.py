"""Variations of a rig by name: each changes some settings at once, and one changes none."""

from collections.abc import Mapping
from typing import Final, NamedTuple

from rig.config.setting import Setting
from rig.hal import ConfigurationError
from rig.sweeping.axis import MAX_VALUES

VARIATION: Final = "variation"
"""The column of their names."""
NOMINAL: Final = "nominal"
"""The variation that changes nothing."""
WORST: Final = "worst"
"""What a table calls the worst of all."""


class Variations(NamedTuple):
    """An axis whose values are sets of settings, and have names.

    Parameters
    ----------
    texts : tuple of str
        Their names, `NOMINAL` first.
    changes : mapping of str to tuple of str
        What each one changes, as for ``--set``.
    """

    texts: tuple[str, ...]
    changes: Mapping[str, tuple[str, ...]]

    @property
    def setting(self) -> str:
        """The name of its column."""
        return VARIATION

    @property
    def varied(self) -> frozenset[str]:
        """The settings that any of them changes."""
        changes = (change for options in self.changes.values() for change in options)
        return frozenset(change.partition("=")[0] for change in changes)

    def options(self, text: str) -> tuple[Setting, ...]:
        """Return the settings of one of them."""
        return tuple(
            Setting(change, f"{VARIATION}s: {text}: {change.replace('=', ': ', 1)}")
            for change in self.changes[text]
        )


def make_variations(named: Mapping[str, tuple[str, ...]]) -> Variations:
    """Return variations from their names and what each one changes, as for ``--set``.

    Raises
    ------
    ConfigurationError
        A name is none that a table can have, or something changes nothing.
    """
    if not 1 <= len(named) < MAX_VALUES:
        raise ConfigurationError(f"{len(named):,} variations; there may be 1 to {MAX_VALUES - 1:,}")
    for name, changes in named.items():
        if name in (NOMINAL, WORST) or not name[:1].isalpha():
            raise ConfigurationError(
                f"{name!r} is no name of a variation: it begins with a letter, and is neither "
                f"{NOMINAL!r} nor {WORST!r}, which every table has"
            )
        if not changes:
            raise ConfigurationError(f"{name}: it changes nothing, as in a.b: c")
    return Variations((NOMINAL, *named), {NOMINAL: (), **named})
