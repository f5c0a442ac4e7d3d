"""The examples in documents run as they stand."""
import os
import pathlib
import re

import pytest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
RESULTS = "results/runs/liver_healthy/"  # a folder of the reader's


def examples(document):
    return re.findall(r"```python\n(.*?)```", (SOURCE / document).read_text(), re.DOTALL)


def run(blocks, scope):
    for block in blocks:  # each goes on from those before
        exec(block, scope)


@pytest.mark.parametrize("document", ["docs/howto/link_the_springs.md", "docs/howto/judge_my_engine.md", "docs/reference/python.md"])
def test_examples_run(document, monkeypatch, tmp_path):
    (tmp_path / "meshes").symlink_to(SOURCE / "meshes")  # so that files they write are not in the source tree
    monkeypatch.chdir(tmp_path)
    blocks = [block for block in examples(document) if "scene.h5" not in block]  # that is half of a program of the reader's
    assert blocks and "import livermark" in blocks[0]
    run(blocks, {})


def test_examples_of_result_files_run(monkeypatch):
    blocks = examples("docs/howto/read_result_files.md")
    assert len(blocks) == 1 and RESULTS in blocks[0]
    code = blocks[0].replace(RESULTS + "palpation.h5", "beam/beam_bend.h5").replace(RESULTS + "release.h5",
                                                                                    "beam/beam_release.h5")
    monkeypatch.chdir(os.environ["LIVERMARK_PYTHON_RUNS"])
    run(["import livermark", code.replace("left lobe tip", "end")], {})


def test_examples_for_slicer_run(monkeypatch, tmp_path):
    replaced = {"runs/seg/palpation.h5": os.environ["LIVERMARK_PYTHON_RUNS"] + "/beam/beam_bend.h5",
                '"runs/seg.toml", "traction"': '"beam", "beam_bend"'}
    code = "\n".join(examples("docs/howto/from_segmentation_to_table.md"))
    for written, here in replaced.items():
        assert written in code
        code = code.replace(written, here)
    monkeypatch.chdir(tmp_path)
    exec(code, {})
    assert {path.name for path in tmp_path.iterdir()} == {"errors.vtk", "moved.vtk", "liver.vtk"}
