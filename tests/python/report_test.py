"""The numbers of a report are those of its files, and a section is made of what files have."""
import base64
import io
import math
import os
import pathlib
import shutil
import subprocess
import xml.etree.ElementTree

import h5py
import numpy
import pytest
from conftest import BINARY, RUNS
from livermark.report.data import not_told_from_best
from PIL import Image

SAMPLES = pathlib.Path(os.environ["LIVERMARK_SAMPLES"])
XHTML = "{http://www.w3.org/1999/xhtml}"
SVG = "{http://www.w3.org/2000/svg}"


def report_of(folder):
    subprocess.run([BINARY, "report", str(folder)], check=True, capture_output=True)
    return xml.etree.ElementTree.fromstring((folder / "report.html").read_text(encoding="utf-8"))


def texts(element):
    return ["".join(cell.itertext()).strip() for cell in element]


def tables(root, name):
    """Rows of the tables of a section, without the titles."""
    section = next(section for section in root.iter(f"{XHTML}section") if section.get("id") == name)
    return [[texts(row) for row in table.iter(f"{XHTML}tr")][1:] for table in section.iter(f"{XHTML}table")]


@pytest.fixture(scope="module")
def beam(tmp_path_factory):
    """The report of a beam that was bent, and one that was let go."""
    folder = tmp_path_factory.mktemp("beam")
    shutil.copytree(RUNS / "beam", folder / "beam")
    return report_of(folder)


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    """The report of a sample of each kind of file."""
    folder = tmp_path_factory.mktemp("sample")
    for name in ("sample_result", "path_result", "sample_stability", "sample_cohort", "sample_arena", "sample_timings"):
        shutil.copy(SAMPLES / f"{name}.h5", folder)
    with h5py.File(folder / "path_result.h5", "r+") as file:
        file["load_case"].attrs["regime"] = numpy.bytes_("large")
        file["reference"].attrs["reaction_uncertainty"] = 0.1
    return report_of(folder)


def comparison(load_case, model):
    with h5py.File(RUNS / "beam" / f"{load_case}.h5") as file:
        group = file.get(f"comparisons/{model}")
        return {} if group is None else dict(group.attrs)


def test_errors_are_those_of_the_files(beam):
    rows = tables(beam, "errors")[0]
    compared = 0
    for model, *cells, mean in rows[:-1]:
        errors = []
        for load_case, cell in zip(("beam_bend", "beam_release"), cells):
            error = comparison(load_case, model).get("relative_l2")
            if error is not None:
                errors.append(error)
                assert cell.removesuffix(" *") == f"{100 * error:.2f}"
        bent = comparison("beam_bend", model).get("relative_l2")  # what is let go starts as another load case ends
        if bent is not None:
            compared += 1
            assert mean == f"{100 * bent:.2f}"
    assert compared >= 8


def test_stiffness_at_the_tool_is_that_of_the_files_with_a_mark_above_7_percent(beam):
    rows = tables(beam, "errors")[1]
    marked = 0
    for model, *cells, _ in rows[:-1]:
        for load_case, cell in zip(("beam_bend", "beam_release"), cells):
            value = comparison(load_case, model).get("stiffness_at_tool")
            if value is not None:
                assert cell == f"{100 * value:+.1f}" + (" !" if abs(value) > 0.07 else "")
                marked += cell.endswith("!")
    assert marked >= 2
    assert rows[-1][0] == "the reference's own error"


def test_the_smallest_error_of_springs_is_strong(beam):
    table = next(beam.iter(f"{XHTML}section")).find(f".//{XHTML}table")
    strong = [(texts(row)[0], column) for row in table.iter(f"{XHTML}tr") for column, cell in enumerate(row)
              if cell.find(f"{XHTML}strong") is not None]
    rows = {row[0]: row[1:] for row in tables(beam, "errors")[0][:-1]}
    springs = [name for name in rows if not name.startswith("fem_")]
    for column in range(3):
        errors = {name: float(rows[name][column].removesuffix(" *")) for name in springs if rows[name][column] != "-"}
        best = {name for name, error in errors.items() if error == min(errors.values())}
        assert {name for name, place in strong if place == column + 1} == best
    assert {place for _, place in strong} == {1, 2, 3}


