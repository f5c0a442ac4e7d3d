"""Slices of the image of a body: the contour of its mesh is where the mesh is, and the patient lies as on a radiologist's screen."""
import gzip
import os
import pathlib
import re
import shutil
import struct
import subprocess

import h5py
import numpy
import pytest
from conftest import BINARY, RUNS
from livermark.errors import InputError
from livermark.report import colours, slices
from PIL import Image
from report_first_page_test import regions_named

FACES = numpy.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
                     [1, 3, 5], [3, 7, 5]])  # of the cube of conftest


def told(right=(0.001, 0.0, 0.0), up=(0.0, 0.0, 0.001), origin=(0.0005, 0.005, 0.0005), size=(10, 8)):
    """A plane whose labels are their own numbers."""
    return {"size": list(size), "origin": list(origin), "right": list(right), "up": list(up),
            "label": list(range(1, size[0] * size[1] + 1))}


def test_the_contour_of_a_cube_is_a_square_where_the_cube_is(bar):
    points, _ = bar
    plane = slices.planes_of({"planes": [told()]})[0]
    ends = slices.contour(FACES, points, plane)
    assert ends.reshape(-1, 2).min(axis=0) == pytest.approx([-0.5, -0.5]) and ends.reshape(-1, 2).max(axis=0) == pytest.approx([9.5, 9.5])
    assert numpy.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).sum() == pytest.approx(40.0), "its four sides, once"
    assert slices.contour(FACES, points + [0.0, 0.02, 0.0], plane).shape == (0, 2, 2)
    shifted = slices.contour(FACES, points + [0.002, 0.0, 0.0], plane).reshape(-1, 2)
    assert shifted.min(axis=0) == pytest.approx([1.5, -0.5]), "the deformed one goes with its points"


@pytest.mark.parametrize("right, up", [((-0.001, 0, 0), (0, 0, 0.001)), ((0, 0, -0.001), (0.001, 0, 0)), ((0, 0, 0.002), (-0.001, 0, 0)),
                                       ((0.001, 0, 0), (0, -0.001, 0)), ((0, 0, 0.001), (0, 0.001, 0))])
def test_every_plane_is_turned_and_keeps_its_voxels_in_their_places(right, up):
    given = told(right, up)
    plane = slices.planes_of({"planes": [given]})[0]
    assert plane.right.max() > 0.0 and plane.up.max() > 0.0
    assert numpy.abs(plane.right).argmax() < numpy.abs(plane.up).argmax()

    def places(label, origin, along, across):
        rows, columns = numpy.indices(label.shape)
        where = origin + columns[..., None] * numpy.asarray(along) + rows[..., None] * numpy.asarray(across)
        return {int(number): tuple(numpy.round(place, 9)) for number, place in zip(label.ravel(), where.reshape(-1, 3))}
    before = numpy.reshape(given["label"], given["size"][::-1])
    assert places(plane.label, plane.origin, plane.right, plane.up) == places(before, numpy.array(given["origin"]), right, up)


def test_a_sheet_has_both_contours_and_the_sides_of_the_patient(bar):
    points, _ = bar
    planes = slices.planes_of({"planes": [told(), told(up=(0.0, 0.001, 0.0), origin=(0.0005, 0.0005, 0.005))]})
    sheet = slices.sheet(planes, FACES, points, points + 0.001, "as springs deform it")
    assert {text.get_text() for text in sheet.texts} == {"contour of the mesh", "as springs deform it"}
    axial, coronal = ({text.get_text(): text.get_position()[1] for text in axes.texts} for axes in sheet.axes)
    assert coronal["S"] > coronal["I"] and axial["A"] > axial["P"] and {"R", "L"} <= coronal.keys() & axial.keys()
    assert sheet.axes[0].yaxis_inverted() and not sheet.axes[1].yaxis_inverted()
    assert [len(axes.collections) for axes in sheet.axes] == [2, 2]


def test_each_side_of_the_patient_stands_at_one_end_however_the_image_is_turned(bar):
    """Two axes of this image are nearest to left, and none to the back."""
    points, _ = bar
    first, last = numpy.array([0.70, 0.69, 0.18]) / numpy.linalg.norm([0.70, 0.69, 0.18]), numpy.array([0.70, -0.52, -0.49])
    last = (last - (last @ first) * first) / numpy.linalg.norm(last - (last @ first) * first)
    axes = 0.001 * numpy.array([first, last, numpy.cross(first, last)])
    assert [numpy.abs(axis).argmax() for axis in axes] == [0, 0, 2]
    sheet = slices.sheet(slices.planes_of({"planes": [told(axes[i], axes[j]) for i, j in ((0, 1), (0, 2), (1, 2))]}), FACES, points)
    assert [{text.get_text() for text in each.texts} for each in sheet.axes] == [{*"RLAP"}, {*"RLIS"}, {*"APIS"}]


