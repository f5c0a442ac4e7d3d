"""Ranges, indices, files and tables of a sensitivity study, and its command."""
import dataclasses
import math
import pathlib
import subprocess
import tomllib

import h5py
import numpy
import pytest
from conftest import BINARY
from livermark.errors import InputError
from livermark.studies.sensitivity import __main__ as study
from livermark.studies.sensitivity import record, tables
from livermark.studies.sensitivity.ranges import Parameter, Ranges, acting_on, read_ranges
from sample_sensitivity import sample_sensitivity

RESULTS = pathlib.Path(__file__).resolve().parents[2] / "results"
FACTS = {"body": "block", "load_case": "press", "has_tumour": True, "has_map": False, "has_acceleration": False, "is_held": True,
         "has_movable_tool": True}


# --- ranges

def ranges_of(folder, text):
    (folder / "ranges.toml").write_text(text)
    return read_ranges(folder / "ranges.toml")


def test_ranges_say_what_is_not_known(tmp_path):
    ranges = ranges_of(tmp_path, '[young_modulus]\nfrom = 4000\nto = 6000\nsource = "a"\n[tool_offset]\nfrom = -0.01\nto = 0.01\n'
                                 'source = "b"\n[measurement]\ndisplacement = 0.001\nsource = "c"\n')
    assert [parameter.name for parameter in ranges.parameters] == ["young_modulus", "tool_offset_1", "tool_offset_2"]
    assert ranges.parameters[0] == Parameter("young_modulus", "Pa", "parameters", 4000.0, 6000.0, False, "a")
    assert ranges.displacement_noise == 0.001


@pytest.mark.parametrize("text, parts", [
    ('[measurement]\ndisplacement = 0.001\nsource = "a"\n', ["no range", "young_modulus"]),
    ('[poisson_ratio]\nfrom = 0.4\nto = 0.5\nsource = "a"\n', ["toml:1: ", "poisson_ratio", "0.5"]),
    ('[held_share]\nfrom = 0.4\nto = 1.1\nsource = "a"\n', ["held_share", "1.1"]),
    ('\n[density]\nfrom = 1000\nto = 900\nsource = "a"\n', ["toml:2: ", "density", "larger"]),
    ("[density]\nfrom = 1000\nto = 1100\n", ["source", "missing"]),
    ('[density]\nfrom = 1000\nto = "1100"\nsource = "a"\n', ["toml:3: ", "'to' has to be a finite number"]),
    ('[youngs_modulus]\nfrom = 1000\nto = 1100\nsource = "a"\n', ["toml:1: ", "did you mean 'young_modulus'?"]),
    ('[density]\nfrom = 1000\nto = 1100\nscale = "log"\nsource = "a"\n', ["toml:4: ", '"logarithmic"']),
    ('[tool_offset]\nfrom = -1\nto = 1\nscale = "logarithmic"\nsource = "a"\n', ["logarithm"]),
    ('[shear_left]\nfrom = 0.0\nto = 1.0\nsource = "a"\n', ["shear_left", "above 0"]),
    ('others_from = 3\n', ["toml:1: ", "string in quotes"]),
    ('others_from = "ranges.toml"\n', ["toml:1: ", "cannot have 'others_from' itself"]),
    ('others_from = "missing.toml"\n[density]\nfrom = 1\nto = 2\nsource = "a"\n', ["missing.toml", "check the path"]),
    ("[density\n", ["not TOML"]),
    ("density = 3\n", ["has to be a table"])])
def test_ranges_refuse_what_cannot_be(tmp_path, text, parts):
    with pytest.raises(InputError) as refused:
        ranges_of(tmp_path, text)
    assert all(part in str(refused.value) for part in [*parts, str(tmp_path)]), refused.value


def test_ranges_that_a_file_leaves_out_are_those_of_the_file_that_it_names(tmp_path):
    (tmp_path / "all.toml").write_text('[young_modulus]\nfrom = 1\nto = 2\nsource = "a"\n[tool_offset]\nfrom = -1\nto = 1\n'
                                       'source = "b"\n[measurement]\ndisplacement = 0.001\nsource = "c"\n')
    ranges = ranges_of(tmp_path, 'others_from = "all.toml"\n[young_modulus]\nfrom = 3\nto = 4\nsource = "d"\n'
                                 '[shear_left]\nfrom = 0.4\nto = 1.0\nsource = "e"\n')
    assert [(each.name, each.lower) for each in ranges.parameters] == [("young_modulus", 3.0), ("shear_left", 0.4),
                                                                       ("tool_offset_1", -1.0), ("tool_offset_2", -1.0)]
    assert ranges.displacement_noise == 0.001
    noisy = ranges_of(tmp_path, 'others_from = "all.toml"\n[measurement]\ndisplacement = 0.002\nsource = "f"\n')
    assert len(noisy.parameters) == 3 and noisy.displacement_noise == 0.002