def test_models_that_differ_by_less_than_the_uncertainty_are_not_ranked(tmp_path):
    assert not_told_from_best({"a": 0.0206, "b": 0.0207, "c": 0.0250}, 0.0039) == ["a", "b"]
    assert not_told_from_best({"b": 0.0207, "a": 0.0206}, 0.0) == ["a"]
    assert not_told_from_best({}, 0.01) == []
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path)
    with h5py.File(tmp_path / "beam_bend.h5", "r+") as file:
        springs = sorted(float(group.attrs["relative_l2"]) for name, group in file["comparisons"].items()
                         if not name.startswith("fem_"))
        reference = next(iter(file["comparisons"].values())).attrs["reference"]
        group = file.create_group("reference")
        group.attrs["model"] = group.attrs["refined_model"] = reference
        group.attrs["reference_uncertainty"] = uncertainty = 0.5 * (springs[2] + springs[3]) - springs[0]
        for name in ("refinement_difference", "order", "energy_uncertainty", "reaction_uncertainty"):
            group.attrs[name] = 1.0
    report = report_of(tmp_path)
    table = next(report.iter(f"{XHTML}section")).find(f".//{XHTML}table")
    strong = [texts(row)[0] for row in table.iter(f"{XHTML}tr") if row[1].find(f"{XHTML}strong") is not None]
    assert len(strong) == sum(error - springs[0] < uncertainty for error in springs) == 3


def test_errors_against_another_reference_are_left_out_with_a_sentence(tmp_path):
    for name in ("beam_bend", "beam_release"):
        shutil.copy(RUNS / "beam" / f"{name}.h5", tmp_path)
    shutil.copy(tmp_path / "beam_bend.h5", tmp_path / "other.h5")
    with h5py.File(tmp_path / "other.h5", "r+") as file:
        for group in file["comparisons"].values():
            group.attrs["reference"] = numpy.bytes_("fem_p2")
    done = subprocess.run([BINARY, "report", str(tmp_path)], capture_output=True, text=True)
    assert done.returncode == 1 and "other.h5: its errors are against fem_p2," in done.stderr, done.stderr
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "Errors are against fem_p2p1, which was solved on the mesh of the models itself" in text
    assert "no table mixes them" in text


def sentences(root):
    """Of the first page."""
    return ["".join(item.itertext()).strip() for item in root.find(f".//{XHTML}header").iter(f"{XHTML}li")]


def test_the_first_page_says_which_springs_are_nearest(beam):
    errors, sizes = ({row[0]: float(row[-1].removesuffix(" !")) for row in tables(beam, "errors")[number][:-1]
                      if not row[0].startswith("fem_") and row[-1] != "-"} for number in (0, 1))
    said = next(sentence for sentence in sentences(beam) if sentence.startswith("The most accurate springs"))
    larger = {name: max(sizes[name], errors[name]) for name in sizes.keys() & errors.keys()}
    places = {name: said.find(f"{name} ({sizes[name]:.1f} and {errors[name]:.1f} %)")
              for name in sorted(larger, key=larger.get)[:3]}
    in_order = [larger[name] for name in sorted(places, key=places.get)]
    assert -1 not in places.values() and in_order == sorted(in_order) and "A hand feels 7 %" in said, said
    unfelt = [name for name, size in sizes.items() if size <= 7.0]
    said = next(sentence for sentence in sentences(beam) if "hand could" in sentence)
    assert all(name in said for name in unfelt) and not any(name in said for name in sizes if sizes[name] > 7.5), said
    linear = next(sentence for sentence in sentences(beam) if sentence.startswith("Linear tetrahedra (fem_p1)"))
    assert f"{float({row[0]: row[-1] for row in tables(beam, 'errors')[0]}['fem_p1']):.1f} % off in position" in linear


def test_the_first_page_says_what_the_body_is(beam):
    text = "".join(beam.find(f".//{XHTML}header").itertext())
    with h5py.File(RUNS / "beam" / "beam_bend.h5") as file:
        young, ratio = (file[f"materials/{name}"][0] for name in ("young_modulus", "poisson_ratio"))
        assert f"{len(file['mesh/tetrahedra']):,} tetrahedra" in text
    assert f"Young's modulus of {1e-3 * young:.1f} kPa and a Poisson's ratio of {ratio:g}" in text
    assert beam.find(f".//{XHTML}h1").text == "Livermark report: beam"


