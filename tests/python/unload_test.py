"""Unloaded shapes are those that gravity moves to the scan; what has none is said, and what is no scan is refused."""
import pathlib
import subprocess

import livermark
import numpy
import pytest
from conftest import BINARY
from livermark.errors import InputError
from livermark.studies import unload
from livermark.studies.scanned_bodies import NoEquilibrium, Scan, connected
from livermark.volumes import tetrahedron_volumes

LENGTH, DENSITY = 0.12, 1060.0  # [m], [kg/m^3]
MODELS = ["fem_p1_neo_hookean", "fem_p2p1_neo_hookean", "nodal_neo_hookean", "edge_neo_hookean", "lloyd"]
HELD = 'title = "Held"\nregime = "large"\n[[condition]]\npatch = "x_min"\ndisplacement = [0.0, 0.0, 0.0]\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Holds the mesh of a box, and load cases on it."""
    made = tmp_path_factory.mktemp("unload")
    subprocess.run([BINARY, "mesh", "box", "--size", str(LENGTH), "0.04", "0.04", "--edge", "0.02", "-o", made / "box.msh"],
                   check=True, capture_output=True)
    (made / "held.toml").write_text(HELD)
    (made / "pull.toml").write_text(HELD + '[[condition]]\npatch = "x_max"\ntraction = [0.0, 0.0, 0.05]\n')
    (made / "touch.toml").write_text(HELD + '[touch]\ndisc = { patch = "z_max", radius = 0.01 }\nradius = 0.01\ndepth = 0.002\n')
    return made


def scan_of(folder, young_modulus, poisson_ratio=0.45, direction=(0.6, 0.0, -0.8), acceleration=9.81, support="held"):
    body = folder / "box.toml"
    body.write_text(f'title = "Box"\nmesh = "box.msh"\n[regions.solid]\ndensity = {DENSITY}\nyoung_modulus = {young_modulus}\n'
                    f"poisson_ratio = {poisson_ratio}\n")
    return Scan(body, folder / f"{support}.toml", direction, folder / "work", acceleration)


@pytest.mark.parametrize("model", MODELS)
def test_unloading_undoes_the_gravity_that_moved_a_known_shape(folder, model):
    rest = scan_of(folder, 20e3)
    loaded = rest.moved(model, rest.points, 1.0)
    rest.write_body(folder / "scan.toml", loaded, "Scan")
    scan = Scan(folder / "scan.toml", folder / "held.toml", (0.6, 0.0, -0.8), folder / "work")
    assert numpy.array_equal(scan.points, loaded) and numpy.array_equal(scan.tetrahedra, rest.tetrahedra)
    assert numpy.array_equal(scan.problem.boundary_patch, rest.problem.boundary_patch)
    found = unload.unload(scan, model, 1e-12, 1e-9)
    assert abs(loaded - rest.points).max() > 0.1 * LENGTH
    assert found.sentence == "" and abs(found.points - rest.points).max() < 1e-6 * LENGTH


def test_a_hanging_bar_gets_shorter_by_the_closed_form(folder):
    """Without Poisson's ratio, displacements are rho g (L x - x^2 / 2) / E along the bar."""
    young_modulus = 2e6
    scan = scan_of(folder, young_modulus, 0.0, (1.0, 0.0, 0.0))
    found = unload.unload(scan, "fem_p2_neo_hookean", 1e-9, 1e-12)
    x = scan.points[:, 0] - scan.points[:, 0].min()
    expected = DENSITY * 9.81 / young_modulus * (LENGTH * x - 0.5 * x**2)
    assert abs(scan.points[:, 0] - found.points[:, 0] - expected).max() < 2e-3 * expected.max()
    assert abs(scan.points[:, 1:] - found.points[:, 1:]).max() < 2e-3 * expected.max()


@pytest.mark.parametrize("model", ["lloyd", "fem_p1_neo_hookean"])
def test_a_body_that_cannot_bear_its_weight_has_no_unloaded_shape_which_is_said(folder, capsys, model):
    scan_of(folder, 20.0)
    status = unload.main([str(folder / "box.toml"), "--model", model, "--direction", "0.6,0,-0.8", "--most-solves", "12",
                          "--support", str(folder / "held.toml"), "-o", str(folder / "soft")])
    assert status == 1
    assert f"No unloaded shape by {model} is found at " in capsys.readouterr().out
    assert not list((folder / "soft").glob("*_unloaded_*"))


