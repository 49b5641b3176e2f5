"""Run experiments and print a digest of each one's metrics: ``python same_metrics.py NAME …``."""

import hashlib
import sys
import tempfile
from pathlib import Path

CONFIGS = Path(__file__).parents[2] / "configs"


def main() -> None:
    """Print ``NAME DIGEST`` for every experiment of the arguments."""
    from rig.assembly import Backend
    from rig.experiment.plan import load_plan
    from rig.experiment.run import run_experiment

    for name in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as out:
            plan = load_plan(name, [], configs=CONFIGS)
            folder = run_experiment(plan, Backend.SIM, Path(out), report=False).path
            digest = hashlib.sha256((folder / "metrics.json").read_bytes()).hexdigest()
        sys.stdout.write(f"{name} {digest}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