def test_the_first_page_says_what_a_body_has_and_stands_on(tmp_path):
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path)
    with h5py.File(tmp_path / "beam_bend.h5", "r+") as file:
        points, triangles = file["mesh/points"][:], file["mesh/boundary_triangles"][:]
        size, num_points = numpy.ptp(points, axis=0), 7
        file.create_group("capsule").attrs.update({"thickness": 2e-5, "young_modulus": 4.1e6})
        vessels = file.create_group("vessels")
        vessels.attrs.update({"wall_ratio": 0.1, "wall_modulus": 6e5})
        vessels["points"] = points.min(axis=0) + size * numpy.linspace((0.1, 0.5, 0.5), (0.9, 0.5, 0.5), num_points)
        vessels["radius"] = numpy.full(num_points, radius := 0.1 * size.min())
        vessels["segments"] = numpy.array([(p, p + 1) for p in range(num_points - 1)])
        file["mesh/modulus_factor"] = numpy.linspace(0.5, 1.5, len(file["mesh/tetrahedra"]))
        moduli = 1e-3 * file["materials/young_modulus"][:][file["mesh/region"][:]] * file["mesh/modulus_factor"][:]
        facets = numpy.flatnonzero(file["load_case/condition"][:] == 0)
        foundation = file["load_case"].create_group("foundation")
        foundation["facet"], foundation["normal_only"] = (values.astype("i4") for values in (facets, numpy.ones(len(facets))))
        foundation["stiffness"] = numpy.full(len(facets), 3e5)
        a, b, c = points[triangles[facets]].swapaxes(0, 1)
        area = 0.5 * numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1).sum()
    report = report_of(tmp_path)
    said, length = sentences(report), 0.8 * size[0]
    for expected in ("a stiffness of 82 N/m, its Young's modulus times its thickness", f"along {num_points - 1} straight segments,",
                     f"{length:.3g} m and {1e6 * math.pi * radius ** 2 * length:.1f} mL together, with radii of {1e3 * radius:.2g} mm",
                     f"from {moduli.min():.1f} to {moduli.max():.1f} kPa",
                     f"under beam_bend 3e+05 N/m^3 on {1e4 * area:.1f} cm^2, along the normal alone"):
        assert any(expected in sentence for sentence in said), (expected, said)
    pictures = next(section for section in report.iter(f"{XHTML}section") if section.get("id") == "pictures")
    first, second = [pixels_of(image) for image in pictures.iter(f"{XHTML}img")][:2]
    assert is_vessel(first).sum() > 500 and is_vessel(second).sum() == 0


def pixels_of(image):
    data = base64.b64decode(image.get("src").partition(",")[2])
    return numpy.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(float)


def is_vessel(pixels):
    """Which pixels are as blue as no colour of a scale."""
    return (pixels[..., 2] > 150.0) & (pixels[..., 0] < 0.5 * pixels[..., 2]) & (pixels[..., 1] < 0.8 * pixels[..., 2])


def test_parts_are_folded_and_empty_ones_are_named_at_the_end(beam, sample):
    for report in (beam, sample):
        for section in report.iter(f"{XHTML}section"):
            assert section.find(f"{XHTML}details") is not None and section.find(f"{XHTML}details").get("open") is None
    ids = [section.get("id") for section in beam.iter(f"{XHTML}section")]
    assert "errors" in ids and "arena" not in ids and "cohort" not in ids
    absent = ["".join(item.itertext()) for item in beam.find(f".//{XHTML}footer").iter(f"{XHTML}li")]
    assert any(line.endswith("livermark arena --output FOLDER") for line in absent), absent


def test_pictures_are_chosen_from_a_list(beam):
    section = next(section for section in beam.iter(f"{XHTML}section") if section.get("id") == "pictures")
    choices = [details for details in section.iter(f"{XHTML}details") if details.get("name") == "pictures"]
    assert len(choices) == 2 and all(choice.get("open") is None for choice in choices)


def test_every_number_is_in_the_table_that_the_program_prints(beam, tmp_path):
    printed = subprocess.run([BINARY, "table", "--kind", "models", "--markdown", str(RUNS / "beam")], check=True,
                             capture_output=True, text=True).stdout
    lines = [[cell.strip() for cell in line.strip("|\n ").split("|")] for line in printed.splitlines()
             if line.startswith("| beam ")]
    assert sorted(tables(beam, "numbers")[0]) == sorted(lines)


def test_timings_are_those_of_the_file(sample):
    rows = {row[0]: row[1:] for row in tables(sample, "timings")[0]}
    with h5py.File(SAMPLES / "sample_timings.h5") as file:
        for name in ("step/newmark/fem_p1/box", "step/newmark/all"):
            attributes, seconds = file[f"timings/{name}"].attrs, file[f"timings/{name}/seconds"][:]
            assert float(rows[name][0]) == pytest.approx(1e6 * numpy.median(seconds))
            assert float(rows[name][1]) == pytest.approx(1e6 * seconds.min())
            assert rows[name][2] == str(len(seconds)) and rows[name][3] == attributes["clock"].decode()
            shown = "-" if "of_limit" not in attributes else f"{100 * attributes['of_limit']:.3g}"
            assert rows[name][6] == shown


