"""Meshes as other programs write them: nothing of a file is lost without a word."""
import livermark
import numpy
import pytest
from livermark.convert import mesh_files

meshio = pytest.importorskip("meshio")

POINTS = "*NODE\n1, 0., 0., 0.\n2, 0.1, 0., 0.\n3, 0., 0.1, 0.\n4, 0., 0., 0.1\n5, 0.1, 0.1, 0.1\n"
FIRST, SECOND = "10, 1, 2, 3, 4\n", "20, 2, 3, 4, 5\n"
ELEMENTS = "*ELEMENT, TYPE=C3D4\n" + FIRST + SECOND


@pytest.fixture
def read(tmp_path):
    def read(text, name="mesh.inp", encoding="utf-8"):
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode(encoding))
        return livermark.from_meshio(tmp_path / name)
    return read


def of_second(mesh):
    return mesh.region_names.get(int(mesh.region[1])), mesh.region_names.get(int(mesh.region[0]))


@pytest.mark.parametrize("text", [
    POINTS + "*ELEMENT, TYPE=C3D4\n" + FIRST + "*ELEMENT, TYPE=C3D4, ELSET=lesion\n" + SECOND,  # after a block without one
    POINTS + ELEMENTS + "*ELSET, ELSET=lesion\n20\n",
    POINTS + ELEMENTS + "*Elset, elset=lesion, generate\n20, 20, 1\n",
    POINTS + ELEMENTS + "*ELSET, ELSET=lesion\n*ELSET, ELSET=LESION\n20,\n",  # again, in other letters
    POINTS + ELEMENTS + "*ELSET,\nELSET=lesion\n20\n",
    POINTS + "*ELEMENT, TYPE=C3D4H\n" + FIRST + SECOND + "*ELSET, ELSET=lesion\n20\n",
    "*PART, NAME=P\n" + POINTS + ELEMENTS + "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n"
    "*ELSET, ELSET=lesion, INSTANCE=I\n20\n*END ASSEMBLY\n",
    (POINTS + ELEMENTS + "*ELSET, ELSET=lesion\n20\n").replace("\n", "\r\n"),
    "\ufeff" + POINTS + ELEMENTS + "*ELSET, ELSET=lesion\n20\n",
    POINTS.replace("0.1", "1.D-1") + ELEMENTS + "*ELSET, ELSET=lesion\n20\n",
])
def test_sets_of_abaqus_are_those_of_the_file(read, text, recwarn):
    mesh = read(text)
    assert of_second(mesh) == ("lesion", None)
    assert mesh.points.max() == pytest.approx(0.1)
    assert not [w for w in recwarn if "set" in str(w.message)]


def test_a_set_of_sets_has_all_of_their_elements(read):
    text = POINTS + ELEMENTS + "*ELSET, ELSET=A\n10\n*ELSET, ELSET=B\n20\n*ELSET, ELSET=BOTH\nA, B\n"
    with pytest.warns(UserWarning, match="'BOTH' and 'B' share 1 tetrahedra, which count as 'B'"):
        assert read(text).region_names == {1: "A", 2: "B"}


def test_a_name_that_is_not_of_unicode_is_read(read):
    mesh = read(POINTS + ELEMENTS + "*ELSET, ELSET=L\xe4sion\n20\n", encoding="latin-1")
    assert of_second(mesh) == ("L\xe4sion", None)


def test_an_instance_lies_where_it_is_placed(read):
    mesh = read("*PART, NAME=P\n" + POINTS + ELEMENTS + "*END PART\n*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=p\n0.5, 0., 0.\n"
                "*END INSTANCE\n*END ASSEMBLY\n")
    assert mesh.points[:, 0].min() == pytest.approx(0.5) and mesh.points[:, 1].min() == pytest.approx(0.0)


@pytest.mark.parametrize("more, remark", [
    ("*MATERIAL, NAME=M\n*ELASTIC\n5e3, 0.45\n", r"keywords that are not used: \*MATERIAL, \*ELASTIC"),
    ("*NSET, NSET=HELD\n1, 2\n", r"keywords that are not used: \*NSET"),
    ("*ELEMENT, TYPE=MASS\n99, 1\n", "1 elements of type MASS are not used"),
    ("*ELSET, ELSET=X\n10, 999\n", "the set 'X' names 1 elements that are not there"),
    ("*ELSET, ELSET=X, GENERATE\n1, 4000000000001, 1\n", "the set 'X' names 3999999999999 elements that are not there"),
])
def test_what_is_not_used_is_named(read, more, remark):
    with pytest.warns(UserWarning, match=remark):
        read(POINTS + ELEMENTS + more)


