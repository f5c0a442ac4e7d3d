"""Bodies in files of one name are kept apart by what is in the files: nobody gets the numbers of somebody else."""
import shutil
import subprocess

import livermark
import numpy
import pytest
from conftest import BINARY


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two boxes of one name, whose meshes have the same tetrahedra."""
    folder = tmp_path_factory.mktemp("bodies")
    for patient, size in (("a", "0.2"), ("b", "0.21")):
        (folder / patient).mkdir()
        subprocess.run([BINARY, "mesh", "box", "--size", size, "0.1", "0.1", "--edge", "0.05", "--topology", "kuhn", "-o",
                        folder / patient / "box.msh"], check=True, capture_output=True)
    (folder / "box.toml").write_text('title = "pull"\ntarget_peak_displacement = 0.001\n'
                                     '[[condition]]\npatch = "x_min"\ndisplacement = [0.0, 0.0, 0.0]\n'
                                     '[[condition]]\npatch = "x_max"\ntraction = [10.0, 0.0, 0.0]\n')
    return folder


def body(file):
    """With materials, which a mesh alone has not."""
    toml = file.with_suffix(".toml")
    toml.write_text(f'title = "box"\nmesh = "{file.name}"\n[regions.solid]\nsource = "a test"\ndensity = 1000.0\n'
                    'young_modulus = 5000.0\npoisson_ratio = 0.45\n')
    return toml


def numbers_of(file, load_case):
    problem = livermark.problem(body(file), load_case)
    solution = problem.solve("fem_p1")
    score = problem.score(solution.displacement, reference_on_mesh=True)
    return problem.points, solution.displacement, score.error


def test_a_body_of_the_same_name_has_numbers_of_its_own(folder):
    of_a, of_b = (numbers_of(folder / patient / "box.msh", folder / "box.toml") for patient in "ab")
    assert of_a[0].shape == of_b[0].shape
    for ours, theirs in zip(of_a, of_b):
        assert not numpy.allclose(ours, theirs, rtol=1e-3)
    again = numbers_of(folder / "a" / "box.msh", folder / "box.toml")
    assert all(numpy.array_equal(once, twice) for once, twice in zip(of_a, again))


def test_a_body_that_was_edited_has_the_numbers_of_what_it_is_now(folder):
    numbers_of(folder / "a" / "box.msh", folder / "box.toml")
    of_b = numbers_of(folder / "b" / "box.msh", folder / "box.toml")
    shutil.copy2(folder / "a" / "box.msh", folder / "kept.msh")
    shutil.copy2(folder / "b" / "box.msh", folder / "a" / "box.msh")
    edited = numbers_of(folder / "a" / "box.msh", folder / "box.toml")
    shutil.copy2(folder / "kept.msh", folder / "a" / "box.msh")
    assert all(numpy.array_equal(ours, theirs) for ours, theirs in zip(edited, of_b))


def test_a_mesh_and_a_result_that_were_replaced_are_read_anew(folder, tmp_path):
    file = tmp_path / "box.msh"
    for patient in "aba":
        shutil.copy2(folder / patient / "box.msh", file)
        found = livermark.from_meshio(file)
        assert found.points[:, 0].max() == pytest.approx(0.2 if patient == "a" else 0.21)
    results = {}
    for patient in "ab":
        problem = livermark.problem(body(folder / patient / "box.msh"), folder / "box.toml")
        results[patient] = tmp_path / f"{patient}.h5"
        problem.score(problem.solve("lloyd").displacement, reference_on_mesh=True, output=str(results[patient]))
    for patient in "abab":
        shutil.copy2(results[patient], tmp_path / "result.h5")
        with livermark.open(tmp_path / "result.h5") as result:
            assert result.points[:, 0].max() == pytest.approx(0.2 if patient == "a" else 0.21)
