"""Meshes in VTK files as VTK itself, ParaView and Slicer write them: all types of numbers, versions, compressors and pieces."""
import itertools

import livermark
import numpy
import pytest
from livermark.convert import mesh_files

pytest.importorskip("meshio")

POINTS = numpy.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1], [0.1, 0.1, 0.1]], dtype=float)
TETRAHEDRA = numpy.array([[0, 1, 2, 3], [1, 4, 2, 3]])
ARRAYS = ("vtkIdTypeArray", "vtkLongArray", "vtkUnsignedCharArray", "vtkShortArray", "vtkIntArray", "vtkLongLongArray",
          "vtkSignedCharArray", "vtkUnsignedIntArray", "vtkUnsignedShortArray", "vtkUnsignedLongLongArray", "vtkFloatArray")


@pytest.fixture
def grid():
    """Makes two tetrahedra of VTK with the values 6 and 42 in an array of a class."""
    vtk = pytest.importorskip("vtk")

    def grid(array="vtkIntArray", space=""):
        made, points = vtk.vtkUnstructuredGrid(), vtk.vtkPoints()
        points.SetDataTypeToDouble()
        for point in POINTS:
            points.InsertNextPoint(point)
        made.SetPoints(points)
        for corners in TETRAHEDRA:
            made.InsertNextCell(vtk.VTK_TETRA, 4, corners)
        values = getattr(vtk, array)()
        values.SetName("region")
        values.InsertNextValue(6)
        values.InsertNextValue(42)
        made.GetCellData().AddArray(values)
        if space:
            axes = vtk.vtkStringArray()
            axes.SetName("SPACE")
            axes.InsertNextValue(space)
            made.GetFieldData().AddArray(axes)
        return made
    return grid


def write(writer, made, path, **settings):
    for name, value in settings.items():
        getattr(writer, name)(*(() if value is None else (value,)))
    writer.SetFileName(str(path))
    writer.SetInputData(made)
    assert writer.Write()
    return path


def read(path):
    """As from_meshio() does, but in this process, which takes less time."""
    return mesh_files.tetrahedra_of(mesh_files.read(path))


def assert_is_the_grid(path):
    mesh = read(path)
    assert numpy.array_equal(mesh.points, POINTS) and numpy.array_equal(mesh.corners, TETRAHEDRA)
    assert mesh.region.tolist() == [6, 42]


@pytest.mark.parametrize("array, version, mode", itertools.product(ARRAYS, (42, 51), ("ASCII", "Binary")))
def test_legacy_files_are_read_with_every_type_of_numbers(grid, tmp_path, array, version, mode):
    import vtk
    made = grid(array)
    path = write(vtk.vtkUnstructuredGridWriter(), made, tmp_path / "grid.vtk", SetFileVersion=version,
                 **{"SetFileTypeTo" + mode: None})
    assert_is_the_grid(path)


def test_legacy_offsets_may_have_another_type(tmp_path):
    text = ("# vtk DataFile Version 5.1\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 5 double\n" + " ".join(map(str, POINTS.ravel()))
            + "\nMETADATA\nINFORMATION 0\n\nCELLS 3 8\nOFFSETS vtktypeint32\n0 4 8\nCONNECTIVITY vtkIdType\n0 1 2 3 1 4 2 3\n"
            "CELL_TYPES 2\n10\n10\nCELL_DATA 2\nSCALARS region unsigned_char\nLOOKUP_TABLE own\n6 42\nLOOKUP_TABLE own 1\n0 0 0 1\n"
            "POINT_DATA 5\nVECTORS v float\n" + 15 * "1 ")
    (tmp_path / "grid.vtk").write_text(text)
    assert_is_the_grid(tmp_path / "grid.vtk")


@pytest.mark.parametrize("mode, compressor, header, order", itertools.product(
    ("Ascii", "Binary", "Appended", "Raw"), ("None", "ZLib", "LZ4", "LZMA"), ("UInt32", "UInt64"), ("LittleEndian", "BigEndian")))
