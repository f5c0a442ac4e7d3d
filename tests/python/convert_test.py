"""Meshes come in as they are, and scenes of SOFA have the numbers of the springs. SOFA itself does not run here."""
import os
import re
import subprocess
import sys

import livermark
import numpy
import pytest

meshio = pytest.importorskip("meshio")


class Node:
    """Records what a scene adds, in place of a node of SOFA."""

    def __init__(self):
        self.objects, self.children = {}, {}

    def addObject(self, kind, **data):
        self.objects[kind] = data

    def addChild(self, name):
        return self.children.setdefault(name, Node())


def run_scene(path):
    scope = {}
    exec(compile(path.read_text(), str(path), "exec"), scope)
    root = Node()
    scope["createScene"](root)
    return root


def test_mesh_of_meshio_is_the_mesh(bar):
    points, tetrahedra = bar
    moved = numpy.vstack([[[9.0, 9.0, 9.0]], 1000.0 * points])  # mm, and a node that nobody uses
    cells = [("triangle", [[0, 1, 2]]), ("tetra", tetrahedra[:4] + 1), ("tetra", tetrahedra[4:][:, [1, 0, 2, 3]] + 1)]
    given = meshio.Mesh(moved, cells, cell_data={"gmsh:physical": [[7], [1, 1, 1, 2], [2, 2]]})
    mesh = livermark.from_meshio(given, metres_per_unit=0.001)
    assert mesh.points == pytest.approx(points, rel=1e-15)
    assert [sorted(t) for t in mesh.tetrahedra.tolist()] == [sorted(t) for t in tetrahedra.tolist()]
    assert mesh.region.tolist() == [1, 1, 1, 2, 2, 2]
    assert numpy.array_equal(livermark.springs(mesh.points, mesh.tetrahedra, 5000.0, 0.45).edges,
                             livermark.springs(points, tetrahedra, 5000.0, 0.45).edges)


def test_mesh_file_is_read(bar, tmp_path):
    points, tetrahedra = bar
    meshio.Mesh(points, [("tetra", tetrahedra)]).write(tmp_path / "bar.vtu")
    mesh = livermark.from_meshio(tmp_path / "bar.vtu")
    assert numpy.array_equal(mesh.points, points) and numpy.array_equal(mesh.tetrahedra, tetrahedra)
    assert mesh.region.tolist() == [0] * 6


def test_a_file_is_read_as_its_mesh_is(bar, tmp_path):
    points, tetrahedra = bar
    given = meshio.Mesh(points, [("triangle", [[0, 1, 3]]), ("tetra", tetrahedra)], cell_data={
        "gmsh:physical": [numpy.array([9]), numpy.array([1, 1, 2, 2, 2, 1])], "gmsh:geometrical": [numpy.array([1]), numpy.ones(6, int)]},
        field_data={"liver": numpy.array([1, 3]), "tumour": numpy.array([2, 3])})
    given.write(tmp_path / "bar.msh", file_format="gmsh22", binary=False)
    of_file, of_mesh = livermark.from_meshio(tmp_path / "bar.msh"), livermark.from_meshio(given)
    for one, other in zip(of_file, of_mesh):
        assert numpy.array_equal(one, other) and one.dtype == other.dtype
    assert of_file.region_names == of_mesh.region_names == {1: "liver", 2: "tumour"}


def test_warnings_of_a_file_are_those_of_its_mesh(bar, tmp_path):
    points, tetrahedra = bar
    given = meshio.Mesh(20000.0 * points, [("tetra", tetrahedra)], cell_data={"quality": [numpy.linspace(0.1, 0.9, 6)]})
    given.write(tmp_path / "bar.vtu")
    sentences = []
    for mesh in (given, tmp_path / "bar.vtu"):
        with pytest.warns(UserWarning) as told:
            livermark.from_meshio(mesh)
        sentences.append([str(warning.message) for warning in told])
        assert {warning.filename for warning in told} == {__file__}
    assert sentences[0] == sentences[1] and len(sentences[0]) == 2


