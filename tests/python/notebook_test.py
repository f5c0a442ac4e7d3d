"""The example notebooks run as they stand, and are stored without results."""
import json
import os
import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("nbconvert")
pytest.importorskip("ipykernel")
FOLDER = pathlib.Path(__file__).resolve().parents[2] / "examples"
PRINTS = {
    "compare_models": "volume terms help under pressure: True",
    "score_your_model": "of fem_p2p1, at most",
    "seed_paper": "h = 0.005 s: 5 of 6 without tumour, 5 of 6 with tumour, 0 of 2 whole livers are stable",
    "springs_for_your_simulator": "reaction: -0.1000 N"}
NEEDS = {"compare_models": "matplotlib", "seed_paper": "matplotlib"}


def test_every_notebook_is_tested():
    assert {path.stem for path in FOLDER.glob("*.ipynb")} == set(PRINTS)


@pytest.mark.parametrize("name", PRINTS)
def test_notebook_runs(name, tmp_path):
    if name in NEEDS:
        pytest.importorskip(NEEDS[name])
    quiet = {word: str(tmp_path) for word in ("JUPYTER_RUNTIME_DIR", "JUPYTER_CONFIG_DIR", "IPYTHONDIR", "MPLCONFIGDIR", "TMPDIR")}
    subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output-dir", tmp_path,
                    FOLDER / f"{name}.ipynb"], check=True, env={**os.environ, **quiet}, timeout=500)
    cells = json.loads((tmp_path / f"{name}.ipynb").read_text())["cells"]
    printed = "".join(text for cell in cells if cell["cell_type"] == "code" for output in cell["outputs"]
                      for text in output.get("text", []))
    assert PRINTS[name] in printed


@pytest.mark.parametrize("name", PRINTS)
def test_notebook_is_short_and_stored_without_results(name):
    cells = json.loads((FOLDER / f"{name}.ipynb").read_text())["cells"]
    assert len(cells) < 15 and all(not cell["outputs"] for cell in cells if cell["cell_type"] == "code")