def test_ranges_that_ship_differ_in_what_they_are_named_after():
    by_name = {each.name: each for each in read_ranges(RESULTS / "parameter_ranges.toml").parameters}
    indented = {each.name: each for each in read_ranges(RESULTS / "parameter_ranges_indentation.toml").parameters}
    assert indented.keys() == by_name.keys()
    assert [name for name in by_name if indented[name] != by_name[name]] == ["young_modulus"]
    assert indented["young_modulus"].lower > by_name["young_modulus"].upper, "the methods do not agree"
    relaxing = read_ranges(RESULTS / "parameter_ranges_relaxing.toml").parameters
    assert [each for each in relaxing if each.name != "shear_left"] == list(by_name.values())
    series = tomllib.loads((RESULTS.parent / "load_cases" / "relaxation" / "liver_perfused.toml").read_text())
    left = next(each for each in relaxing if each.name == "shear_left")
    assert left.lower == pytest.approx(1.0 - sum(series["moduli"])) and left.upper == 1.0
    mapped = {each.name: each for each in read_ranges(RESULTS / "parameter_ranges_map.toml").parameters}
    assert [name for name in mapped if mapped[name] != by_name.get(name)] == ["young_modulus", "map_contrast", "map_slope"]
    repeated = 0.19 / (1.96 * math.sqrt(2.0)) * math.sqrt(3.0)  # ends of 5 kPa, of which 19 % is a change that is real
    assert [mapped["young_modulus"].lower, mapped["young_modulus"].upper] == pytest.approx(
        [5000.0 * (1.0 - repeated), 5000.0 * (1.0 + repeated)], abs=10.0)
    covered = read_ranges(RESULTS / "parameter_ranges_capsule.toml").parameters
    assert [each for each in covered if each.name != "capsule_stiffness"] == list(by_name.values())
    stiffness = next(each for each in covered if each.name == "capsule_stiffness")
    assert [stiffness.lower, stiffness.upper] == pytest.approx(  # as ends of other ranges: sqrt(3) standard deviations
        [20e-6 * (8.22e6 + sign * math.sqrt(3.0) * 3.42e6) for sign in (-1, 1)], abs=0.5)


def test_parameters_without_effect_are_left_out_with_the_reason():
    ranges = Ranges([Parameter(name, "", "parameters", 1.0, 2.0, False, "made up") for name in
                     ("young_modulus", "density", "tumour_contrast", "tool_offset_1", "tool_offset_2")], None)
    acting, notes = acting_on(FACTS, ranges)
    assert len(notes) == 1 and "density" in notes[0] and len(acting) == 4
    acting, notes = acting_on({**FACTS, "has_acceleration": True, "has_movable_tool": False}, ranges)
    assert len(notes) == 1 and "tool_offset is not" in notes[0] and len(acting) == 3
    with pytest.raises(InputError, match="no parameter that has a range acts"):
        acting_on(FACTS, Ranges(ranges.parameters[1:2], None))


def test_a_parameter_is_between_its_ends_on_its_scale():
    young_modulus, _, support = sample_sensitivity().parameters
    assert young_modulus.at(0.0) == 4000.0 and young_modulus.at(0.25) == 4500.0
    assert support.at(0.5) == pytest.approx(1e6, abs=1e-6) and support.at(1.0) == pytest.approx(1e7, abs=1e-5)


# --- indices

def sobol():
    return pytest.importorskip("livermark.studies.sensitivity.sobol", reason="install python3-openturns")