@pytest.mark.parametrize("name, content, sentence", [
    ("a.vtk", b"# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 100000000000 double\n0 0 0\n",
     "the file ends too early"),
    ("a.vtk", b"nothing", "no mesh can be read from it as VTK, so it is damaged or of another format"),
    ("a.msh", b"$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0 0", "no mesh can be read from it as MSH"),
    ("a.stl", b"solid x\nendsolid x\n", "there are no tetrahedra; mesh the volume, not only the surface"),
    ("a", b"", "its name has no ending that says its format"),
    ("a.nii", b"\0" * 400, "no mesh can be read from it as NII")])
def test_files_that_are_no_mesh_are_refused_with_a_sentence_of_ours(tmp_path, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(livermark.InputError, match="^" + re.escape(f"{tmp_path / name}: {sentence}")) as refused:
        livermark.from_meshio(tmp_path / name)
    assert "\n" not in str(refused.value) and "meshio" not in str(refused.value)


def test_what_is_no_plain_file_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "pipe.vtk")
    for path in (tmp_path / "pipe.vtk", tmp_path, "/dev/zero"):
        with pytest.raises(livermark.InputError, match="this is not a plain file"):
            livermark.from_meshio(path)
        with pytest.raises(livermark.InputError, match="this is not a plain file"):
            livermark.from_febio(path)
    with pytest.raises(FileNotFoundError):
        livermark.from_meshio(tmp_path / "nowhere.vtk")


@pytest.mark.parametrize("reader, why", [
    ("os.abort()", "a library has broken off with Aborted"),
    ("[0] * 10**10", "it takes more memory than there is for a file"),
    ("exec('while True: pass')", r"it takes more than 1 s or \d+ MB")])
def test_a_reader_that_crashes_hangs_or_fills_the_memory_ends_alone(tmp_path, monkeypatch, reader, why):
    (tmp_path / "meshio").mkdir()
    (tmp_path / "meshio" / "__init__.py").write_text(
        f"import os\nextension_to_filetypes = {{'.mesh': ['medit']}}\ndef read(path):\n    {reader}\n")
    (tmp_path / "sitecustomize.py").write_text("import resource\nresource.setrlimit(resource.RLIMIT_CPU, (2, 2))\n")
    (tmp_path / "a.mesh").write_text("x")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr("livermark.convert.mesh_files.limits_of", lambda path: (1, 1 << 30))
    monkeypatch.setenv("PYTHONPATH", str(tmp_path), prepend=os.pathsep)
    with pytest.raises(livermark.InputError, match=why):
        livermark.from_meshio(tmp_path / "a.mesh")


def test_nothing_of_the_working_directory_runs_when_a_file_is_read(bar, tmp_path):
    meshio.Mesh(bar[0], [("tetra", bar[1])]).write(tmp_path / "bar.mesh")
    (tmp_path / "meshio.py").write_text("open('ran', 'w')\nraise SystemExit(0)\n")
    program = "import sys; sys.path.append(sys.path.pop(0)); import livermark; livermark.from_meshio('bar.mesh')"
    subprocess.run([sys.executable, "-c", program], check=True, cwd=tmp_path)
    assert not (tmp_path / "ran").exists()


def broken_meshes():
    """Name of each fault, and what of a mesh of one tetrahedron is replaced."""
    points = numpy.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    yield "its points have no three coordinates", {"points": points[:, :2]}
    yield "a coordinate is not finite", {"points": points * numpy.nan}
    for node in (4, -1):
        yield "a tetrahedron names a node that is not there", {"cells": [("tetra", numpy.array([[0, 1, 2, node]]))]}
    yield "the node numbers of its tetrahedra are no integers", {"cells": [("tetra", numpy.array([[0, 1, 2, 3.0]]))]}
    yield "its tetrahedra have no four corners", {"cells": [("tetra", numpy.array([[0, 1, 2]]))]}
    yield "its points, cells and groups do not go together", {"cell_sets": {"a": [numpy.array([7])]}}
    yield "its points, cells and groups do not go together", {"field_data": {"a": 3}}
    yield "its groups are of another number of tetrahedra", {"cell_data": {"gmsh:physical": [numpy.array([1, 2])]}}


