"""The notebook of `import rig`, executed as it stands."""

from pathlib import Path

import pytest

import rig

NOTEBOOK = Path(rig.__file__).parent / "scripting" / "first-steps.ipynb"

pytestmark = pytest.mark.slow


@pytest.mark.filterwarnings("ignore")  # of Jupyter's own packages
def test_the_notebook_runs_and_shows_its_figures(tmp_path):
    nbformat = pytest.importorskip("nbformat")
    client = pytest.importorskip("nbclient").NotebookClient
    notebook = nbformat.read(NOTEBOOK, 4)
    client(notebook, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    shown = [output.get("data", {}) for output in outputs]
    assert sum("image/png" in data for data in shown) == 3
    assert sum("text/html" in data for data in shown) == 2
    said = "".join(output.get("text", "") for output in outputs)
    assert "30 mm is outside limits.position" in said
    assert len(list((tmp_path / "runs").iterdir())) == 6


def test_it_is_kept_without_outputs():
    nbformat = pytest.importorskip("nbformat")
    cells = nbformat.read(NOTEBOOK, 4).cells
    assert not any(cell.get("outputs") for cell in cells)