def ishigami(unit):
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1 on [-pi, pi]^3.
    (T. Ishigami and T. Homma 1990, An importance quantification technique in uncertainty analysis for computer models)"""
    x = numpy.pi * (2.0 * unit.T - 1.0)
    return numpy.sin(x[0]) + 7.0 * numpy.sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * numpy.sin(x[0])


def test_indices_of_ishigamis_function_are_the_exact_ones():
    points = sobol().sobol_points(512, 3)
    found = sobol().sobol_indices(points, ishigami(points), [[0, 2], [1]])
    assert found["first"] == pytest.approx([0.3139, 0.4424, 0.0], abs=2e-4)
    assert found["total"] == pytest.approx([0.5576, 0.4424, 0.2437], abs=2e-4)
    assert found["group_total"] == pytest.approx([0.5576, 0.4424], abs=2e-4)
    assert found["unexplained"] < 1e-6


def test_with_few_samples_the_exact_indices_are_in_their_intervals():
    points = sobol().sobol_points(256, 3)
    found = sobol().sobol_indices(points, ishigami(points), [[0]])
    for name, exact in (("first", [0.31390, 0.44241, 0.0]), ("total", [0.55759, 0.44241, 0.24368])):
        assert (numpy.array(found[name + "_lower"]) <= exact).all() and (numpy.array(found[name + "_upper"]) >= exact).all()
    assert (numpy.subtract(found["total_upper"], found["total_lower"]) < 0.01).all()


def test_the_index_of_a_linear_function_is_the_part_of_its_square():
    """Of y = 1 + sum a_p u_p it is a_p^2 / sum a^2, first-order and total."""
    slope = numpy.array([2.0, -3.0, 0.5, 0.0])
    points = sobol().sobol_points(32, len(slope))
    found = sobol().sobol_indices(points, 1.0 + points @ slope, [[0, 3]])
    for name in ("first", "total"):
        assert found[name] == pytest.approx(slope ** 2 / 13.25, abs=1e-10)
    assert found["group_total"] == pytest.approx([4.0 / 13.25], abs=1e-10)
    assert sobol().sobol_indices(points, numpy.full(32, 5.0), [[0, 3]])["total"] == [0.0] * 4


def test_what_a_polynomial_does_not_explain_is_said():
    points = sobol().sobol_points(64, 2)
    found = sobol().sobol_indices(points, numpy.sin(1e4 * points[:, 0]) + points[:, 1], [[0]])
    assert found["unexplained"] > 0.3
    assert (numpy.array(found["total"]) >= found["first"]).all()


def test_more_points_begin_with_the_same_ones():
    assert (sobol().sobol_points(8, 3)[:5] == sobol().sobol_points(5, 3)).all()


# --- what a record is made of

def test_errors_are_signed_but_that_of_the_tumour_is_a_length():
    names = ["stiffness_at_tool", "peak_displacement", "tumour_displacement"]
    reference = {"values": [100.0, 0.01, 0.005], "tumour": [0.0, 0.003, -0.004]}
    other = {"values": [110.0, 0.009, 0.004], "tumour": [0.0, 0.0024, -0.0032]}
    assert study.relative_differences(names, other, reference) == pytest.approx([0.1, -0.1, 0.2], abs=1e-12)


def test_samples_without_a_solution_are_left_out_and_too_few_are_refused():
    sobol()
    found = dataclasses.replace(sample_sensitivity(), outputs=[])
    unit_points = numpy.random.default_rng(1).random((40, 3))
    found.values = [[2.0 + u, 1.0 - v] for u, v, _ in unit_points.tolist()]
    found.values[3] = [math.nan, 0.5]
    notes = study.add_indices(found, ["stiffness_at_tool", "peak_displacement"], unit_points.tolist())
    assert notes == ["jelly / spoon: 1 of 40 samples have no solution by elements and are left out"]
    kept = numpy.delete(unit_points[:, 0], 3) + 2.0
    output = found.outputs[0]
    assert output.mean == pytest.approx(kept.mean(), rel=1e-14) and output.deviation == pytest.approx(kept.std(ddof=1), rel=1e-14)
    assert output.first == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    found.values = [[math.nan, math.nan]] * 33 + found.values[33:]
    with pytest.raises(InputError, match="7 samples only, which are too few"):
        study.add_indices(found, ["stiffness_at_tool", "peak_displacement"], unit_points.tolist())


def test_a_known_parameter_leaves_the_rest_of_the_variance():
    """A variance is a sum of parts: without a parameter of which the first index is 3/4, half the deviation is left."""
    output = sample_sensitivity().outputs[0]
    assert output.relative_deviation() == pytest.approx(0.2, rel=1e-15)
    assert output.relative_deviation(0) == pytest.approx(0.1, rel=1e-15)
    assert output.relative_deviation_of_group(0) == pytest.approx(0.2 * math.sqrt(0.9), rel=1e-15)


# --- files

def same(a, b):
    return numpy.array_equal(a, b, equal_nan=True)


def test_a_file_keeps_all_that_was_written(tmp_path):
    written = sample_sensitivity()
    record.write(tmp_path / "a.h5", written)
    found = record.read(tmp_path / "a.h5")
    assert dataclasses.replace(found, budget=written.budget) == written
    assert found.budget.reference == "elements_refined" and found.budget.models == {"springs": [0.04, -0.05]}
    assert all(same(getattr(found.budget, name), getattr(written.budget, name)) for name in ("mesh", "law", "measurement"))


def test_a_file_keeps_samples_before_there_are_indices(tmp_path):
    written = dataclasses.replace(sample_sensitivity(), outputs=[])
    del written.values[3:]
    record.write(tmp_path / "a.h5", written)
    found = record.read(tmp_path / "a.h5")
    assert found.values == written.values and found.points == written.points[:3] and not found.outputs


def test_a_file_of_another_kind_or_with_more_outputs_than_values_is_refused(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_group("sensitivity")
    with pytest.raises(InputError, match="a.h5.*schema_version"):
        record.read(tmp_path / "a.h5")
    written = sample_sensitivity()
    written.values = [values[:1] for values in written.values]
    record.write(tmp_path / "b.h5", written)
    with pytest.raises(InputError, match="b.h5.*/sensitivity/outputs"):
        record.read(tmp_path / "b.h5")


# --- tables

def test_tables_have_a_cell_for_each_column():
    found = sample_sensitivity()
    for table in (tables.output_table(found), tables.index_table(found), tables.budget_table(found)):
        assert all(len(row) == len(table.columns) for row in table.rows)
    assert tables.budget_table(found).rows[0] == ["spoon", "stiffness_at_tool", "0.2", "+4.0", "-3.5", "-", "19.0", "7.7", "20.0",
                                                  "10.0 (young_modulus)"]
    assert tables.index_table(found).rows[2][1] == "100000 to 1e+07 Pa/m, logarithmic"


def test_the_verdict_weighs_the_error_against_the_patient():
    found = sample_sensitivity()
    assert tables.verdict(found, 0) == (
        "jelly / spoon: not knowing the patient makes 20.0 % of the stiffness at the tool uncertain, and 10.0 % if young_modulus "
        "were known; springs is off by 4.0 %, which is small beside the first and of the same size beside the second. With the "
        "error bar of the mesh and another law it is off by 7.7 % at most.")
    assert tables.verdict(found, 1).endswith("With the error bar of the mesh it is off by 5.3 % at most.")
    found.budget.models["springs"] = [0.7, math.nan]
    assert "is off by 70.0 %, which is large beside both." in tables.verdict(found, 0)
    assert tables.verdict(found, 1).endswith("springs has no answer to compare.")


def test_errors_with_a_sign_are_added_and_not_squared():
    """-4 % of springs, an error bar of 0.2 % and a law that may be 3.5 % off either way: at most 7.7 %, where the root of the
    sum of squares is 5.3 %. What is not known is left out."""
    found = sample_sensitivity()
    found.budget.models["springs"] = [-0.04, -0.05]
    assert tables.largest_error(found, 0, "springs") == pytest.approx(0.077, rel=1e-12)
    assert tables.largest_error(found, 1, "springs") == pytest.approx(0.053, rel=1e-12)
    found.budget.mesh[1] = math.nan
    assert tables.largest_error(found, 1, "springs") == 0.05 and "at most" not in tables.verdict(found, 1)


# --- the report

def report(folder):
    return subprocess.run([BINARY, "report", str(folder)], capture_output=True, text=True)


def test_a_report_sets_models_beside_what_nobody_knows_of_the_patient(tmp_path):
    found = sample_sensitivity()
    found.budget.models["lattice"] = [-0.3, 0.1]
    record.write(tmp_path / "sensitivity.spoon.h5", found)
    assert report(tmp_path).returncode == 0
    page = (tmp_path / "report.html").read_text()
    for part in ("jelly: A spoon on a jelly", "The patient makes the stiffness at tool uncertain by 20.0 %; if the young modulus "
                 "were known, 10.0 % would be left. Off by more than that: lattice.", "No model is off by more than that; the worst "
                 "is lattice, with 10.0 %", "5 patients, solved by elements", "patient: support", "0.750 [0.700, 0.800]",
                 "1 of sensitivities"):
        assert part in page, part


def test_a_report_leaves_out_a_study_that_is_not_at_its_end(tmp_path):
    found = dataclasses.replace(sample_sensitivity(), outputs=[])
    found.values.pop()
    record.write(tmp_path / "sensitivity.spoon.h5", found)
    outcome = report(tmp_path)
    assert outcome.returncode == 2
    assert "not all of its patients are solved; `livermark sensitivity jelly` goes on where it was" in outcome.stderr


# --- the command, on a bar that is held at one end and pressed by a round tool on a side

BAR = ('title = "bar"\nmesh = "bar.msh"\n[regions.solid]\ndensity = 1000.0\nyoung_modulus = 5000.0\npoisson_ratio = 0.3\n'
       'source = "made up"\n')
PRESS = ('title = "Press"\n[[condition]]\npatch = "x_min"\ndisplacement = [0.0, 0.0, 0.0]\n[[condition]]\n'
         'disc = { patch = "z_max", radius = 0.012, profile = "round" }\npressure = 20.0\n')


@pytest.fixture
def folder(tmp_path):
    subprocess.run([BINARY, "mesh", "box", "--size", "0.09", "0.03", "0.03", "--edge", "0.012", "-o", str(tmp_path / "bar.msh")],
                   check=True, capture_output=True)
    (tmp_path / "bar.toml").write_text(BAR)
    (tmp_path / "press.toml").write_text(PRESS)
    return tmp_path


def sensitivity(folder, arguments, **environment):
    return subprocess.run(["env", *(f"{name}={value}" for name, value in environment.items()), BINARY, "sensitivity",
                           str(folder / "bar.toml"), "--load-case", str(folder / "press.toml"), "--reference-on-mesh", "--output",
                           str(folder / "runs"), *arguments.split()], capture_output=True, text=True)


def result(folder):
    return record.read(folder / "runs" / "bar" / "sensitivity.press.h5")


def test_the_command_says_what_an_answer_is_worth(folder):
    sobol()
    outcome = sensitivity(folder, "--samples 48 --compare nodal_neo_hookean")
    assert outcome.returncode == 0, outcome.stderr
    for part in ("Sobol indices", "Error budget", "support_stiffness", "density is not varied", "tumour_contrast is not varied",
                 "nodal_neo_hookean is off by", "if support_stiffness were known"):
        assert part in outcome.stdout + outcome.stderr, part
    found = result(folder)
    assert len(found.values) == 48 and len(found.outputs) == 2  # it has no tumour
    stiffness = found.outputs[0]
    assert stiffness.deviation > 0.0 and stiffness.unexplained < 0.3
    # A bar that is held at one end turns on its support, and its own stiffness matters less.
    index = {parameter.name: p for p, parameter in enumerate(found.parameters)}
    assert stiffness.first_lower[index["young_modulus"]] > 0.0
    assert stiffness.first[index["support_stiffness"]] > stiffness.total[index["young_modulus"]]
    assert all(total >= first - 1e-12 for total, first in zip(stiffness.total, stiffness.first))
    assert all(lower <= upper for lower, upper in zip(stiffness.first_lower, stiffness.first_upper))
    assert abs(found.budget.models["nodal_neo_hookean"][0]) > 0.0
    assert found.budget.reference == "fem_p2p1"


def test_the_command_continues_the_samples_of_its_file(folder):
    sobol()
    assert sensitivity(folder, "--samples 16 --model fem_p1 --compare fem_p1").returncode == 0
    few = result(folder)
    more = sensitivity(folder, "--samples 20 --model fem_p1 --compare fem_p1 --json")
    assert more.returncode == 0 and '"samples" : 20' in more.stdout, more.stderr
    assert "sample 16 of 20, kept" in more.stderr and "sample 17 of 20, kept" not in more.stderr
    many = result(folder)
    assert len(many.values) == 20 and many.values[:16] == few.values
    other = sensitivity(folder, "--samples 20 --model fem_p2 --compare fem_p1")
    assert "kept" not in other.stderr, "of another model"


def test_the_command_refuses_in_one_sentence(folder):
    (folder / "modules").mkdir()
    (folder / "modules" / "openturns.py").write_text("raise ModuleNotFoundError(\"No module named 'openturns'\")\n")
    modules = str(pathlib.Path(folder / "modules"))
    outcomes = {"need at least": sensitivity(folder, "--samples 5"), "fem_p9": sensitivity(folder, "--model fem_p9"),
                "apt-get install python3-openturns": sensitivity(folder, "--samples 20", PYTHONPATH=modules),
                "palpation": subprocess.run([BINARY, "sensitivity", str(folder / "bar.toml")], capture_output=True, text=True)}
    for part, outcome in outcomes.items():
        assert outcome.returncode == 2 and part in outcome.stderr and "Traceback" not in outcome.stderr, outcome.stderr
