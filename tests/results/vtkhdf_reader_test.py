"""vtkhdf_reader_test.py <moving.h5> <still.h5> <path.h5>: VTK sees in the files what h5py sees, and steps are as VTKHDF 2.0 says.

VTK reads steps in time from version 9.3 on. Older ones see the first, and warn of the version and of nothing else.
"""

import sys

import h5py
import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow, vtkVersion
from vtkmodules.vtkIOHDF import vtkHDFReader

VTK_TETRA = 10
MOTION, PATH, NOTHING = "history/frames", "path/displacement", ""
READS_STEPS = (vtkVersion.GetVTKMajorVersion(), vtkVersion.GetVTKMinorVersion()) >= (9, 3)


def open_with_vtk(path):
    """Returns the reader and where it says what it has to say."""
    window = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(window)
    reader = vtkHDFReader()
    assert reader.CanReadFile(path), f"VTK cannot read {path}"
    reader.SetFileName(path)
    reader.Update()
    return reader, window


def arrays(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


def fields_of(file, frames_in):
    """{name: dataset} of the arrays at the points: frames where there are some, else the static field."""

    def dataset(group, still, frames):
        return group[frames] if frames and frames in group else group[still]

    fields = {f"displacement_{model}": dataset(group, "displacement", frames_in)
              for model, group in file["/solutions"].items()}
    return fields | {f"error_{model}": dataset(group, "error", "error_frames" if frames_in == MOTION else "")
                     for model, group in file["/comparisons"].items() if "error" in group}


def read_step(group, step):
    """(time, points, cells, point arrays, cell arrays) of one step, by the offsets that VTKHDF 2.0 asks for."""
    steps = group["Steps"]
    assert steps["NumberOfParts"][step] == 1
    part = steps["PartOffsets"][step]
    num_points, num_cells, num_ids = (group[f"NumberOf{what}"][part] for what in ("Points", "Cells", "ConnectivityIds"))
    first_point = steps["PointOffsets"][step]
    (first_cell,), (first_id,) = steps["CellOffsets"][step], steps["ConnectivityIdOffsets"][step]
    ids = group["Connectivity"][first_id:first_id + num_ids]
    ends = group["Offsets"][first_cell:first_cell + num_cells + 1]

    def fields(where, count):
        return {name: array[steps[where + "Offsets"][name][step]:][:count] for name, array in group[where].items()}

    return (steps["Values"][step], group["Points"][first_point:first_point + num_points],
            [ids[a:b] for a, b in zip(ends, ends[1:])], fields("PointData", num_points), fields("CellData", num_cells))


def check_steps(file):
    group = file["/VTKHDF"]
    release = file["/load_case/release"].attrs
    num_frames = group["Steps"].attrs["NSteps"]
    assert list(group.attrs["Version"]) == [2, 0]
    assert 2 < num_frames <= 51 and (num_frames - 1) * release["records_per_frame"] <= release["num_steps"]
    for name in ("Values", "NumberOfParts", "PartOffsets", "PointOffsets"):
        assert group["Steps"][name].shape == (num_frames,), name
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        assert group["Steps"][name].shape == (num_frames, 1), name

    time = file["/solutions/fem_p2/history/time"][::release["records_per_frame"]]
    seen = []
    for step in range(num_frames):
        value, points, cells, point_arrays, cell_arrays = read_step(group, step)
        assert value == time[step]
        np.testing.assert_array_equal(points, file["/mesh/points"])
        np.testing.assert_array_equal(cells, file["/mesh/tetrahedra"])
        np.testing.assert_array_equal(cell_arrays["region"], file["/mesh/region"])
        assert {array.shape for array in point_arrays.values()} == {points.shape}
        u, r = point_arrays["displacement_springs"], point_arrays["displacement_fem_p2"]
        np.testing.assert_array_equal(point_arrays["error_springs"], u - r)
        np.testing.assert_array_equal(point_arrays["displacement_unfinished"],
                                      file["/solutions/unfinished/displacement"])
        seen.append(u.tobytes())
    assert len(set(seen)) == num_frames, "two frames are the same"


def check_path(file):
    group = file["/VTKHDF"]
    assert list(group.attrs["Version"]) == [2, 0]
    np.testing.assert_array_equal(group["Steps"]["Values"], file["/load_case/path"])
    for step in range(group["Steps"].attrs["NSteps"]):
        _, points, _, point_arrays, _ = read_step(group, step)
        frames = file["/solutions/springs/path/displacement"]
        np.testing.assert_array_equal(point_arrays["displacement_springs"], frames[step * len(points):][:len(points)])
        np.testing.assert_array_equal(point_arrays["error_springs"], file["/comparisons/springs/error"])


def check(path, frames_in):
    has_steps = frames_in != NOTHING
    reader, window = open_with_vtk(path)
    grid, said = reader.GetOutput(), window.GetOutput()
    if has_steps and not READS_STEPS:
        assert said.count("Warning") == 1 and "File version: 2.0 is higher than" in said, said
    else:
        assert said == "", said
    assert grid.GetClassName() == "vtkUnstructuredGrid", grid.GetClassName()
    point_arrays = arrays(grid.GetPointData())
    cell_arrays = arrays(grid.GetCellData())

    with h5py.File(path) as file:
        assert file["/mesh/tetrahedra"].compression == "gzip", "the sample is too small to test compressed datasets"
        num_nodes = len(file["/mesh/points"])
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), file["/mesh/points"])
        cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
        np.testing.assert_array_equal(cells, file["/mesh/tetrahedra"])
        assert {grid.GetCellType(i) for i in range(grid.GetNumberOfCells())} == {VTK_TETRA}

        expected = fields_of(file, frames_in)
        assert set(point_arrays) == set(expected), set(point_arrays) ^ set(expected)
        assert {"displacement_fem_p2", "displacement_springs", "error_springs"} <= set(expected)
        for name, dataset in expected.items():
            np.testing.assert_array_equal(point_arrays[name], dataset[:num_nodes], err_msg=name)
            assert file[f"/VTKHDF/PointData/{name}"] == dataset, f"{name} is a copy, not a link"
        assert set(cell_arrays) == {"region"}, set(cell_arrays)
        np.testing.assert_array_equal(cell_arrays["region"], file["/mesh/region"])
        if frames_in == MOTION:
            check_steps(file)
        if frames_in == PATH:
            check_path(file)
        if has_steps and READS_STEPS:
            last = file["/VTKHDF/Steps/Values"][-1]
            reader.UpdateTimeStep(last)
            np.testing.assert_array_equal(arrays(reader.GetOutput().GetPointData())["displacement_springs"],
                                          expected["displacement_springs"][-num_nodes:])

        # What else Python users rely on.
        assert list(file["/mesh/region"].attrs["names"]) == [b"parenchyma", b"tumour"]
        assert file["/mesh/points"].attrs["units"] == b"m"
        assert file.attrs["schema_version"] == 1


if __name__ == "__main__":
    check(sys.argv[1], MOTION)
    check(sys.argv[2], NOTHING)
    check(sys.argv[3], PATH)