def test_limits_of_steps_are_those_of_the_file(sample):
    rows = tables(sample, "steps")[0]
    with h5py.File(SAMPLES / "sample_stability.h5") as file:
        steps = file["critical_time_step"]
        assert [row[0] for row in rows] == [name.decode() for name in steps.attrs["integrators"]]
        for row, predicted in zip(rows, steps["undamped_predicted"][:]):
            if 0.0 < predicted < math.inf:
                assert row[1] == f"{1e3 * predicted:.4f}"
            else:
                assert row[1] == ("any" if predicted > 0.0 else "none")


def test_statistics_of_a_cohort_are_those_of_the_file(sample):
    rows = [row for table in tables(sample, "cohort") for row in table]
    with h5py.File(SAMPLES / "sample_cohort.h5") as file:
        statistics = file["statistics"]
        words = {name: [word.decode() for word in statistics[name].attrs["names"]] for name in ("half", "model")}
        for h, median in enumerate(statistics["median"][:]):
            half, model = (words[name][statistics[name][h]] for name in ("half", "model"))
            row = next(row for row in rows if (row[0], row[2]) == ({"training": "tuning", "unseen": "test"}[half], model))
            assert row[3] == str(statistics["bodies"][h]) and row[4] == str(statistics["left_out"][h])
            assert math.isnan(statistics["median_low"][h]), "an interval of one or two bodies"
            assert row[5] == ("-" if math.isnan(median) else f"{100 * median:.2f}")


def test_errors_of_methods_are_those_of_the_arena(sample):
    overview, details = tables(sample, "arena")
    with h5py.File(SAMPLES / "sample_arena.h5") as file:
        arena = file["arena"]
        for r, method in enumerate(arena.attrs["methods"]):
            row = next(row for row in details if row[2] == method.decode())
            error = arena["contact_error"][r]
            assert row[6] == ("-" if math.isnan(error) else f"{100 * error:.1f}")
            assert row[11] == f"{1e3 * arena['frame_seconds'][r]:.2f}"
            assert row[-1] == arena.attrs["outcomes"][r].decode()
            cell = next(row for row in overview if row[1] == method.decode())[2]
            assert cell == ("diverged" if math.isnan(error) else f"{100 * error:.1f}")


def test_cards_say_what_each_method_is_and_how_it_converges(sample):
    section = next(section for section in sample.iter(f"{XHTML}section") if section.get("id") == "cards")
    cards = {"".join(card.find(f"{XHTML}summary").itertext()).strip(): card
             for card in section.iter(f"{XHTML}details") if card.get("name") == "cards"}
    with h5py.File(SAMPLES / "sample_arena.h5") as file:
        methods, series = file["methods"].attrs, file["series"]
        assert list(cards) == [name.decode() for name in methods["names"]]
        for m, card in enumerate(cards.values()):
            said = "".join(card.itertext())
            assert all(methods[word][m].decode() in said for word in ("sources", "converge_to", "objections"))
        card = cards["springs"]
        rows = [texts(row) for row in list(card.iter(f"{XHTML}table"))[1].iter(f"{XHTML}tr")][1:]
        force = series["pressed_force"][:] / file["arena"].attrs["reference_pressed_force"]
        assert [row[3] for row in rows] == [str(number) for number in series["iterations"]]
        assert [row[7] for row in rows] == [f"{100 * (part - 1):.1f}" for part in force]
    words = {"".join(text.itertext()) for text in card.iter(f"{SVG}text")}
    assert {"Error against iterations", "Stiffness at the tool", "Error against mesh", "Error over time", "Force over time"} <= words
    diverged = {"".join(text.itertext()) for text in cards["blown_up"].iter(f"{SVG}text")}
    assert "Error against iterations" not in diverged, "there is nothing to draw"


def test_a_figure_of_forces_names_every_model(sample):
    with h5py.File(SAMPLES / "path_result.h5") as file:
        models = set(file["solutions"])
    section = next(section for section in sample.iter(f"{XHTML}section") if section.get("id") == "large")
    names = {"".join(text.itertext()) for text in section.iter(f"{SVG}text")}
    assert models <= names
    assert {"way [mm]", "force [N]"} <= names
    assert any("var(--band)" in element.get("style", "") for element in section.iter()), "the reference has no band"


def test_every_section_is_a_target_of_a_link(sample):
    links = [link.get("href") for link in sample.find(f".//{XHTML}nav")]
    assert links == ["#" + section.get("id") for section in sample.iter(f"{XHTML}section")]
    assert len(links) == 12