PART = "*PART, NAME={0}\n" + POINTS + ELEMENTS + "*END PART\n"


@pytest.mark.parametrize("text, sentence", [
    ("*INCLUDE, INPUT=/dev/zero\n", "it goes on in another file, '/dev/zero'; put that into it"),
    ("*NODE, INPUT=/dev/zero\n", "it goes on in another file"),
    (POINTS + ELEMENTS + "*NGEN\n1, 5\n", r"\*NGEN makes or moves nodes"),
    (PART.format("P") + PART.format("Q"), r"several parts or instances \(P, Q\); merge them"),
    (PART.format("P") + "*ASSEMBLY\n*INSTANCE, NAME=I, PART=P\n*END INSTANCE\n*INSTANCE, NAME=J, PART=P\n1.,0.,0.\n*END INSTANCE\n",
     r"several parts or instances \(I, J\)"),
    (PART.format("P") + "*ASSEMBLY\n*INSTANCE, NAME=I, PART=P\n0.,0.,0.\n0.,0.,0.,0.,0.,1.,90.\n*END INSTANCE\n", "its instance is turned"),
    (POINTS + ELEMENTS + "*ELEMENT, TYPE=C3D8\n30, 1,2,3,4,5,1,2,3\n", "1 of type hexahedron; mesh all of the volume"),
    (POINTS + "*ELEMENT, TYPE=C3D4\n10, 1, 2, 3, 9\n", "there is no node 9; correct the element"),
    (POINTS + "*ELEMENT, TYPE=C3D4\n10, 1, 2, 3\n", "have 4 nodes each"),
    (POINTS + "*NODE\n1, 2., 2., 2.\n" + ELEMENTS, "node 1 occurs twice"),
    (POINTS + ELEMENTS + ELEMENTS, "element 10 occurs twice"),
    (POINTS + ELEMENTS + "*ELSET, ELSET=A\nB\n*ELSET, ELSET=B\nA\n", "which is no set before it"),
    (POINTS + ELEMENTS + "*ELSET, ELSET=A, GENERATE\n20, 10, 1\n", "GENERATE goes in no step"),
    (POINTS + ELEMENTS + "*ELSET, ELSET=A, GENERATE\n20\n", "has not two or three numbers in a row"),
    ("*NODE\n1, 0., x, 0.\n", r"'x' in \*NODE is not a number"),
    ("*NODE, SYSTEM=C\n1, 0., 0., 0.\n", "in cylindrical or spherical coordinates"),
    ((POINTS + ELEMENTS).encode("utf-16"), "it is UTF-16; save it as UTF-8"),
    ("", "there are no elements in it"),
])
def test_a_file_of_abaqus_that_says_more_is_refused(read, text, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        read(text)


NODES = "# of TetGen\n5 3 0 0\n0 0 0 0\n1 0.1 0 0\n2 0 0.1 0\n3 0 0 0.1\n4 0.1 0.1 0.1 # the last\n"


@pytest.mark.parametrize("elements, regions, names", [
    ("2 4 1\n0 0 1 2 3 1\n1 1 2 3 4 2\n", [1, 2], {}),
    ("2 4 1\n0 0 1 2 3 -1\n1 1 2 3 4 -2\n", [-1, -2], {}),
    ("2 4 1\n0 0 1 2 3 1.0\n1 1 2 3 4 2.0\n", [1, 2], {}),
    ("2 4 1\n0 0 1 2 3 2.5\n1 1 2 3 4 0.5\n", [2, 1], {1: "0.5", 2: "2.5"}),
    ("2 4 0\n0 0 1 2 3\n1 1 2 3 4\n", [0, 0], {}),
])
def test_attributes_of_tetgen_are_regions(read, tmp_path, elements, regions, names):
    (tmp_path / "MESH.NODE").write_text(NODES)
    mesh = read(elements, "MESH.ELE")
    assert mesh.region.tolist() == regions and mesh.region_names == names
    assert numpy.array_equal(mesh.tetrahedra, [[0, 1, 2, 3], [1, 2, 3, 4]]) or len(mesh.tetrahedra) == 2
    assert livermark.from_meshio(tmp_path / "MESH.NODE").region.tolist() == regions


def test_a_second_attribute_of_tetgen_is_named(read, tmp_path):
    (tmp_path / "mesh.node").write_text(NODES)
    with pytest.warns(UserWarning, match="values of cells that are not used: tetgen:ref2"):
        assert read("2 4 2\n0 0 1 2 3 1 7\n1 1 2 3 4 2 8\n", "mesh.ele").region.tolist() == [1, 2]


@pytest.mark.parametrize("nodes, elements, sentence", [
    (None, "1 4 0\n0 0 1 2 3\n", "there is no file 'mesh.node' beside it"),
    (NODES, "2 4 0\n0 0 1 2 3\n", "has 1 rows and not those that its first one tells"),
    (NODES, "1 4 0\n0 0 1 2 9\n", "there is no node 9"),
    (NODES, "1 4 0\n0 0 1 two 3\n", "a row of mesh.ele has no numbers"),
    (NODES, "1000000000 4 0\n0 0 1 2 3\n", "has 1 rows"),
    (NODES.replace("5 3", "5 2"), "1 4 0\n0 0 1 2 3\n", "no three coordinates"),
])
def test_a_mesh_of_tetgen_that_lacks_something_is_refused(read, tmp_path, nodes, elements, sentence):
    if nodes:
        (tmp_path / "mesh.node").write_text(nodes)
    with pytest.raises(livermark.InputError, match=sentence):
        read(elements, "mesh.ele")


GRIDS = """GRID    1               0.      0.      0.
GRID,2,,1.D-1,,
GRID*   3                               0.              1.0-1
*       0.
GRID    4       0       0.0     0.0     .1E+0
GRID    5               100.-3  0.1     0.1
"""
SOLIDS = "CTETRA  10      7       1       2       3       4\n+\nCTETRA,20,8,2,3,4,5\n"


@pytest.mark.parametrize("text", [
    "SOL 101\nCEND\nBEGIN BULK\n" + GRIDS + SOLIDS + "ENDDATA\n",
    GRIDS + SOLIDS,  # bulk data alone
    (GRIDS + SOLIDS).lower(),
    SOLIDS + GRIDS.replace("\n", " $ a remark\n$ another\n"),
    (GRIDS + SOLIDS).replace("\n", "\r\n"),
    GRIDS + SOLIDS.replace("CTETRA,20,8,2,3,4,5", "CTETRA\t20\t8\t2\t3\t4\t5"),
    GRIDS + SOLIDS.replace("CTETRA,20,8,2,3,4,5", "CTETRA,20,8,2,3,4,5,,\n,,,,"),
    GRIDS + SOLIDS.replace("CTETRA,20,8,2,3,4,5", "CTETRA*,20,8,2,3\n*,4,5"),
    "CORD2C  5       0       0.      0.      0.      0.      0.      1.\n        1.      0.      0.\n" + GRIDS + SOLIDS,
])
def test_bulk_data_of_nastran_is_read_in_every_form(read, text, recwarn):
    mesh = read(text, "mesh.bdf")
    assert mesh.points.ravel().tolist() == pytest.approx([0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1, 0.1, 0.1, 0.1])
    assert mesh.region.tolist() == [7, 8] and len(recwarn) == 0
    assert [sorted(corners) for corners in mesh.tetrahedra.tolist()] == [[0, 1, 2, 3], [1, 2, 3, 4]]


@pytest.mark.parametrize("text, sentence", [
    (GRIDS.replace("GRID    4       0", "GRID    4       3") + SOLIDS + "CORD2C,3,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
     "the coordinates of node 4 are of the cylindrical system 3, which is not converted"),
    ("GRDSET,,6\n" + GRIDS + SOLIDS, "the coordinates of node 1 are of the unknown system 6"),
    (GRIDS + "INCLUDE '/dev/zero'\n" + SOLIDS, "it goes on in another file"),
    ("BEGIN BULK\n" + GRIDS + "BEGIN SUPER=1\n" + SOLIDS, "it has several parts"),
    (GRIDS + GRIDS + SOLIDS, "node 1 occurs twice"),
    (GRIDS + SOLIDS + SOLIDS, "element 10 occurs twice"),
    (GRIDS + "CTETRA,1,1,1,2,3,9\n", "there is no node 9"),
    (GRIDS + "CTETRA,1,1,1,2,3\n", "has fewer than 4 corners"),
    (GRIDS + "GRID,6,,x,0.,0.\n" + SOLIDS, "'X' in GRID is not a number"),
    (GRIDS + SOLIDS + "CHEXA,1,1,1,2,3,4,5,1\n,2,3\n", "1 of type hexahedron"),
])
def test_bulk_data_of_nastran_that_says_more_is_refused(read, text, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        read(text, "mesh.bdf")


def test_cards_of_nastran_that_are_not_used_are_named(read):
    with pytest.warns(UserWarning, match="cards that are not used: PSOLID, MAT1"):
        read("PSOLID,7,1\nMAT1,1,5.+3,,.45\n" + GRIDS + SOLIDS, "mesh.nas")


UCD = "# of AVS\n5 2 0 0 0\n1 0 0 0\n2 .1 0 0\n3 0 .1 0\n4 0 0 .1\n5 .1 .1 .1\n1 6 tet 1 2 3 4\n2 42 tet 2 5 3 4\n"


@pytest.mark.parametrize("name", ["mesh.inp", "MESH.AVS"])
def test_a_file_of_avs_is_told_from_one_of_abaqus(read, name):
    mesh = read(UCD, name)
    assert mesh.region.tolist() == [6, 42] and mesh.points.shape == (5, 3)
    assert [sorted(corners) for corners in mesh.tetrahedra.tolist()] == [[0, 1, 2, 3], [1, 2, 3, 4]]
    with pytest.raises(livermark.InputError, match="no mesh can be read|ends too early"):
        read(UCD.replace("5 2 0", "6 2 0"), name)


def test_values_of_avs_are_named(read):
    values = ("1 1\nheat, K\n" + "".join(f"{n} 1.5\n" for n in range(1, 6)), "2 1 3\nquality, none\nflow, m/s\n1 0 0 0 0\n2 0 0 0 0\n")
    for sizes, text, names in (("1 0", values[0], "heat"), ("0 4", values[1], "quality, flow"), ("1 4", values[0] + values[1], "heat, quality, flow")):
        with pytest.warns(UserWarning, match=f"values that are not used: {names}$"):
            assert read(UCD.replace("5 2 0 0", f"5 2 {sizes}") + text, "mesh.inp").region.tolist() == [6, 42]


@pytest.mark.parametrize("old, new, sentence", [
    ("tet 2 5 3 4", "tet 2 5 3 9", "there is no node 9; correct the cell"), ("tet 2 5 3 4", "tet 2 5 3", "has 3 nodes and not 4"),
    ("tet 2 5 3 4", "hex 1 2 3 4 5 1 2 3", "1 of type hexahedron"), ("5 2 0 0 0", "500000000000 2 0 0 0", "ends too early")])
def test_a_file_of_avs_that_says_more_is_refused(read, old, new, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        read(UCD.replace(old, new), "mesh.avs")


FAMILIES = {"FAM_-6_tumour": (-6, ["tumour"]), "FAM_-8_both": (-8, ["tumour", "liver"]), "FAM_-9": (-9, [])}


@pytest.fixture
def med_file(tmp_path):
    """Writes a file as Salome does: numbers of nodes that begin with one, families of which one has no groups, and a field."""
    h5py = pytest.importorskip("h5py")

    def med_file(families=(-6, -9), more=lambda file: None):
        path = tmp_path / "mesh.med"
        with h5py.File(path, "w") as file:
            whole = file.create_group("ENS_MAA/liver")
            whole.attrs["ESP"] = 3
            mesh = whole.create_group("-0000000000000000001-0000000000000000001")
            points = numpy.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1], [0.1, 0.1, 0.1]])
            for name, values in (("NOE/COO", points), ("MAI/TE4/NOD", numpy.array([[1, 3, 2, 4], [2, 3, 5, 4]])),
                                 ("MAI/TR3/NOD", numpy.array([[1, 2, 3]]))):
                mesh[name] = values.ravel(order="F")
                mesh[name].attrs["NBR"] = len(values)
            mesh["MAI/TE4/FAM"] = numpy.array(families)
            for name, (number, groups) in FAMILIES.items():
                family = file.create_group(f"FAS/liver/ELEME/{name}")
                family.attrs["NUM"] = number
                if groups:
                    family["GRO/NOM"] = numpy.array([numpy.frombuffer(group.encode().ljust(80, b"\0"), "i1") for group in groups])
            file.create_group("CHA/temperature/0001/MAI.TE4")
            more(file)
        return path
    return med_file


