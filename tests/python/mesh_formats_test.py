"""Meshes of Abaqus and TetGen as programs write them: nothing of a file is lost without a word."""
import livermark
import numpy
import pytest

pytest.importorskip("meshio")

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
