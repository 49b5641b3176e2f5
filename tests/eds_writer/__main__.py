"""Write the EDS files of the emulated nodes: ``python tests/eds_writer configs/eds``."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from eds_writer.description import NODES, describe


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for kind in NODES:
        (folder / f"{kind}.eds").write_text(describe(kind), encoding="ascii")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