def test_groups_of_a_med_file_have_their_names(med_file, recwarn):
    mesh = livermark.from_meshio(med_file())
    assert mesh.region_names == {1: "tumour"} and mesh.region.tolist() == [1, 0] and len(recwarn) == 0
    assert [sorted(corners) for corners in mesh.tetrahedra.tolist()] == [[0, 1, 2, 3], [1, 2, 3, 4]]
    with pytest.warns(UserWarning, match="the sets 'tumour' and 'liver' share 1 tetrahedra, which count as 'liver'"):
        mesh = livermark.from_meshio(med_file((-6, -8)))
    assert mesh.region_names == {1: "liver", 2: "tumour"} and mesh.region.tolist() == [2, 1]


@pytest.mark.parametrize("more, sentence", [
    (lambda file: file.create_group("ENS_MAA/second"), "it has 2 meshes; save one alone"),
    (lambda file: file["ENS_MAA/liver"].create_group("0001"), "it has 2 steps of time"),
    (lambda file: file["ENS_MAA/liver/-0000000000000000001-0000000000000000001/MAI"].create_group("POE"), "another type, POE"),
    (lambda file: file["ENS_MAA/liver"].attrs.modify("ESP", 2), "no three coordinates"),
    (lambda file: file.move("ENS_MAA", "MAA"), "no mesh of MED 2.3 or newer"),
])
def test_a_med_file_that_says_more_is_refused(med_file, more, sentence):
    with pytest.raises(livermark.InputError, match=sentence):
        livermark.from_meshio(med_file(more=more))