@pytest.mark.parametrize("change", [{"size": [0, 8]}, {"size": [10**6, 10**6]}, {"label": [1, 2]}, {"up": [0, 0, 0]}, {"origin": None},
                                    {"right": [float("nan"), 0, 0]}])
def test_what_is_no_plane_is_refused(change):
    with pytest.raises(InputError, match="^slices of an image: they cannot be read"):
        slices.planes_of({"planes": [{**told(), **change}]})


def test_the_report_draws_slices_of_a_body_that_has_an_image(tmp_path):
    """By the Python part alone: what `livermark` hands over for the body of a result file."""
    from livermark.report import patient
    from livermark.report.data import ReportData, read_result
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path)
    regions_named(tmp_path / "beam_bend.h5", "seg", [b"parenchyma"])
    result = read_result(tmp_path / "beam_bend.h5", {"file": "beam_bend.h5", "label": "seg", "counts": True, "leaves_regime": False,
                                                     "remarks": []})
    with h5py.File(tmp_path / "beam_bend.h5") as file:
        middle = file["mesh/points"][:].mean(axis=0)
    data = ReportData.__new__(ReportData)
    data.slices = {"seg": {"load_case": "beam_bend", "slices": {"planes": [told(origin=tuple(middle - [0.005, 0.0, 0.004]))]}}}
    html = patient._slices(data, [result])
    assert f"as {result.best_springs.name} deforms it" in html and "below the tool" in html and colours.VARIABLES[colours.BLUE] in html
    data.slices["seg"]["load_case"] = "another"
    assert patient._slices(data, [result]) == ""


SEGMENT = pathlib.Path(os.path.realpath(BINARY)).parent / "livermark-segment"


