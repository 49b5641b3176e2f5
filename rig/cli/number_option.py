"""The type of options that take a number."""

from __future__ import annotations

from math import isfinite
from typing import cast

import click


class NumberWithin(click.FloatRange):
    """A finite number within a range; click's own type lets nan pass, and inf where no end is."""

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """Return the number if it is one and within the range."""
        number: float = super().convert(cast("float", value), param, ctx)
        if not isfinite(number):
            self.fail(f"{number} is not in the range {self._describe_range()}.", param, ctx)
        return number