WRITTEN_BY_MESHIO = [("mesh.msh", {"file_format": "gmsh22", "binary": True}), ("mesh.msh", {"file_format": "gmsh", "binary": True}),
                     ("mesh.msh", {"file_format": "gmsh22", "binary": False}), ("mesh.msh", {"file_format": "gmsh", "binary": False}),
                     ("mesh.mesh", {}), ("mesh.meshb", {}), ("mesh.su2", None), ("mesh.xdmf", {"data_format": "XML"}),
                     ("mesh.xml", {})]


@pytest.mark.parametrize("name, settings", WRITTEN_BY_MESHIO)
def test_a_library_that_loses_nodes_or_cells_is_found_out(tmp_path, monkeypatch, bar, name, settings):
    points, tetrahedra = bar
    path = tmp_path / name
    cannot_have_faces = name.endswith(".xml") or (settings or {}).get("file_format") == "gmsh"  # as meshio writes them
    faces = [] if cannot_have_faces else [("triangle", [[0, 1, 3]])]
    num_cells = 6 + len(faces)
    if settings is None:
        path.write_text("NDIME= 3\nNELEM= 6\n" + "".join("10 {} {} {} {}\n".format(*corners) for corners in tetrahedra) + "NPOIN= 8\n"
                        + "".join("{} {} {}\n".format(*point) for point in points)
                        + "NMARK= 1\nMARKER_TAG= 1\nMARKER_ELEMS= 1\n5 0 1 3\n")
    else:
        meshio.Mesh(points, faces + [("tetra", tetrahedra)]).write(path, **settings)
    mesh = mesh_files.read(path)
    assert len(mesh.points) == 8 and mesh.remarks == []
    whole = meshio.read

    def without_a_cell(*arguments):
        found = whole(*arguments)
        return meshio.Mesh(found.points, [(block.type, block.data[1:] if block.type == "tetra" else block.data) for block in found.cells])

    def with_a_node(*arguments):
        found = whole(*arguments)
        return meshio.Mesh(numpy.vstack([found.points, [0, 0, 0]]), found.cells)

    for loser, found in ((without_a_cell, f"finds 8 nodes and {num_cells - 1} cells, and the file says that it has 8 and {num_cells}"),
                         (with_a_node, f"finds 9 nodes and {num_cells} cells, and the file says that it has 8 and {num_cells}")):
        monkeypatch.setattr(meshio, "read", loser)
        with pytest.raises(livermark.InputError, match=found):
            mesh_files.read(path)


def test_a_format_that_cannot_be_checked_says_so(tmp_path, bar):
    points, tetrahedra = bar
    meshio.Mesh(points, [("tetra", tetrahedra)]).write(tmp_path / "mesh.ugrid")
    assert mesh_files.read(tmp_path / "mesh.ugrid").remarks == [
        "a file that ends in .ugrid does not say in a place known here how much it has: check that it is 8 nodes and 6 tetrahedra"]
