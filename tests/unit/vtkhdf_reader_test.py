"""vtkhdf_reader_test.py <result.h5>: VTK reads the file without a word, and sees in it what h5py sees."""

import sys

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow
from vtkmodules.vtkIOHDF import vtkHDFReader

VTK_TETRA = 10


def read_with_vtk(path):
    """Returns the grid and all that VTK had to say."""
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    reader = vtkHDFReader()
    assert reader.CanReadFile(path), f"VTK cannot read {path}"
    reader.SetFileName(path)
    reader.Update()
    return reader.GetOutput(), window.GetOutput()


def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def main(path):
    grid, said = read_with_vtk(path)
    assert said == "", said
    assert grid.GetClassName() == "vtkUnstructuredGrid", grid.GetClassName()
    point_arrays = arrays(grid.GetPointData())
    cell_arrays = arrays(grid.GetCellData())

    with h5py.File(path) as file:
        assert file["/mesh/tetrahedra"].compression == "gzip", "the sample is too small to test compressed datasets"
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), file["/mesh/points"])
        cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        np.testing.assert_array_equal(cells, file["/mesh/tetrahedra"])
        assert {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())} == {VTK_TETRA}

        expected = {f"displacement_{model}": group["displacement"] for model, group in file["/solutions"].items()}
        expected |= {f"error_{model}": group["error"] for model, group in file["/comparisons"].items()
                     if "error" in group}
        assert set(point_arrays) == set(expected), set(point_arrays) ^ set(expected)
        assert {"displacement_fem_p2", "displacement_springs", "error_springs"} <= set(expected)
        for name, dataset in expected.items():
            np.testing.assert_array_equal(point_arrays[name], dataset, err_msg=name)
            assert file[f"/VTKHDF/PointData/{name}"] == dataset, f"{name} is a copy, not a link"
        assert set(cell_arrays) == {"region"}, set(cell_arrays)
        np.testing.assert_array_equal(cell_arrays["region"], file["/mesh/region"])

        # What else Python users rely on.
        assert list(file["/mesh/region"].attrs["names"]) == [b"parenchyma", b"tumour"]
        assert file["/mesh/points"].attrs["units"] == b"m"
        assert file.attrs["schema_version"] == 1


if __name__ == "__main__":
    main(sys.argv[1])
