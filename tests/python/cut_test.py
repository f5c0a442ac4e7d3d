"""Bodies that are cut: in Python, on the command line and in a load case they are the same, and exports name the wound."""
import re
import subprocess

import livermark
import numpy
import pytest
from conftest import BINARY

PLANE = [[0.083, 0.0, 0.0], [1.0, 0.0, 0.0]]
LOAD_CASE = """title = "Bend what is left"
target_peak_displacement = 0.001
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "wound"
traction = [0.0, 0.0, -1.0]
"""
CUT = """[[cut]]
half_space = { point = [0.083, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }
way = "exact"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cut")
    (folder / "after.toml").write_text(LOAD_CASE)
    (folder / "cuts.toml").write_text(LOAD_CASE + CUT)
    livermark.cut("beam", half_space=PLANE, way="exact", output=folder / "of_python.msh")
    return folder


def volume(body):
    a, b, c, d = (body.points[body.tetrahedra[:, k]] for k in range(4))
    return (numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6.0).sum()


@pytest.mark.parametrize("way", ["facets", "exact"])
def test_volume_is_conserved_and_the_wound_is_a_patch(way):
    cut = livermark.cut("beam", half_space=PLANE, way=way)
    assert volume(cut) + cut.removed_volume == pytest.approx(cut.volume_before, rel=1e-12)
    assert cut.removed_mass == pytest.approx(1060.0 * cut.removed_volume, rel=1e-12)
    assert cut.patch_names[-1] == "wound" and "x_max" not in cut.patch_names
    assert len(cut.parent_tetrahedron) == len(cut.tetrahedra) == len(cut.region)
    assert cut.wound_area > 0.99 * 0.04 * 0.04 and cut.notes


def test_command_line_and_load_case_cut_the_same_body(folder):
    subprocess.run([BINARY, "mesh", "cut", "beam", "--half-space", "0.083", "0", "0", "1", "0", "0", "--way", "exact", "-o",
                    folder / "of_command.msh"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    assert (folder / "of_command.msh").read_bytes() == (folder / "of_python.msh").read_bytes()
    written = livermark.problem(folder / "of_python.toml", folder / "after.toml")
    of_load_case = livermark.problem("beam", folder / "cuts.toml")
    assert any("removed" in note for note in of_load_case.notes)
    for name in ("points", "tetrahedra", "boundary_triangles", "boundary_patch", "fixed", "forces", "young_modulus"):
        assert numpy.array_equal(getattr(written, name), getattr(of_load_case, name)), name
    assert numpy.array_equal(written.solve("lloyd").displacement, of_load_case.solve("lloyd").displacement)


def test_body_file_may_have_the_cut(folder):
    text = (folder / "of_python.toml").read_text()
    before = re.sub(r"mesh = .*", f'mesh = "{livermark_mesh("beam.msh")}"', text) + CUT
    (folder / "described.toml").write_text(before)
    described = livermark.problem(folder / "described.toml", folder / "after.toml")
    written = livermark.problem(folder / "of_python.toml", folder / "after.toml")
    assert numpy.array_equal(described.points, written.points)


def livermark_mesh(name):
    import os
    return os.path.join(os.environ["LIVERMARK_SOURCE_DIR"], "meshes", name)


def test_cut_body_runs_and_a_support_that_is_gone_is_refused(folder):
    run = [BINARY, "run", "--body", folder / "of_python.toml", "--load-case", folder / "after.toml", "--model", "lloyd",
           "--reference-on-mesh", "--output", folder / "runs"]
    subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with livermark.open(folder / "runs" / "of_python" / "after.h5") as result:
        assert result["lloyd"].status == "ok"
    (folder / "gone.toml").write_text(LOAD_CASE.replace("x_min", "x_max") + CUT)
    with pytest.raises(livermark.InputError, match="no patch 'x_max'"):
        livermark.problem("beam", folder / "gone.toml")


def test_exports_name_the_wound(folder):
    subprocess.run([BINARY, "export", "beam", folder / "cuts.toml", "-o", folder / "exports"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    problem = livermark.problem("beam", folder / "cuts.toml")
    in_wound = problem.boundary_patch == problem.patch_names.index("wound")
    abaqus = (folder / "exports" / "beam" / "cuts.inp").read_text()
    surface = re.search(r"\*\* wound\n\*SURFACE, NAME=PATCH_\d+, TYPE=ELEMENT\n((?:\d+, S[1-4]\n)+)", abaqus)
    assert surface and surface[1].count("\n") == in_wound.sum()
    vtu = (folder / "exports" / "beam" / "cuts.vtu").read_text()
    assert 'Name="wound"' in vtu
    livermark.to_febio(problem, folder / "cuts.feb")
    febio = (folder / "cuts.feb").read_text()
    inside = re.search(r'<Surface name="wound">(.*?)</Surface>', febio, re.DOTALL)
    assert inside and inside[1].count("<tri3") == in_wound.sum()


def test_wound_is_marked_for_vtk(folder):
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    problem = livermark.problem("beam", folder / "cuts.toml")
    marks = numpy_support.vtk_to_numpy(livermark.to_vtk(problem).GetPointData().GetArray("wound"))
    nodes = numpy.unique(problem.boundary_triangles[problem.boundary_patch == problem.patch_names.index("wound")])
    assert numpy.array_equal(numpy.flatnonzero(marks), nodes)


@pytest.mark.parametrize("arguments, sentence", [
    ({}, "give one of them"), ({"region": "tumour_1"}, "no region"), ({"half_space": [1.0, 2.0]}, "three numbers of each"),
    ({"half_space": "up"}, "no numbers"), ({"half_space": PLANE, "way": "fast"}, "facets or exact"),
    ({"half_space": [[5.0, 0.0, 0.0], [1.0, 0.0, 0.0]]}, "does not touch"),
    ({"half_space": PLANE, "small_pieces": "eat"}, "refuse, remove or keep")])
def test_wrong_cuts_are_input_errors(arguments, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        livermark.cut("beam", **arguments)
