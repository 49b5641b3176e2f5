"""What an installation weighs, by part: `python .readme/sizes.py` prints the table of the figures.

It counts the files of every package that `pip install .` draws in, as they lie on this disk.
"""

import sys
from importlib import metadata

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

OURS = "rig-controller"
PARTS = {
    "compiled laws and plants": ("numba", "llvmlite"),
    "numbers and figures": ("numpy", "scipy", "matplotlib", "filterpy", "cma"),
    "camera of the joint": ("opencv-python-headless",),
    "simulated arm and legs": ("mujoco",),
    "buses, files, command line": (),
}
"""Each with what it is for; what it needs besides is counted where it is first needed."""


def weight_of(name: str) -> int:
    """Return what the files of a package weigh, bytes."""
    return sum(
        path.stat().st_size
        for file in metadata.files(name) or ()
        if (path := file.locate()).is_file() and path.suffix != ".pyc"
    )


def needed_by(name: str) -> set[str]:
    """Return the packages that one draws in on this machine, itself among them."""
    found, waiting = set(), [name]
    while waiting:
        one = canonicalize_name(waiting.pop())
        if one in found:
            continue
        found.add(one)
        for text in metadata.requires(one) or ():
            requirement = Requirement(text)
            if requirement.marker is None or requirement.marker.evaluate({"extra": ""}):
                waiting.append(requirement.name)
    return found


def main() -> None:
    """Print the table."""
    everything, counted = needed_by(OURS) - {OURS}, {"numpy"}  # which everything needs
    write = sys.stdout.write
    write("| part | packages | MB |\n|---|---|---|\n")
    total = 0.0
    for part, roots in PARTS.items():
        mine = set().union(*map(needed_by, roots)) if roots else everything
        mine = (mine - counted) | ({"numpy"} if "numpy" in roots else set())
        counted |= mine
        weight = 1e-6 * sum(map(weight_of, mine))
        total += weight
        heavy = sorted(mine, key=weight_of, reverse=True)[:3]
        write(f"| {part} | {', '.join(heavy)}{' …' if len(mine) > 3 else ''} | {weight:.0f} |\n")
    write(f"| all | {len(everything)} packages | {total:.0f} |\n")


if __name__ == "__main__":
    main()