@pytest.mark.parametrize("sentence, change", broken_meshes())
def test_a_mesh_that_is_broken_is_refused_with_a_sentence(sentence, change):
    points = numpy.array([[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]])
    mesh = meshio.Mesh(change.pop("points", points), change.pop("cells", [("tetra", numpy.array([[0, 1, 2, 3]]))]))
    for name, value in change.items():
        setattr(mesh, name, value)
    with pytest.raises(livermark.InputError, match="^mesh: " + sentence):
        livermark.from_meshio(mesh)


@pytest.mark.parametrize("wrong", [None, 3, [1, 2]])
def test_what_is_no_mesh_is_refused(wrong):
    with pytest.raises(livermark.InputError, match="^mesh: this is no meshio.Mesh, and no path of a file"):
        livermark.from_meshio(wrong)


@pytest.mark.parametrize("unit", [0, -1.0, float("nan"), float("inf"), "mm", None])
def test_a_unit_that_is_no_length_is_refused(bar, unit):
    with pytest.raises(livermark.InputError, match="^metres_per_unit: .*; it has to be a positive number"):
        livermark.from_meshio(meshio.Mesh(bar[0], [("tetra", bar[1])]), unit)


def test_a_mesh_of_a_surface_is_refused(bar):
    with pytest.raises(livermark.InputError, match="^mesh: there are no tetrahedra; mesh the volume"):
        livermark.from_meshio(meshio.Mesh(bar[0], [("triangle", [[0, 1, 2]])]))


def test_whole_numbers_of_cells_under_any_name_are_groups(bar):
    points, tetrahedra = bar
    numbers = numpy.array([[3], [3], [3], [5], [5], [5]])
    given = meshio.Mesh(points, [("tetra", tetrahedra)], cell_data={"quality": [numpy.linspace(0.1, 0.9, 6)],
                                                                    "compartment": [numbers]})
    with pytest.warns(UserWarning) as told:
        mesh = livermark.from_meshio(given)
    assert mesh.region.tolist() == [3, 3, 3, 5, 5, 5] and mesh.region_names == {}
    sentences = " ".join(str(warning.message) for warning in told)
    assert "are the numbers 'compartment'" in sentences and "not used: quality" in sentences
    given = meshio.Mesh(points, [("tetra", tetrahedra)], cell_data={"MaterialIds": [numbers]})
    assert livermark.from_meshio(given).region.tolist() == [3, 3, 3, 5, 5, 5]


def test_of_sets_that_overlap_the_smaller_one_counts(bar):
    points, tetrahedra = bar
    given = meshio.Mesh(points, [("tetra", tetrahedra)],
                        cell_sets={"ALL": [numpy.arange(6)], "TUMOUR": [numpy.array([1, 4])]})
    with pytest.warns(UserWarning, match="share 2 tetrahedra, which count as 'TUMOUR'"):
        mesh = livermark.from_meshio(given)
    points_, tetrahedra_, region = mesh
    assert [mesh.region_names[number] for number in region.tolist()] == ["ALL", "TUMOUR", "ALL", "ALL", "TUMOUR", "ALL"]


def test_cells_that_are_no_tetrahedra_are_refused(bar):
    points, tetrahedra = bar
    given = meshio.Mesh(points, [("tetra", tetrahedra[:1]), ("hexahedron", numpy.arange(8)[None])])
    with pytest.raises(livermark.InputError, match="1 of type hexahedron"):
        livermark.from_meshio(given)


def test_a_mesh_in_millimetres_is_doubted(bar):
    points, tetrahedra = bar
    given = meshio.Mesh(20000.0 * points, [("tetra", tetrahedra)])
    with pytest.warns(UserWarning, match="200 m, which fits no organ"):
        livermark.from_meshio(given)
    with pytest.warns(UserWarning, match="200 m, which fits no organ"):
        livermark.springs(20000.0 * points, tetrahedra, 5000.0, 0.45)