def test_files_of_xml_are_read_in_every_encoding(grid, tmp_path, mode, compressor, header, order):
    vtk = pytest.importorskip("vtk")
    writer = vtk.vtkXMLUnstructuredGridWriter()
    if mode == "Raw":
        writer.EncodeAppendedDataOff()
    writer.SetBlockSize(32)  # several blocks, the last of them shorter
    path = write(writer, grid("vtkIdTypeArray"), tmp_path / "grid.vtu", **{
        "SetDataModeTo" + mode.replace("Raw", "Appended"): None, "SetCompressorTypeTo" + compressor: None,
        "SetHeaderTypeTo" + header: None, "SetByteOrderTo" + order: None})
    assert_is_the_grid(path)


@pytest.mark.parametrize("writer, ending", [("vtkUnstructuredGridWriter", "vtk"), ("vtkXMLUnstructuredGridWriter", "vtu")])
def test_axes_of_field_data_are_turned_to_lps(grid, tmp_path, writer, ending):
    vtk = pytest.importorskip("vtk")
    made, displacement = grid(space="RAS"), vtk.vtkDoubleArray()
    displacement.SetName("displacement")
    displacement.SetNumberOfComponents(3)
    for _ in POINTS:
        displacement.InsertNextTuple3(1.0, 2.0, 3.0)
    made.GetPointData().AddArray(displacement)
    path = write(getattr(vtk, writer)(), made, tmp_path / f"grid.{ending}")
    assert numpy.array_equal(mesh_files.read(path).point_data["displacement"], [[-1.0, -2.0, 3.0]] * len(POINTS))
    assert numpy.array_equal(mesh_files.read(path, to_lps=False).points, POINTS)
    with pytest.warns(UserWarning, match="it says that it is in RAS, and is turned to LPS"):
        mesh = livermark.from_meshio(path)
    assert numpy.array_equal(mesh.points, POINTS * [-1, -1, 1]) and numpy.array_equal(mesh.tetrahedra, TETRAHEDRA)
    write(getattr(vtk, writer)(), grid(space="LPS"), path)
    assert numpy.array_equal(livermark.from_meshio(path).points, POINTS)


@pytest.mark.parametrize("writer, ending", [("vtkUnstructuredGridWriter", "vtk"), ("vtkXMLUnstructuredGridWriter", "vtu")])
def test_values_that_are_not_read_are_named(grid, tmp_path, writer, ending):
    vtk = pytest.importorskip("vtk")
    made, words = grid(), vtk.vtkStringArray()
    words.SetName("tissue")
    for word in ("liver", "tumour"):
        words.InsertNextValue(word)
    made.GetCellData().AddArray(words)
    found = mesh_files.read(write(getattr(vtk, writer)(), made, tmp_path / f"grid.{ending}"))
    assert found.remarks == ["values that are not read: tissue"]


def array(name, kind, values, components=1):
    return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">'
            f'{" ".join(map(str, numpy.ravel(values)))}</DataArray>')


def piece(points, tetrahedra, ghost=None, num_points=None):
    ghosts = array("vtkGhostType", "UInt8", ghost) if ghost else ""
    return (f'<Piece NumberOfPoints="{num_points or len(points)}" NumberOfCells="{len(tetrahedra)}"><Points>'
            f'{array("Points", "Float64", points, 3)}</Points><Cells>{array("connectivity", "Int32", tetrahedra)}'
            f'{array("offsets", "Int32", numpy.arange(4, 4 * len(tetrahedra) + 1, 4))}'
            f'{array("types", "UInt8", [10] * len(tetrahedra))}</Cells><CellData>{ghosts}'
            f'{array("region", "Int16", [len(points)] * len(tetrahedra))}</CellData></Piece>')


