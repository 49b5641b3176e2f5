"""Run experiments and print the metrics of each: ``python same_metrics.py NAME …``."""

import json
import sys
import tempfile
from pathlib import Path

CONFIGS = Path(__file__).parents[2] / "configs"


def main() -> None:
    """Print a line of JSON for every experiment of the arguments: its name, and the file's text."""
    from rig.assembly import Backend
    from rig.experiment.plan import load_plan
    from rig.experiment.run import run_experiment

    for name in sys.argv[1:]:
        with tempfile.TemporaryDirectory() as out:
            plan = load_plan(name, [], configs=CONFIGS)
            folder = run_experiment(plan, Backend.SIM, Path(out), report=False).path
            text = (folder / "metrics.json").read_text()
        sys.stdout.write(json.dumps([name, text]) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