def test_command_writes_bodies_that_gravity_moves_to_the_scan_and_the_same_table_twice(folder, capsys):
    scan = scan_of(folder, 20e3)
    words = [str(folder / "box.toml"), "--model", "fem_p1_neo_hookean", "lloyd", "--direction", "0.6,0,-0.8", "--support",
             str(folder / "held.toml"), "--load-case", str(folder / "pull.toml"), str(folder / "touch.toml"), "-o", str(folder / "out")]
    assert unload.main(words) == 0
    tables = [capsys.readouterr().out]
    tables.append(subprocess.run([BINARY, "mesh", "unload", *words], check=True, capture_output=True, text=True).stdout)
    assert tables[0] == tables[1] == (folder / "out" / "table.md").read_text()
    assert "touch has a ball or plate, which starts at the body at rest" in tables[0]
    subprocess.run([BINARY, "run", "--reference-on-mesh", "--body", folder / "out" / "box_unloaded_lloyd.toml", "--load-case",
                    folder / "out" / "gravity.toml", "--model", "lloyd", "--output", folder / "runs"], check=True, capture_output=True)
    again = Scan(folder / "out" / "box_unloaded_lloyd.toml", folder / "held.toml", (0.6, 0.0, -0.8), folder / "work")
    assert abs(again.moved("lloyd", again.points, 1.0) - scan.points).max() < 2e-3 * abs(again.points - scan.points).max()
    assert again.problem.patch_names == scan.problem.patch_names and again.problem.region_names == scan.problem.region_names


@pytest.mark.parametrize("along, sign", [(1.0, -1.0), (-1.0, 1.0)])
def test_ignoring_gravity_makes_a_hanging_bar_too_soft_and_a_standing_one_too_stiff(folder, along, sign):
    scan = scan_of(folder, 20e3, 0.3, (along, 0.0, 0.0))
    found = [unload.unload(scan, "fem_p1_neo_hookean", 1e-9, 1e-10)]
    table, left_out = unload.cost_table(scan, found, [str(folder / "pull.toml")], lambda line: None)
    error, l2 = (float(cell) for cell in table.rows[0][4:6])
    assert not left_out and sign * error > 2.0
    found = [unload.unload(scan, "fem_p1_neo_hookean", 2e-2)]  # the gap that is left is no displacement by the tool
    table, _ = unload.cost_table(scan, found, [str(folder / "pull.toml")], lambda line: None)
    assert found[0].gap > 1e-6 and [float(cell) for cell in table.rows[0][4:6]] == pytest.approx([error, l2], abs=1.0)
    weak = scan_of(folder, 20e3, 0.3, (along, 0.0, 0.0), 1e-3)
    found = [unload.unload(weak, "fem_p1_neo_hookean", 1e-9, 1e-12)]
    table, _ = unload.cost_table(weak, found, [str(folder / "pull.toml")], lambda line: None)
    assert abs(float(table.rows[0][4])) < 0.1 and float(table.rows[0][5]) < 0.1


def test_vessels_move_with_the_body_and_come_back_with_the_shape_at_rest(folder):
    scan_of(folder, 20e3)
    body = folder / "with_vessels.toml"
    (folder / "tree.swc").write_text("1 0 2 20 20 4 -1\n2 0 50 22 23 3 1\n3 0 51 29 28 2 2\n4 0 49 11 24 2 2\n")
    body.write_text((folder / "box.toml").read_text() + '[vessels]\nfile = "tree.swc"\nunit = "mm"\n')
    rest = Scan(body, folder / "held.toml", (0.6, 0.0, -0.8), folder / "work")
    stretch = numpy.array([[1.1, 0.1, 0.0], [0.0, 0.9, 0.0], [0.0, -0.2, 1.0]])
    rest.write_body(folder / "even.toml", rest.points @ stretch.T, "Even")
    even = Scan(folder / "even.toml", folder / "held.toml", (0.6, 0.0, -0.8), folder / "work")
    (points, radius, segments), (moved, same_radius, same_segments) = rest.problem.vessels, even.problem.vessels
    assert points[1] == pytest.approx([0.05, 0.022, 0.023]) and numpy.array_equal(segments, [[0, 1], [1, 2], [1, 3]])
    assert moved == pytest.approx(points @ stretch.T, abs=1e-9)
    assert numpy.array_equal(radius, same_radius) and numpy.array_equal(segments, same_segments)
    loaded = rest.moved("nodal_neo_hookean", rest.points, 1.0)
    rest.write_body(folder / "scan.toml", loaded, "Scan")
    scan = Scan(folder / "scan.toml", folder / "held.toml", (0.6, 0.0, -0.8), folder / "work")
    found = unload.unload(scan, "nodal_neo_hookean", 1e-12, 1e-8)
    assert found.sentence == "" and abs(found.points - rest.points).max() < 1e-5 * LENGTH
    plain = scan_of(folder, 20e3)
    assert abs(plain.moved("nodal_neo_hookean", plain.points, 1.0) - loaded).max() > 1e-2 * LENGTH


@pytest.mark.parametrize("position, direction, said", [
    ("HFS", (0, 1, 0), ""), ("FFP", (0, -1, 0), ""), ("HFDL", (1, 0, 0), ""), ("FFDR", (-1, 0, 0), ""),
    ("", (0, 1, 0), "does not say how the patient lay"), ("SITTING", (0, 1, 0), "says SITTING, which is not understood")])
def test_gravity_is_where_the_header_of_the_scan_says_the_patient_lay(tmp_path, position, direction, said):
    body = tmp_path / "patient.toml"
    body.write_text(f'[image]\npatient_position = "{position}"\n' if position else "[image]\n")
    lines = []
    assert unload.direction_of(unload.lying(str(body), lines.append)) == direction
    assert said in "".join(lines) and bool(lines) == bool(said)


