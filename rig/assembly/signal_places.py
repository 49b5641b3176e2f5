"""Whether the counts of an analogue line were said of the signal that it has now."""

from rig.config import Profile
from rig.hal import SeveralErrors


def check_signal_places(profile: Profile) -> None:
    """Refuse counts that a file says of a voltage where one over it makes a current of it.

    The line would be read by counts of another wire: 4 to 20 mA by those of 1 to 5 V. Counts that
    are said over the signal, by a file that extends the signal's or by an option, are its own.

    Raises
    ------
    ConfigurationError
        With the keys; their places are found by their names.
    """
    places = profile.places
    layers = {str(file): layer for layer, file in enumerate(reversed(profile.files))}
    found = []
    for key, counts in places.items():
        line, _, what = key.rpartition(".")
        if what != "raw":
            continue
        signals = [places.get(f"{line}.{kind}") for kind in ("voltage", "current")]
        said = [_layer(place, layers) for place in signals if place is not None]
        if len(said) == len(signals) and min(said) > _layer(counts, layers):
            found.append(
                f"{line}.raw was said of another signal than {line}.voltage and {line}.current now "
                "leave; say the counts at both ends beside the signal, by the module's manual"
            )
    SeveralErrors.raise_if_any(found)


def _layer(place: str, layers: dict[str, int]) -> int:
    """Return how far up a place is: a file lies over those that it extends, an option over all."""
    return layers.get(place.rsplit(":", 2)[0], len(layers))