@pytest.mark.parametrize("factor, doubt", [(0.01, "the longest side is 0.0001 m"), (150.0, "the box around it holds 3375 L")])
def test_a_size_that_no_body_has_is_doubted(bar, factor, doubt):
    points, tetrahedra = bar  # of 10 mm
    with pytest.warns(UserWarning, match=f"^points: {doubt}, which fits no organ"):
        livermark.springs(factor * points, tetrahedra, 5000.0, 0.45)
    with pytest.warns(UserWarning, match=f"^mesh: {doubt}, which fits no organ; give metres_per_unit"):
        livermark.from_meshio(meshio.Mesh(factor * points, [("tetra", tetrahedra)]))


def test_parts_that_hang_on_an_edge_or_a_node_are_refused():
    points = [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1], [0, -0.1, 0], [0, 0, -0.1]]
    with pytest.raises(livermark.InputError, match="numbers 0 and 1 are in parts that are not joined by faces"):
        livermark.springs(points, [[0, 1, 2, 3], [0, 4, 5, 1]], 5000.0, 0.45)


def test_scene_of_sofa_has_the_numbers_of_the_springs(bar, tmp_path):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    forces = numpy.arange(24.0).reshape(8, 3)
    livermark.to_sofa(springs, tmp_path / "scene.py", 0.001, fixed=numpy.arange(8) < 4, forces=forces,
                      damping=livermark.RayleighDamping(0.5, 0.002))
    root = run_scene(tmp_path / "scene.py")
    body = root.children["livermark"].objects
    words = body["SpringForceField"]["spring"].split()
    rows = numpy.array(words, dtype=float).reshape(-1, 5)
    assert numpy.array_equal(rows[:, :2], springs.edges)
    assert numpy.array_equal(rows[:, 2], springs.stiffness)
    assert numpy.array_equal(rows[:, 3], 0.002 * springs.stiffness)
    assert numpy.array_equal(rows[:, 4], springs.rest_length)
    assert numpy.array_equal(body["MechanicalObject"]["position"], springs.points)
    assert numpy.array_equal(body["DiagonalMass"]["vertexMass"], springs.node_mass)
    assert numpy.array_equal(body["EdgeSetTopologyContainer"]["edges"], springs.edges)
    assert body["FixedProjectiveConstraint"]["indices"] == [0, 1, 2, 3]
    assert numpy.array_equal(body["ConstantForceField"]["forces"], forces)
    assert root.dt == 0.001 and body["EulerImplicitSolver"]["rayleighMass"] == 0.5


def test_scene_without_forces_adds_none(bar, tmp_path):
    livermark.to_sofa(livermark.springs(*bar, 5000.0, 0.45), tmp_path / "scene.py", 0.01)
    body = run_scene(tmp_path / "scene.py").children["livermark"].objects
    assert "FixedProjectiveConstraint" not in body and "ConstantForceField" not in body


@pytest.mark.parametrize("change, sentence", [
    ({"fixed": [8]}, "fixed: nodes are numbered from 0 to 7"),
    ({"fixed": numpy.ones((8, 3), bool)}, r"fixed: the shape is \(8, 3\); SOFA fixes whole nodes"),
    ({"forces": numpy.zeros((7, 3))}, r"forces: the shape is \(7, 3\); give one of shape \(8, 3\)")])
def test_what_sofa_cannot_do_is_refused(bar, tmp_path, change, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.to_sofa(livermark.springs(*bar, 5000.0, 0.45), tmp_path / "scene.py", 0.01, **change)
    with pytest.raises(livermark.InputError, match="^springs: coupled springs are not edges"):
        livermark.to_sofa(livermark.coupled_springs(*bar, 5000.0, 0.45), tmp_path / "scene.py", 0.01)
