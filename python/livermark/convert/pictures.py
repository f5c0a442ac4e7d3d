"""Bodies, problems, springs, vessels and result files as grids of VTK and of pyvista, and as files of 3D Slicer and SlicerSOFA."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Union

import numpy

from livermark.errors import InputError
from livermark.vessels import Vessels

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from livermark.results import ResultFile

LINE, TETRAHEDRON = 3, 10  # VTK_LINE, VTK_TETRA
WOUND = "wound"  #: the patch that a cut makes
MILLIMETRES = 1000.0  # in a metre
LENGTHS = ("displacement", "prescribed_displacement", "error")


def named(name: str, values: Any):
    """A vtkDataArray with its own memory."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    array = numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
    array.SetName(name)
    return array


def grid_of(points, cells, kind: int, of_cells: dict, of_points: dict):
    """A vtkUnstructuredGrid of cells of one kind, with named values."""
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
    except ImportError as error:
        raise ImportError("this needs VTK; install python3-vtk9") from error
    nodes = numpy.asarray(cells, dtype=numpy.int64)
    array = vtkCellArray()
    array.SetData(numpy_to_vtkIdTypeArray(numpy.arange(0, nodes.size + 1, nodes.shape[1]), deep=True),
                  numpy_to_vtkIdTypeArray(nodes.ravel(), deep=True))
    place = vtkPoints()
    place.SetData(numpy_to_vtk(numpy.ascontiguousarray(points, dtype=float), deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(place)
    grid.SetCells(kind, array)
    for name, values in of_cells.items():
        grid.GetCellData().AddArray(named(name, values))
    for name, values in of_points.items():
        grid.GetPointData().AddArray(named(name, values))
    return grid


def grid_of_result(result):
    """A vtkUnstructuredGrid of a livermark.results.ResultFile; static fields."""
    of_points = {}
    for name in result.models:
        model = result[name]
        of_points["displacement_" + name] = model.displacement
        if model.error is not None:
            of_points["error_" + name] = model.error
    if result.foundation is not None:
        of_points["foundation"] = numpy.zeros(len(result.points))
        corners = result.boundary_triangles[result.foundation["facet"]]
        numpy.maximum.at(of_points["foundation"], corners, result.foundation["stiffness"][:, None])
    return grid_of(result.points, result.tetrahedra, TETRAHEDRON, {"region": result.region}, of_points)


def _present(body: Any, names: tuple, count: int) -> dict:
    """What a body has of these, one value for each item."""
    values = {name: numpy.asarray(getattr(body, name)) for name in names if getattr(body, name, None) is not None}
    return {name: numpy.full(count, value) if value.ndim == 0 else value for name, value in values.items()}


def to_vtk(body: Any):
    """A vtkUnstructuredGrid of a Problem, Solid or Mesh, of Springs, or of a result file.

    Tetrahedra have region, young_modulus and poisson_ratio; nodes prescribed_displacement (NaN where free), forces and
    dead_forces, and wound, 1 on the surface of a cut: whatever the body has. Springs are lines with stiffness and
    rest_length, their nodes have node_mass. A result file has displacement_<model> and error_<model>. SI units. Raises
    InputError for springs that are no edges.
    """
    if hasattr(body, "to_vtk"):
        return body.to_vtk()
    if hasattr(body, "edges"):
        if len(body.edges) == 0:
            raise InputError("springs: coupled springs are not edges of their own; take springs()")
        return grid_of(body.points, body.edges, LINE, _present(body, ("stiffness", "rest_length"), len(body.edges)),
                       _present(body, ("node_mass",), len(body.points)))
    of_cells = _present(body, ("region", "young_modulus", "poisson_ratio", "density"), len(body.tetrahedra))
    of_points = _present(body, ("prescribed_displacement", "forces", "dead_forces"), len(body.points))
    if WOUND in getattr(body, "patch_names", ()):
        in_wound = numpy.asarray(body.boundary_patch) == list(body.patch_names).index(WOUND)
        of_points[WOUND] = numpy.zeros(len(body.points), int)
        of_points[WOUND][numpy.asarray(body.boundary_triangles)[in_wound].ravel()] = 1
    return grid_of(body.points, body.tetrahedra, TETRAHEDRON, of_cells, of_points)


def _chains(segments: NDArray, num_points: int) -> list[list[int]]:
    """Lines that have all segments: each goes on until it ends or others join."""
    neighbours: list[list[int]] = [[] for _ in range(num_points)]
    for a, b in segments.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    is_end = [len(others) != 2 for others in neighbours]
    left = {(min(pair), max(pair)) for pair in segments.tolist()}
    chains = []
    for start in sorted(range(num_points), key=lambda point: not is_end[point]):  # rings, which have no end, are last
        for following in neighbours[start]:
            if (min(start, following), max(start, following)) not in left:
                continue
            chain = [start]
            while True:
                left.discard((min(chain[-1], following), max(chain[-1], following)))
                chain.append(following)
                others = [p for p in neighbours[following] if (min(p, following), max(p, following)) in left]
                if is_end[following] or not others:
                    break
                following = others[0]
            chains.append(chain)
    return chains


def vessels_to_vtk(result: ResultFile, moved_by: Union[None, str, ArrayLike] = None):
    """A vtkPolyData of the vessels of a result file: lines, with radius [m] and displacement [m] of their points.

    moved_by: the name of a model, or displacements (N, 3) of the nodes [m]; the lines are where they then are. Raises InputError for
    a body without vessels as lines.
    """
    if result.vessels is None:
        raise InputError(f"{result.path}: the body has no vessels as lines; give one with [vessels]")
    places, radius = result.vessels["points"], result.vessels["radius"]
    displacement = numpy.zeros_like(places)
    if moved_by is not None:
        of_nodes = result[moved_by].displacement if isinstance(moved_by, str) else numpy.asarray(moved_by, dtype=float)
        if of_nodes.shape != result.points.shape:
            raise InputError(f"moved_by: the shape is {of_nodes.shape}; give one of shape {result.points.shape}")
        tree = Vessels(places, radius, result.vessels["segments"])
        displacement = tree.moved(result.points, result.tetrahedra, of_nodes).points - places
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
    except ImportError as error:
        raise ImportError("this needs VTK; install python3-vtk9") from error
    lines = vtkCellArray()
    for chain in _chains(result.vessels["segments"], len(places)):
        lines.InsertNextCell(len(chain), chain)
    place = vtkPoints()
    place.SetData(numpy_to_vtk(numpy.ascontiguousarray(places + displacement), deep=True))
    poly = vtkPolyData()
    poly.SetPoints(place)
    poly.SetLines(lines)
    poly.GetPointData().AddArray(named("radius", radius))
    poly.GetPointData().AddArray(named("displacement", displacement))
    return poly


def to_pyvista(body: Any):
    """The grid of to_vtk() as a pyvista.UnstructuredGrid."""
    try:
        import pyvista
    except ImportError as error:
        raise ImportError("this needs pyvista; install pyvista from PyPI, which Debian 12 does not have") from error
    return pyvista.wrap(to_vtk(body))


def _is_length(name: str) -> bool:
    return name in LENGTHS or name.startswith(("displacement_", "error_"))


def to_slicer(body: Any, path: Union[str, os.PathLike[str]], moved_by: Union[None, str, ArrayLike] = None) -> None:
    """Writes tetrahedra as a legacy VTK file in millimetres, with the word by which 3D Slicer knows that it is in LPS.

    body: a Problem, Solid, Mesh or result file. path: of a .vtk file. moved_by: the name of a model of the result file, or
    displacements (N, 3) [m], by which the nodes are moved. Displacements and errors are in mm and have an array
    <name>_magnitude beside them, for colours; all else is as in to_vtk(). Raises InputError.
    """
    if os.path.splitext(os.fspath(path))[1] != ".vtk":
        raise InputError(f"{os.fspath(path)}: give a file that ends in .vtk")
    if not hasattr(body, "tetrahedra"):
        raise InputError("body: Slicer needs tetrahedra; give a Problem, Solid, Mesh or result file")
    grid = to_vtk(body)
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridWriter
    values = grid.GetPointData()
    if moved_by is not None and not isinstance(moved_by, str):
        displacement = numpy.asarray(moved_by, dtype=float)
        if displacement.shape != (grid.GetNumberOfPoints(), 3):
            raise InputError(f"moved_by: the shape is {displacement.shape}; give one of shape ({grid.GetNumberOfPoints()}, 3)")
        values.AddArray(named("displacement", displacement))
    elif moved_by is not None and not values.HasArray("displacement_" + moved_by):
        raise InputError(f"moved_by: there is no displacement of a model '{moved_by}'")
    for name in [values.GetArrayName(k) for k in range(values.GetNumberOfArrays())]:
        if _is_length(name):
            lengths = vtk_to_numpy(values.GetArray(name))
            lengths *= MILLIMETRES
            values.AddArray(named(name + "_magnitude", numpy.linalg.norm(lengths, axis=1)))
    points = vtk_to_numpy(grid.GetPoints().GetData())
    points *= MILLIMETRES
    if moved_by is not None:
        points += vtk_to_numpy(values.GetArray("displacement_" + moved_by if isinstance(moved_by, str) else "displacement"))
    writer = vtkUnstructuredGridWriter()
    writer.SetFileName(os.fspath(path))
    writer.SetFileVersion(42)  # what versions of Slicer before VTK 9 read, and Slicer itself writes
    writer.SetFileTypeToBinary()  # text cannot have NaN
    writer.SetHeader("Livermark, millimetres. SPACE=LPS")
    writer.SetInputData(grid)
    if not writer.Write():
        raise OSError(f"{os.fspath(path)}: cannot be written")
