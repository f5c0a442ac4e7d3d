"""What a report begins with: the order of bodies, the picture from the hand, the terms, the reference's own error, a patient's body."""
import re
import shutil
import types

import h5py
import numpy
import pytest
from conftest import RUNS
from livermark.report import first_picture, order, patient, reference, surfaces
from livermark.report.data import ReportData, with_signs
from livermark.report.sections.pictures import Body
from report_test import XHTML, pixels_of, report_of, sentences, tables, texts

BODIES = {"liver_tumours": [b"parenchyma", b"tumour_1"], "liver_healthy": [b"parenchyma"], "patient": [b"parenchyma", b"tumour_1"]}


def regions_named(path, body, names):
    """The same file of another body, whose regions have these names."""
    with h5py.File(path, "r+") as file:
        file.attrs["body"] = numpy.bytes_(body)
        count = len(file["materials/young_modulus"])
        for name, values in file["materials"].items():
            value = values[:]
            del file["materials"][name]
            file["materials"][name] = numpy.resize(value, len(names))
        attributes = {name: value for name, value in file["mesh/region"].attrs.items() if name != "names"}
        region = file["mesh/region"][:]
        assert count == 1 and not region.any()
        region[:len(names) - 1] = numpy.arange(1, len(names))  # a tetrahedron each
        del file["mesh/region"]
        file["mesh/region"] = region
        file["mesh/region"].attrs.update({**attributes, "names": numpy.array(names)})


def own_error(path, uncertainty):
    """The same file with a reference whose own error is known."""
    with h5py.File(path, "r+") as file:
        group = file.require_group("reference")
        group.attrs["model"] = group.attrs["refined_model"] = next(iter(file["comparisons"].values())).attrs["reference"]
        for name in ("refinement_difference", "order", "energy_uncertainty", "reaction_uncertainty"):
            group.attrs[name] = 1.0
        group.attrs["reference_uncertainty"], group.attrs["stiffness_uncertainty"] = uncertainty


@pytest.fixture(scope="module")
def several(tmp_path_factory):
    """The report of four bodies, whose names are in the wrong order."""
    folder = tmp_path_factory.mktemp("several")
    for body, names in {"beam": None, **BODIES}.items():
        (folder / body).mkdir()
        shutil.copy(RUNS / "beam" / "beam_bend.h5", folder / body)
        own_error(folder / body / "beam_bend.h5", (0.0034, 0.0012))
        if names:
            regions_named(folder / body / "beam_bend.h5", body, names)
    return report_of(folder)


def test_livers_come_first_and_the_beam_last():
    names = ["beam", "beam_fine", "box", "liver_healthy", "liver_tumours", "seg"]
    regions = {"seg": ["parenchyma", "tumour_1"]}
    assert sorted(names, key=lambda name: order.place(name, regions.get(name, ()))) == [
        "liver_tumours", "seg", "liver_healthy", "box", "beam", "beam_fine"]


def test_bodies_have_one_order_in_every_part(several):
    expected = ["liver_tumours", "patient", "liver_healthy", "beam"]
    titles = ["".join(title.itertext()) for title in several.find(f".//{XHTML}header").iter(f"{XHTML}h3")]
    assert titles == expected
    for section in several.iter(f"{XHTML}section"):
        found = ["".join(title.itertext()) for title in section.iter(f"{XHTML}h3")]
        assert [title for title in found if title in expected] in (expected, []), section.get("id")
        for table in section.iter(f"{XHTML}table"):
            first = [texts(row)[0] for row in table.iter(f"{XHTML}tr")]
            assert list(dict.fromkeys(cell for cell in first if cell in expected)) in (expected, []), section.get("id")
    panels = [title.text for title in several.find(f".//{XHTML}header").iter("{http://www.w3.org/2000/svg}title")]
    assert [title for title in panels if title in expected] == expected


def test_columns_of_a_table_have_the_order_of_bodies():
    data = types.SimpleNamespace(_regions={"beam": ["solid"], "liver": ["parenchyma"], "beam, nu 0.3": ["solid"]})
    data.in_order = types.MethodType(ReportData.in_order, data)
    columns = [types.SimpleNamespace(title=title) for title in ("model", "beam [%]", "beam: tool [%]", "liver [%]")]
    made = ReportData._table_in_order(data, types.SimpleNamespace(columns=columns, rows=[["lloyd", "1", "2", "3"]]))
    assert [column.title for column in made.columns] == ["model", "liver [%]", "beam [%]", "beam: tool [%]"]
    assert made.rows == [["lloyd", "3", "1", "2"]]


