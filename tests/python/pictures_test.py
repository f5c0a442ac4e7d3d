"""Grids of VTK and files for 3D Slicer have the numbers of what they were made of. Slicer and pyvista do not run here."""
import os
import pathlib
from types import SimpleNamespace

import livermark
import numpy
import pytest
from conftest import RUNS

SAMPLES = pathlib.Path(os.environ["LIVERMARK_SAMPLES"])
numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")


def of_points(grid, name):
    return numpy_support.vtk_to_numpy(grid.GetPointData().GetArray(name))


def of_cells(grid, name):
    return numpy_support.vtk_to_numpy(grid.GetCellData().GetArray(name))


def points(grid):
    return numpy_support.vtk_to_numpy(grid.GetPoints().GetData())


def cells(grid, nodes_each):
    assert set(numpy.diff(numpy_support.vtk_to_numpy(grid.GetCells().GetOffsetsArray()))) == {nodes_each}
    return numpy_support.vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, nodes_each)


def read_as_slicer_does(path):
    """The grid, and the header in which Slicer looks for the coordinate system."""
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader
    reader = vtkUnstructuredGridReader()
    reader.SetFileName(os.fspath(path))
    assert reader.IsFileUnstructuredGrid()
    reader.ReadAllFieldsOn()
    reader.Update()
    return reader.GetOutput(), reader.GetHeader()


@pytest.fixture(scope="module")
def bent():
    return livermark.problem("beam", "beam_bend")


def test_grid_of_a_problem_has_its_arrays(bent):
    grid = livermark.to_vtk(bent)
    assert numpy.array_equal(points(grid), bent.points) and numpy.array_equal(cells(grid, 4), bent.tetrahedra)
    assert grid.GetCellType(0) == 10
    for name in ("region", "young_modulus", "poisson_ratio", "density"):
        assert numpy.array_equal(of_cells(grid, name), getattr(bent, name)), name
    for name in ("prescribed_displacement", "forces", "dead_forces"):
        assert numpy.array_equal(of_points(grid, name), getattr(bent, name), equal_nan=True), name


def test_grid_of_a_mesh_and_of_a_solid_have_what_they_have(bar):
    mesh = livermark.Mesh(*bar, numpy.arange(6))
    assert of_cells(livermark.to_vtk(mesh), "region").tolist() == list(range(6))
    grid = livermark.to_vtk(livermark.Solid(*bar, 1e3, 0.45))
    assert of_cells(grid, "young_modulus").tolist() == [1e3] * 6 and not grid.GetPointData().HasArray("dead_forces")