def file_of(tmp_path, *pieces):
    path = tmp_path / "pieces.vtu"
    path.write_text('<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian"><UnstructuredGrid>'
                    + "".join(pieces) + "</UnstructuredGrid></VTKFile>")
    return path


FIRST = POINTS[:4], [[0, 1, 2, 3]]
SECOND = POINTS[[4, 1, 2, 3]], [[1, 0, 2, 3]]


def test_pieces_are_one_body(tmp_path):
    with pytest.warns(UserWarning, match="its 2 pieces are joined at 3 nodes that they share"):
        mesh = livermark.from_meshio(file_of(tmp_path, piece(*FIRST), piece([], []), piece(*SECOND)))
    assert numpy.array_equal(mesh.points, POINTS) and numpy.array_equal(mesh.tetrahedra, TETRAHEDRA)


def test_ghost_cells_count_once(tmp_path):
    with pytest.warns(UserWarning, match="1 ghost cells"):
        mesh = livermark.from_meshio(file_of(tmp_path, piece(*FIRST, ghost=[0]), piece(POINTS, TETRAHEDRA, ghost=[1, 0])))
    assert numpy.array_equal(mesh.points, POINTS) and numpy.array_equal(mesh.tetrahedra, TETRAHEDRA)
    assert mesh.region.tolist() == [4, 5]


@pytest.mark.parametrize("pieces, sentence", [
    ([piece(*FIRST), piece(numpy.repeat(SECOND[0], 2, axis=0), [[1, 0, 2, 4]])], "one has two nodes in one place"),
    ([piece(*FIRST, num_points=5)], "has 4 points and not the 5 that it says"),
    ([piece(*FIRST).replace('NumberOfCells="1"', 'NumberOfCells="2"')], "has 1 cells and not the 2 that it says"),
    ([piece(FIRST[0], [[0, 1, 2, 4]])], "names a node that is not there"),
    ([piece(FIRST[0], [[0, 1, 2, -1]])], "names a node that is not there"),
    ([piece(*FIRST).replace(">10<", ">24<")], "a cell of type tetra10 has 4 corners and not 10"),
    ([piece(*FIRST).replace(">10<", ">42<")], "1 of type polyhedron"),
    ([piece(*FIRST).replace(">10<", ">99<")], "1 of type VTK 99"),
    ([piece(*FIRST).replace(">4</DataArray><DataArray type=\"UInt8\"", ">5</DataArray><DataArray type=\"UInt8\"")],
     "do not fit the list of corners"),
    ([], "there are no tetrahedra"),
])
def test_pieces_that_are_not_as_they_say_are_refused(tmp_path, pieces, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        read(file_of(tmp_path, *pieces))


@pytest.mark.parametrize("text, name, sentence", [
    ('<VTKFile type="PUnstructuredGrid"/>', "a.vtu", "only names other files"),
    ('<VTKFile type="ImageData"/>', "a.vtu", "a data set of the type ImageData, which has no tetrahedra"),
    ('<VTKFile type="UnstructuredGrid" compressor="vtkNewDataCompressor"/>', "a.vtu", "compressed by vtkNewDataCompressor; save it"),
    ("# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n", "a.vtk", "of the type STRUCTURED_POINTS"),
    ("# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 0 float\n", "a.vtk", "a surface; make a body of it"),
    ("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n1 2", "a.vtk", "ends too early"),
    ("# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 quad\n1 2", "a.vtk", "'quad' is no type of numbers"),
    ("no VTK", "a.vtk", "no mesh can be read from it as VTK, so it is damaged"),
    ("", "a.pvtu", "PVTU is not read; it only names other files"),
    ("", "a.unv", "UNV is not read; gmsh converts it"),
    ("", "a.neu", "no mesh can be read from it as NEU, which is no format that is known here"),
])
def test_what_is_not_read_is_named(tmp_path, text, name, sentence):
    (tmp_path / name).write_text(text)
    with pytest.raises(livermark.InputError, match=sentence):
        read(tmp_path / name)