def test_the_page_begins_with_the_error_of_the_best_springs_in_words(several):
    header = several.find(f".//{XHTML}header")
    with h5py.File(RUNS / "beam" / "beam_bend.h5") as file:
        springs = {name: dict(group.attrs) for name, group in file["comparisons"].items() if not name.startswith("fem_")}
        best = min(springs, key=lambda name: max(springs[name]["relative_l2"], abs(springs[name]["stiffness_at_tool"])))
    said = "".join(header.find(f".//{XHTML}div").itertext())
    error, stiffness = springs[best]["relative_l2"], springs[best]["stiffness_at_tool"]
    assert said.startswith(f"With {best}, the best springs here, points of liver_tumours end {100 * error:.1f} % of their way"), said
    assert f"{100 * abs(stiffness):.1f} % too {'stiff' if stiffness > 0.0 else 'soft'} (the error under the tool). A hand feels a difference from 7 % on" in said
    assert f"so it {'feels' if abs(stiffness) > 0.07 else 'does not feel'} that" in said
    assert "± 0.34 % in position and ± 0.12 % under the tool" in said
    image = next(header.iter(f"{XHTML}img"))
    assert image.get("alt").startswith(f"liver_tumours under beam_bend: error of {best} from 0 to ")
    assert numpy.ptp(pixels_of(image), axis=(0, 1)).min() > 50.0


def test_terms_are_defined_before_bodies_and_once(several):
    header = several.find(f".//{XHTML}header")
    lists = [item for item in header.iter(f"{XHTML}dl") if item.get("class") == "terms"]
    assert len(lists) == 2, "the terms, and the models"
    terms = [item.text for item in lists[0].iter(f"{XHTML}dt")]
    for word in ("Springs", "Reference", "Error in position (L2)", "Tool", "Error under the tool"):
        assert terms.count(word) == 1
    place = [item for item in header.iter()]
    assert place.index(lists[0]) < place.index(next(header.iter(f"{XHTML}h3")))
    with h5py.File(RUNS / "beam" / "beam_bend.h5") as file:
        summaries = {name: group.attrs["summary"].decode() for name, group in file["solutions"].items()}
    models = dict(zip(("".join(item.itertext()).strip() for item in lists[1].iter(f"{XHTML}dt")),
                      (item.text for item in lists[1].iter(f"{XHTML}dd"))))
    assert models == summaries


def test_subtitle_figure_and_table_agree_on_the_reference(several, tmp_path):
    header = several.find(f".//{XHTML}header")
    assert "own error is known: ± 0.34 % of how far a body moves." in next(
        item for item in header.iter(f"{XHTML}p") if item.get("class") == "lead").text
    assert sum("The reference's own error is ± 0.34 % in position and ± 0.12 % under the tool." in text
               for text in sentences(several)) == 4
    words = ["".join(item.itertext()) for item in header.iter("{http://www.w3.org/2000/svg}text")]
    assert words.count("the reference's own error, ± 0.34 %") == 4
    in_position, at_tool = tables(several, "errors")[:2]
    assert in_position[-1][:2] == ["the reference's own error", "± 0.34"] and at_tool[-1][:2] == ["the reference's own error", "± 0.12"]
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path)
    alone = report_of(tmp_path)
    text = "".join(alone.find(f".//{XHTML}header").itertext())
    assert "finite elements, whose own error is not known." in text and "± 0" not in text and "is known" not in text
    assert tables(alone, "errors")[0][-1][:2] == ["the reference's own error", "not known"]


def test_an_error_that_is_known_in_some_results_is_not_called_known():
    def result(own):
        return types.SimpleNamespace(reference="fem", uncertainty=own, reference_error=0.004, label="a", counts=True)
    known, unknown = result({"reference_uncertainty": 0.004}), result(None)
    assert reference.own_error([known]) == 0.004 and numpy.isnan(reference.own_error([known, unknown]))
    said = reference.lead(types.SimpleNamespace(results=[known, unknown], large=[]))
    assert said.endswith("whose own error is known in 1 of 2 results.")


def test_signs_of_the_page_stand_for_those_of_the_program():
    assert with_signs("+- [%]") == "± [%]"


