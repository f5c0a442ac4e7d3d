"""Files that 3D Slicer and its extension SlicerSOFA load as models."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, Union

import numpy

from livermark.errors import InputError
from livermark.pictures import named, to_vtk

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

MILLIMETRES = 1000.0  # in a metre
LENGTHS = ("displacement", "prescribed_displacement", "error")


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
