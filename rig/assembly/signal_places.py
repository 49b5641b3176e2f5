"""Whether the counts of an analogue line were said of the signal that it has now."""

from rig.config import Profile
from rig.hal import SeveralErrors


def check_signal_places(profile: Profile) -> None:
    """Refuse counts that a file says of a voltage where another one makes a current of it.

    The line would be read by counts of another wire: 4 to 20 mA by those of 1 to 5 V.

    Raises
    ------
    ConfigurationError
        With the keys; their places are found by their names.
    """
    places = profile.places
    found = []
    for key, counts in places.items():
        line, _, what = key.rpartition(".")
        signals = [places.get(f"{line}.{kind}") for kind in ("voltage", "current")]
        if what != "raw" or None in signals:
            continue
        if all(place is not None and _file(place) != _file(counts) for place in signals):
            found.append(
                f"{line}.raw was said of another signal than {line}.voltage and {line}.current now "
                "leave; say the counts at both ends beside the signal, by the module's manual"
            )
    SeveralErrors.raise_if_any(found)


def _file(place: str) -> str:
    return place.rsplit(":", 2)[0]