def test_grid_of_springs_has_their_stiffness(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    grid = livermark.to_vtk(springs)
    assert numpy.array_equal(cells(grid, 2), springs.edges) and grid.GetCellType(0) == 3
    for name in ("stiffness", "rest_length"):
        assert numpy.array_equal(of_cells(grid, name), getattr(springs, name)), name
    assert numpy.array_equal(of_points(grid, "node_mass"), springs.node_mass)
    with pytest.raises(livermark.InputError, match="^springs: coupled springs are not edges"):
        livermark.to_vtk(livermark.coupled_springs(*bar, 5000.0, 0.45))


def lines(poly):
    """Points of each line."""
    cells = poly.GetLines()
    ends = numpy_support.vtk_to_numpy(cells.GetOffsetsArray())
    return [part.tolist() for part in numpy.split(numpy_support.vtk_to_numpy(cells.GetConnectivityArray()), ends[1:-1])]


def test_vessels_are_lines_that_move_with_the_body():
    with livermark.open(SAMPLES / "with_jaws_result.h5") as result:
        gradient = numpy.array([[0.1, 0.02, 0.0], [-0.03, 0.05, 0.01], [0.0, 0.2, -0.1]])
        rest, moved = livermark.vessels_to_vtk(result), livermark.vessels_to_vtk(result, moved_by=result.points @ gradient.T)
        places, radius = result.vessels["points"], result.vessels["radius"]
        assert lines(rest) == [list(range(16))] and numpy.array_equal(points(rest), places)
        assert numpy.array_equal(of_points(rest, "radius"), radius) and not of_points(rest, "displacement").any()
        assert of_points(moved, "displacement") == pytest.approx(places @ gradient.T, rel=1e-10)
        assert points(moved) == pytest.approx(places + places @ gradient.T, rel=1e-10)
        by_name, by_array = (livermark.vessels_to_vtk(result, moved_by=by) for by in ("springs", result["springs"].displacement))
        assert numpy.array_equal(points(by_name), points(by_array)) and of_points(by_name, "displacement").any()
        foundation = of_points(result.to_vtk(), "foundation")
        on_springs = numpy.unique(result.boundary_triangles[result.foundation["facet"]])
        assert numpy.array_equal(numpy.flatnonzero(foundation), on_springs) and set(foundation[on_springs]) == {1e6 / 7.0}
        with pytest.raises(livermark.InputError, match=r"^moved_by: the shape is \(7, 3\)"):
            livermark.vessels_to_vtk(result, moved_by=numpy.zeros((7, 3)))
    with livermark.open(RUNS / "beam" / "beam_bend.h5") as result:
        with pytest.raises(livermark.InputError, match="the body has no vessels as lines"):
            livermark.vessels_to_vtk(result)


def test_lines_of_vessels_end_where_others_join_and_have_every_segment_once(bar):
    cube, tetrahedra = bar
    places = 0.001 * numpy.arange(30.0).reshape(10, 3)  # a fork, a line apart and a ring
    segments = numpy.array([[0, 1], [2, 1], [1, 3], [3, 4], [5, 6], [7, 8], [8, 9], [9, 7]])
    vessels = {"points": places, "radius": numpy.ones(10), "segments": segments}
    poly = livermark.vessels_to_vtk(SimpleNamespace(points=cube, tetrahedra=tetrahedra, vessels=vessels))
    found = lines(poly)
    assert sorted(map(tuple, numpy.sort([pair for line in found for pair in zip(line, line[1:])]).tolist())) == sorted(
        map(tuple, numpy.sort(segments).tolist()))
    assert len(found) == 5 and [1, 3, 4] in found + [line[::-1] for line in found]


def test_pyvista_wraps_the_grid_or_is_asked_for(bar):
    mesh = livermark.Mesh(*bar, numpy.zeros(6, int))
    try:
        import pyvista  # noqa: F401
    except ImportError:
        with pytest.raises(ImportError, match="^this needs pyvista; install pyvista from PyPI, which Debian 12"):
            livermark.to_pyvista(mesh)
    else:
        assert numpy.array_equal(livermark.to_pyvista(mesh).points, mesh.points)


def test_file_for_slicer_is_in_millimetres_and_lps(tmp_path):
    with livermark.open(RUNS / "beam" / "beam_bend.h5") as result:
        livermark.to_slicer(result, tmp_path / "rest.vtk")
        livermark.to_slicer(result, tmp_path / "moved.vtk", moved_by="lloyd")
        displacement, error, rest = result["lloyd"].displacement, result["lloyd"].error, result.points
        tetrahedra, region = result.tetrahedra, result.region
    grid, header = read_as_slicer_does(tmp_path / "rest.vtk")
    assert "SPACE=LPS" in header
    assert points(grid) == pytest.approx(1000.0 * rest, rel=1e-15)
    assert numpy.array_equal(cells(grid, 4), tetrahedra) and numpy.array_equal(of_cells(grid, "region"), region)
    assert of_points(grid, "displacement_lloyd") == pytest.approx(1000.0 * displacement, rel=1e-15)
    assert of_points(grid, "error_lloyd") == pytest.approx(1000.0 * error, rel=1e-15)
    assert of_points(grid, "error_lloyd_magnitude").max() == pytest.approx(1000.0 * numpy.linalg.norm(error, axis=1).max())
    moved, _ = read_as_slicer_does(tmp_path / "moved.vtk")
    assert points(moved) == pytest.approx(1000.0 * (rest + displacement), rel=1e-12)


def test_file_for_slicer_moves_by_own_displacements(bent, tmp_path):
    mine = numpy.full_like(bent.points, 0.001)
    livermark.to_slicer(bent, tmp_path / "mine.vtk", moved_by=mine)
    grid, _ = read_as_slicer_does(tmp_path / "mine.vtk")
    assert points(grid) == pytest.approx(1000.0 * bent.points + 1.0, rel=1e-12)
    assert of_points(grid, "displacement") == pytest.approx(1.0)
    assert numpy.array_equal(of_points(grid, "forces"), bent.forces)  # [N]
    assert numpy.array_equal(numpy.isnan(of_points(grid, "prescribed_displacement")), ~bent.fixed)


@pytest.mark.parametrize("name, change, sentence", [
    ("a.vtu", {}, ".*: give a file that ends in .vtk"),
    ("a.vtk", {"moved_by": numpy.zeros((7, 3))}, r"moved_by: the shape is \(7, 3\); give one of shape \(1142, 3\)"),
    ("a.vtk", {"moved_by": "lloyd"}, "moved_by: there is no displacement of a model 'lloyd'")])
def test_what_slicer_cannot_load_is_refused(bent, tmp_path, name, change, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.to_slicer(bent, tmp_path / name, **change)


def test_springs_are_no_model_for_slicer(bar, tmp_path):
    with pytest.raises(livermark.InputError, match="^body: Slicer needs tetrahedra"):
        livermark.to_slicer(livermark.springs(*bar, 5000.0, 0.45), tmp_path / "a.vtk")