def run_in(folder, *words, program=BINARY):
    done = subprocess.run([program, *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def read_nrrd(path):
    """Labels (first axis first), steps between voxels and place of the first one, as the phantom has them [mm, LPS]."""
    head, data = path.read_bytes().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines() if ": " in line)
    numbers = [numpy.array(re.findall(r"[-+.e\d]+", fields[name]), float) for name in ("space directions", "space origin")]
    labels = numpy.frombuffer(gzip.decompress(data), "<u2").reshape([int(size) for size in fields["sizes"].split()][::-1])
    return labels.transpose(), numbers[0].reshape(3, 3), numbers[1]


def write_ras_nrrd(path, labels, steps, origin):
    """With the axes that other programs have: right, anterior, superior."""
    steps, origin = steps * [-1.0, -1.0, 1.0], origin * [-1.0, -1.0, 1.0]
    vectors = ["(" + ",".join(f"{float(x)!r}" for x in vector) + ")" for vector in (*steps, origin)]
    head = (f"NRRD0004\ntype: unsigned char\ndimension: 3\nspace: right-anterior-superior\nsizes: {' '.join(map(str, labels.shape))}\n"
            f"space directions: {' '.join(vectors[:3])}\nendian: little\nencoding: raw\nspace origin: {vectors[3]}\n\n")
    path.write_bytes(head.encode() + labels.astype("u1").transpose().tobytes())


def write_nifti(path, labels, steps, origin):
    """NIfTI-1 with an sform alone, in mm."""
    head = bytearray(352)
    for place, kind, values in ((0, "i", [348]), (40, "8h", [3, *labels.shape, 1, 1, 1, 1]), (70, "2h", [2, 8]),
                                (76, "4f", [1.0, *numpy.linalg.norm(steps, axis=1)]), (108, "2f", [352.0, 1.0]), (254, "h", [1])):
        struct.pack_into(f"<{kind}", head, place, *values)
    struct.pack_into("<12f", head, 280, *numpy.column_stack([(steps * [-1.0, -1.0, 1.0]).T, origin * [-1.0, -1.0, 1.0]]).ravel())
    head[123], head[344:348] = 2, b"n+1\0"
    path.write_bytes(bytes(head) + labels.astype("u1").transpose().tobytes())


def inside(ends, shape):
    """Pixels whose centres are inside closed lines: an odd number of them is on their left."""
    rows, columns = numpy.indices(shape)
    (x0, y0), (x1, y1) = ends[:, 0].T, ends[:, 1].T
    found = numpy.zeros(shape, int)
    for a, b, c, d in zip(x0, y0, x1, y1):
        spans = (b > rows) != (d > rows)
        found += spans & (a + (rows - b) / (d - b if d != b else 1.0) * (c - a) < columns)
    return found % 2 == 1


@pytest.mark.skipif(not SEGMENT.exists(), reason="bodies of images need livermark-segment")
@pytest.mark.parametrize("name, write, order, flips", [("permuted.nrrd", write_ras_nrrd, (2, 0, 1), (True, True, False)),
                                                       ("mirrored.nii", write_nifti, (1, 0, 2), (True, False, True))])
def test_contours_fit_voxels_of_any_length_however_their_axes_lie(tmp_path, name, write, order, flips):
    run_in(tmp_path, "mesh", "--phantom", "--spacing", "0.002", "0.003", "0.005", "--turn", "0.35", "0.2", "-0.3", "-o", "phantom.nrrd")
    labels, steps, origin = read_nrrd(tmp_path / "phantom.nrrd")
    labels, steps = labels.transpose(order), steps[list(order)]
    for axis in numpy.flatnonzero(flips):
        origin = origin + (labels.shape[axis] - 1) * steps[axis]
        steps[axis] *= -1.0
        labels = numpy.flip(labels, axis)
    write(tmp_path / name, labels, steps, origin)
    run_in(tmp_path, "mesh", "--labels", name, "--tetrahedra", "4000", "-o", "seg.msh")
    mesh = pytest.importorskip("meshio").read(tmp_path / "seg.msh")
    tetrahedra = numpy.concatenate([block.data for block in mesh.cells if block.type == "tetra"])
    faces = numpy.concatenate([tetrahedra[:, corners] for corners in ([1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1])])
    _, which, count = numpy.unique(numpy.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    middle = ",".join(str(x) for x in 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0)))
    run_in(tmp_path, "slices", name, f"--at={middle}", "--output", "slices.json", program=SEGMENT)
    planes = slices.read(tmp_path / "slices.json")
    for plane in planes:
        of_mesh = inside(slices.contour(faces[which[count == 1]], mesh.points, plane), plane.label.shape)
        assert (of_mesh != (plane.label > 0)).sum() < 0.04 * (plane.label > 0).sum()
    letters = [{text.get_text() for text in axes.texts} for axes in slices.sheet(planes, faces[:0], mesh.points).axes]
    assert letters == [{*"RLAP"}, {*"RLIS"}, {*"APIS"}]


@pytest.mark.skipif(not SEGMENT.exists(), reason="bodies of images need livermark-segment")
def test_a_body_of_an_image_has_slices_in_its_picture_and_report(tmp_path):
    def run(*words):
        run_in(tmp_path, *words)
    (tmp_path / "runs").mkdir()
    run("mesh", "--phantom", "--spacing", "0.003", "0.003", "0.003", "-o", "seg.nrrd")
    run("mesh", "--labels", "seg.nrrd", "--tetrahedra", "4000", "-o", "runs/seg.msh", "--picture", "with.png")
    run("run", "--body", "runs/seg.toml", "--static", "--load-case", "palpation", "--model", "lloyd", "--reference-on-mesh", "--output", "runs")
    run("report", "runs")
    assert "seg: slices of the label image below the tool" in (tmp_path / "runs/report.html").read_text(encoding="utf-8")
    shutil.move(tmp_path / "seg.nrrd", tmp_path / "elsewhere.nrrd")
    run("mesh", "check", "runs/seg.toml", "--picture", "without.png")
    heights = [Image.open(tmp_path / name).height for name in ("with.png", "without.png")]
    assert heights[0] > heights[1] + 300
    run("report", "runs")
    assert "slices of the label image" not in (tmp_path / "runs/report.html").read_text(encoding="utf-8")
    (tmp_path / "seg.nrrd").write_bytes((tmp_path / "elsewhere.nrrd").read_bytes() + b"\0")
    run("report", "runs")
    assert "slices of the label image" not in (tmp_path / "runs/report.html").read_text(encoding="utf-8"), "it has changed"