def test_the_camera_looks_at_the_tool(bar):
    points, tetrahedra = bar
    faces = numpy.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6],
                         [1, 3, 5], [3, 7, 5]])  # outward
    body = Body(points, faces, tetrahedra, None)
    for axis in range(3):
        for side in (0.0, 0.01):
            middle = numpy.full(3, 0.005)
            middle[axis] = side
            normal = first_picture.outward(body, first_picture.Tool(middle, 0.004))
            expected = numpy.zeros(3)
            expected[axis] = 1.0 if side else -1.0
            assert numpy.allclose(normal, expected)
            view = surfaces.looking_from(normal, first_picture.TILT)
            assert view.toward @ expected > 0.9 and abs(view.right @ view.up) + abs(view.right @ view.toward) < 1e-12


def test_the_picture_is_of_the_load_case_under_which_springs_are_farthest_off():
    def result(name, stiffness, error, counts=True):
        model = types.SimpleNamespace(stiffness=stiffness, error=error)
        return types.SimpleNamespace(load_case=name, counts=counts, reference="fem", models={"fem": None, "springs": model})
    cases = [result("soft", -0.06, 0.01), result("stiff", 0.05, 0.02), result("gravity", numpy.nan, 0.3), result("left", 0.4, 0.4, False)]
    assert first_picture.farthest_case(cases, "springs").load_case == "soft"
    assert first_picture.farthest_case(cases[2:], "springs").load_case == "gravity"
    assert first_picture.farthest_case(cases, "other") is None


BODY = """
[regions.parenchyma]
source = "measured +- 1 kPa"
[image]
name = "seg.nrrd"
[image.volumes]
parenchyma = {volume}
[image.mesh]
tetrahedra = {tetrahedra}
nodes = {nodes}
surface_from_voxels = {{ median = 0.00023, percentile_95 = 0.00067, worst = 0.00153 }}
"""


@pytest.fixture
def scanned(tmp_path):
    """The folder of a body that was made of an image, and the values for its .toml."""
    (tmp_path / "seg").mkdir()
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path / "seg")
    path = tmp_path / "seg" / "beam_bend.h5"
    regions_named(path, "seg", [b"parenchyma"])
    with h5py.File(path, "r+") as file:
        file["mesh"].attrs["assumptions"] = numpy.array([(patient.MADE_OF + "seg.nrrd with voxels of 1 x 1 x 2 mm").encode()])
        file["mesh/boundary_patch"].attrs["confidence"] = 0.876
        corners = file["mesh/points"][:][file["mesh/tetrahedra"][:]]
        volume = numpy.abs(numpy.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 6.0
        counts = {"tetrahedra": len(corners), "nodes": len(file["mesh/points"]), "volume": volume / 1.01}
    return tmp_path, counts


def test_a_patient_has_orientation_distance_volumes_and_assumptions_on_top(scanned):
    folder, counts = scanned
    (folder / "seg.toml").write_text(BODY.format(**counts))
    report = report_of(folder)
    said = sentences(report)
    for expected in ("with a confidence of 0.88 from 0 to 1", "0.23 mm in the median, 0.67 mm at 95 %, 1.53 mm at most",
                     "Material of parenchyma: measured ± 1 kPa.", "Held: x_min under beam_bend.", "Left out of the body: capsule, vessels as lines, map of stiffness.",
                     "made of the segmentation seg.nrrd with voxels of 1 x 1 x 2 mm"):
        assert any(expected in sentence for sentence in said), (expected, said)
    row = next(texts(row) for row in report.find(f".//{XHTML}header").iter(f"{XHTML}tr") if texts(row)[0] == "parenchyma")
    millilitres = 1e6 * counts["volume"]
    assert row[1:4] == [f"{1.01 * millilitres:.2f}", f"{millilitres:.2f}", "1.0"]


@pytest.mark.parametrize("change", [{"nodes": 7}, {"tetrahedra": '"many"'}, {"volume": "oops"}, None])
def test_the_file_of_another_body_or_none_gives_no_distance(scanned, change):
    folder, counts = scanned
    if change:
        (folder / "seg.toml").write_text(BODY.format(**{**counts, **change}))
    said = sentences(report_of(folder))
    assert any("its distance from that of the voxels is not known here" in sentence for sentence in said)
    assert not any(re.search(r"mm in the median", sentence) for sentence in said)


def test_a_body_that_ships_is_no_patient(several):
    assert not any("Orientation" in sentence for sentence in sentences(several))
