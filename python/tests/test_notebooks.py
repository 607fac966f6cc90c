"""The notebooks run, and say what is stored in them. `WRITE_NOTEBOOKS=1` stores what they say now."""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

NOTEBOOKS = Path(__file__).parents[1] / "notebooks"


def texts(notebook):
    """What each cell prints and shows as text; pictures are looked at by people."""
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return [
        "".join(
            output.get("text", "") or output.get("data", {}).get("text/plain", "")
            for output in cell.outputs
        )
        for cell in cells
    ]


@pytest.mark.parametrize("path", sorted(NOTEBOOKS.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_says_what_is_stored_in_it(path):
    stored = nbformat.read(path, as_version=4)
    run = nbformat.read(path, as_version=4)
    # The interpreter of the tests, not one that some kernel specification names.
    NotebookClient(run, timeout=300, resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    for cell in run.cells:
        cell.metadata.pop("execution", None)
    if os.environ.get("WRITE_NOTEBOOKS") == "1":
        nbformat.write(run, path)
        return
    assert texts(run) == texts(stored)
    outputs = [output for cell in run.cells if cell.cell_type == "code" for output in cell.outputs]
    assert any(len(output.get("data", {})) > 1 for output in outputs), "every notebook shows a picture"
