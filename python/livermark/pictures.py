"""Result files as grids of VTK."""
from __future__ import annotations

import numpy

TETRAHEDRON = 10  # VTK_TETRA


def grid_of(result):
    """A vtkUnstructuredGrid of a livermark.results.ResultFile; static fields."""
    try:
        from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
    except ImportError as error:
        raise ImportError("this needs VTK; install python3-vtk9") from error

    def named(name, values):
        array = numpy_to_vtk(numpy.ascontiguousarray(values), deep=True)
        array.SetName(name)
        return array

    tetrahedra = result.tetrahedra.astype(numpy.int64)
    cells = vtkCellArray()
    cells.SetData(numpy_to_vtkIdTypeArray(numpy.arange(0, tetrahedra.size + 1, 4), deep=True),
                  numpy_to_vtkIdTypeArray(tetrahedra.ravel(), deep=True))
    points = vtkPoints()
    points.SetData(numpy_to_vtk(result.points, deep=True))
    grid = vtkUnstructuredGrid()
    grid.SetPoints(points)
    grid.SetCells(TETRAHEDRON, cells)
    grid.GetCellData().AddArray(named("region", result.region))
    for name in result.models:
        model = result[name]
        grid.GetPointData().AddArray(named("displacement_" + name, model.displacement))
        if model.error is not None:
            grid.GetPointData().AddArray(named("error_" + name, model.error))
    return grid
