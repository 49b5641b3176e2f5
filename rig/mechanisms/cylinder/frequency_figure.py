"""The frequency response of a pair, beside what the linear model of `rig check` says of it."""

from typing import TYPE_CHECKING

import numpy as np

from rig.assembly import REGISTRY, make_law
from rig.config import load_profile
from rig.hal import RigError
from rig.report.data import RunData
from rig.report.figure import FigureKind
from rig.report.frequency_figure import Linear, draw_response

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


def draw_pair_response(run: RunData) -> "Figure | None":
    """Draw gain and phase of the position in each sine, and those of the linear loop."""
    columns = {"position": ("reference.position", "reading.position")}
    return draw_response(run, columns, _linear(run))


def _linear(run: RunData) -> Linear | None:
    """Return the response of the loop that the run's law closes, as far as it is linear.

    None where it is not known: the law may be of a package that is not here any more.
    """
    law_name = run.folder.manifest.get("law")
    try:
        profile = load_profile(run.folder.path / "profile.yaml", REGISTRY)
        law = make_law(profile, str(law_name))
    except (RigError, OSError):
        return None
    from controllers.cylinder.law import PairLaw
    from controllers.cylinder.margins import reference_response

    if not isinstance(law, PairLaw):
        return None

    def response(frequencies: "NDArray[np.float64]") -> "NDArray[np.complex128]":
        return reference_response(law, law.model, frequencies)

    return response


PAIR_RESPONSE = {
    "frequency-response": FigureKind(
        draw_pair_response,
        "Gain and phase of the reading over the reference in each sine; dashed, what the linear "
        "model of `rig check` gives, without the friction of the seals.",
    ),
}
