"""Draw the README's picture: what three runs in simulation left, side by side."""

import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib import image

TARGET = Path(__file__).with_name("rigs.png")
LEFT_HALF = (slice(60, None), slice(None, 736))
"""Of the arm's figure, without the legend above both halves."""
RIG = (sys.executable, "-c", "from rig.cli import main; main()")


def figure_of(experiment: str, name: str, folder: str) -> "image.AxesImage":
    """Run an experiment and return one of its figures."""
    place = Path(folder, experiment)
    subprocess.run(
        [*RIG, "run", experiment, "--on", "sim", "--out", str(place)],
        check=True,
    )
    return image.imread(next(place.glob(f"*/figures/{name}.png")))


with tempfile.TemporaryDirectory() as folder:
    joint = figure_of("joint-ideal-circle", "marker-track", folder)[:, :660]
    arm = figure_of("arm-elbow-turnback", "arm", folder)[LEFT_HALF]
    legs = figure_of("legs-walk", "strip", folder)

sheet = plt.figure(figsize=(14.72, 11.2), dpi=100)
for picture, title, place in (
    (joint, "joint: the marker draws a circle on four pneumatic wires", (0.0, 0.36, 0.5, 0.58)),
    (arm, "arm: the hand turns back through the elbow's singularity", (0.5, 0.36, 0.5, 0.58)),
    (legs, "legs: a walk on stretched knees", (0.0, 0.0, 1.0, 0.31)),
):
    axes = sheet.add_axes(place)
    axes.imshow(picture)
    axes.set_title(title, fontsize=15, pad=4)
    axes.axis("off")
sheet.savefig(TARGET)
