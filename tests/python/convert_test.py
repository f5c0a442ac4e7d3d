"""Meshes come in as they are, and scenes of SOFA have the numbers of the springs. SOFA itself does not run here."""
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
    with pytest.warns(UserWarning, match="200 m, which is no organ"):
        livermark.from_meshio(given)
    with pytest.warns(UserWarning, match="200 m, which is no organ"):
        livermark.springs(20000.0 * points, tetrahedra, 5000.0, 0.45)


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