def test_tools_have_the_resultant_of_the_load_case(folder):
    scan = scan_of(folder, 20e3)
    tool = scan.tool_of(str(folder / "pull.toml"))
    assert len(tool.forces) == 1 and tool.forces[0] == pytest.approx([0.0, 0.0, 0.05 * 0.04**2], rel=1e-9)
    with pytest.raises(NoEquilibrium, match="ball or plate"):
        scan.tool_of(str(folder / "touch.toml"))
    with pytest.raises(NoEquilibrium, match="has no tool"):
        scan.tool_of(str(folder / "held.toml"))
    triangles = numpy.array([[0, 1, 2], [5, 6, 7], [2, 3, 4], [7, 8, 9]])
    on_springs = HELD + '[foundation]\npatches = ["x_max", "z_max"]\nstiffness = 1e5\n'
    (folder / "springs.toml").write_text(on_springs)
    scan = scan_of(folder, 20e3, support="springs")  # the tool takes all of x_max, which stays on its springs
    moved = [each.moved("fem_p1_neo_hookean", each.points, 0.0, tool) - each.points for each in (scan_of(folder, 20e3), scan)]
    softly, firmly = (tool.displacement(scan.triangles, field, scan.points) for field in moved)
    assert 0.0 < 10.0 * firmly < softly
    assert connected(triangles).tolist() == [0, 1, 0, 1]


def test_supine_is_posterior_in_the_axes_of_the_patient_on_a_liver_that_lies_otherwise(tmp_path):
    straight = Scan("liver_healthy", "large_tilt", unload.direction_of("supine"), tmp_path)
    assert straight.axes == pytest.approx(numpy.eye(3), abs=1e-9)
    turned = numpy.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # rows: left, posterior, superior
    straight.axes = turned
    straight.write_body(tmp_path / "turned.toml", straight.points @ turned, "Turned")
    scan = Scan(tmp_path / "turned.toml", "large_tilt", unload.direction_of("supine"), tmp_path)
    mass = tetrahedron_volumes(scan.points, scan.tetrahedra) @ scan.problem.density
    assert scan.problem.region_names == straight.problem.region_names and scan.axes == pytest.approx(turned, abs=1e-9)
    with_gravity = livermark.problem(tmp_path / "turned.toml", tmp_path / "gravity.toml")
    assert with_gravity.dead_forces.sum(axis=0) / mass == pytest.approx([-9.81, 0.0, 0.0], abs=1e-6)


def test_the_support_that_ships_bears_a_liver_on_its_foundation(tmp_path):
    support = pathlib.Path(__file__).resolve().parents[2] / "examples" / "load_cases" / "supine.toml"
    scan = Scan("liver_healthy", support, unload.direction_of("supine"), tmp_path)
    moved = scan.moved("fem_p1_neo_hookean", scan.points, 0.1) - scan.points
    held = scan.problem.fixed.any(axis=1)
    assert held.any() and not moved[held].any() and 1e-4 < numpy.linalg.norm(moved, axis=1).max() < 5e-3
    assert "foundation" in (tmp_path / "gravity.toml").read_text()
    pulled = scan.tool_of("traction").facets[0]  # without facets beside the patch whose corners are all on its rim
    assert numpy.array_equal(pulled, numpy.flatnonzero(scan.problem.boundary_patch == scan.problem.patch_names.index("left_lobe_tip")))


@pytest.mark.parametrize("words, sentence", [
    (["--direction", "upwards"], "livermark: --direction upwards: give one of supine, prone, "),
    (["--direction", "0,0,0"], "livermark: --direction 0,0,0: give one of "),
    (["--tolerance", "2"], "livermark: --tolerance is between 0 and 1"),
    (["--support", "indentation_of_nothing"], "indentation_of_nothing.toml"),
    (["--model", "loyd"], "livermark: there is no model 'loyd'")])
def test_wrong_input_is_refused_with_a_sentence_and_exit_status_2(folder, capsys, words, sentence):
    scan_of(folder, 20e3)
    given = {"--support": str(folder / "held.toml"), "--model": "lloyd", words[0]: words[1]}
    arguments = [str(folder / "box.toml"), "-o", str(folder / "refused"), *(word for pair in given.items() for word in pair)]
    assert unload.main(arguments) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("condition, sentence", [
    ('[[condition]]\npatch = "x_max"\ntraction = [1.0, 0.0, 0.0]\n', "nothing is held"),
    ('[[condition]]\npatch = "x_max"\ndisplacement = [0.001, 0.0, 0.0]\n', "does not move"),
    ('[[condition]]\ndisc = { patch = "x_max", radius = 0.01 }\ndisplacement = [0.0, 0.0, 0.0]\n', "on whole patches")])
def test_supports_that_cannot_bear_a_scan_are_refused(folder, condition, sentence):
    (folder / "odd.toml").write_text('title = "Odd"\nregime = "large"\n' + condition)
    with pytest.raises(InputError, match=sentence):
        scan_of(folder, 20e3, support="odd")
