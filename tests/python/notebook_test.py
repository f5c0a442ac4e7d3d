"""The example notebook runs as it stands, and is stored without results."""
import json
import os
import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("nbconvert")
pytest.importorskip("ipykernel")
NOTEBOOK = pathlib.Path(__file__).resolve().parents[2] / "examples" / "springs.ipynb"


def test_notebook_runs(tmp_path):
    quiet = {name: str(tmp_path) for name in ("JUPYTER_RUNTIME_DIR", "JUPYTER_CONFIG_DIR", "IPYTHONDIR")}
    subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", tmp_path, NOTEBOOK],
                   check=True, env={**os.environ, **quiet}, timeout=500)
    cells = json.loads((tmp_path / NOTEBOOK.name).read_text())["cells"]
    printed = "".join(text for cell in cells if cell["cell_type"] == "code" for output in cell["outputs"]
                      for text in output.get("text", []))
    assert "reaction: -0.1000 N" in printed


def test_notebook_is_stored_without_results():
    cells = json.loads(NOTEBOOK.read_text())["cells"]
    assert all(not cell["outputs"] for cell in cells if cell["cell_type"] == "code")
