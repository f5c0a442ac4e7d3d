"""Jobs of FEBio and scenes of SOFA of a moving load case say what the exported scene says, in the words that these programs
know. Neither of them runs here."""
import subprocess
import sys
import xml.etree.ElementTree

import h5py
import livermark
import numpy
import pytest
from conftest import BINARY

# What the sources of FEBio 4 (of its development in August 2026) read in each element; a type is of the class it makes.
FEBIO = {
    "febio_spec": {"Module", "Material", "Mesh", "MeshDomains", "Boundary", "Loads", "Step", "LoadData", "Output"},
    "Module": set(), "Material": {"material"}, "material": {"density", "E", "v"},
    "Mesh": {"Nodes", "Elements", "NodeSet"}, "Nodes": {"node"}, "Elements": {"elem"}, "MeshDomains": {"SolidDomain"},
    "Boundary": {"bc"}, "bc": {"x_dof", "y_dof", "z_dof", "dof", "value"}, "Loads": {"body_load"}, "body_load": {"C"},
    "Step": {"step"}, "step": {"Control", "Boundary"}, "Control": {"analysis", "time_steps", "step_size", "solver", "time_stepper"},
    "time_stepper": {"max_retries", "aggressiveness", "opt_iter", "dtmin", "dtmax"},
    "solver": {"symmetric_stiffness", "dtol", "etol", "qn_method"}, "qn_method": {"max_ups"},
    "LoadData": {"load_controller"}, "load_controller": {"interpolate", "extend", "points"}, "points": {"pt"},
    "Output": {"plotfile", "logfile"}, "plotfile": {"var"}, "logfile": {"node_data"}}
FEBIO_TYPES = {"Module": {"solid"}, "material": {"neo-Hookean"}, "Elements": {"tet4"}, "body_load": {"mass damping"},
               "bc": {"zero displacement", "prescribed displacement"}, "load_controller": {"loadcurve"},
               "solver": {"solid"}, "time_stepper": {"default"}, "qn_method": {"BFGS"}, "plotfile": {"febio"},
               "var": {"displacement", "stress"}}
# Data and links that the sources of SOFA of August 2026 declare, and the plugin that each component is in.
SOFA = {
    "RequiredPlugin": {"pluginName"}, "DefaultAnimationLoop": set(),
    "EulerImplicitSolver": {"rayleighMass", "rayleighStiffness"}, "CGLinearSolver": {"iterations", "tolerance", "threshold"},
    "TetrahedronSetTopologyContainer": {"name", "position", "tetrahedra"},
    "MechanicalObject": {"name", "template", "position", "showObject"}, "DiagonalMass": {"name", "topology", "vertexMass"},
    "FixedProjectiveConstraint": {"indices"},
    "LinearMovementProjectiveConstraint": {"template", "indices", "keyTimes", "movements", "relativeMovements"},
    "TetrahedronHyperelasticityFEMForceField": {"name", "topology", "materialName", "ParameterSet"}}


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """The scene of the liver with tumours, with the job and the scene of SOFA beside it."""
    folder = tmp_path_factory.mktemp("scene")
    printed = subprocess.run([BINARY, "export", "liver_tumours", "press_and_slide", "-o", folder], check=True,
                             capture_output=True, text=True).stdout
    path = folder / "liver_tumours" / "press_and_slide.scene.h5"
    assert printed.splitlines() == [str(path), str(path.with_name("press_and_slide.feb")),
                                    str(path.with_name("press_and_slide.sofa.py"))]
    return path


@pytest.fixture(scope="module")
def scene(exported):
    return livermark.read_tool_scene(exported)


@pytest.fixture(scope="module")
def job(exported):
    return xml.etree.ElementTree.parse(exported.with_name("press_and_slide.feb")).getroot()


def numbers(element):
    return [float(word) for word in element.text.split(",")]


def nodes_of(job, name):
    return numpy.array(numbers(job.find(f"Mesh/NodeSet[@name='{name}']")), int) - 1


def test_scene_is_what_the_file_has(exported, scene):
    with h5py.File(exported) as file:
        assert numpy.array_equal(scene.displacement, file["tool/displacement"][:])
        assert numpy.array_equal(scene.held, file["held"][:])
    assert len(scene.density) > 1 and abs(scene.displacement).max() > 0.015
    assert 0 < scene.last_record_held < len(scene.time) - 1
    assert scene.step == pytest.approx(1.0 / 240.0)


def test_job_has_the_words_of_febio(job):
    assert job.get("version") == "4.0"
    for element in job.iter():
        assert {child.tag for child in element} <= FEBIO.get(element.tag, set()), element.tag
        if element.tag in FEBIO_TYPES:
            assert element.get("type") in FEBIO_TYPES[element.tag], element.tag
    assert [section.tag for section in job] == ["Module", "Material", "Mesh", "MeshDomains", "Boundary", "Loads", "Step",
                                                "LoadData", "Output"]


def test_names_of_the_job_are_there_once_and_resolve(job):
    sets = [entry.get("name") for entry in job.findall("Mesh/NodeSet") + job.findall("Mesh/Nodes")]
    assert len(set(sets)) == len(sets)
    used = [entry.get("node_set") for entry in job.iter() if entry.get("node_set")]
    assert set(used) == set(sets)
    curves = [entry.get("id") for entry in job.findall("LoadData/load_controller")]
    assert curves == [str(k + 1) for k in range(len(curves))]
    assert [entry.get("lc") for entry in job.iter("value")] == curves[:-1]
    assert [entry.get("lc") for entry in job.iter("dtmax")] == 2 * curves[-1:]
    parts = [entry.get("name") for entry in job.findall("Mesh/Elements")]
    assert parts == [entry.get("mat") for entry in job.findall("MeshDomains/SolidDomain")]
    assert parts == [entry.get("name") for entry in job.findall("Material/material")]
    conditions = [entry.get("name") for entry in job.iter("bc")]
    assert len(set(conditions)) == len(conditions)
    for path in ("Mesh/Nodes/node", "Mesh/Elements/elem"):
        found = [entry.get("id") for entry in job.findall(path)]
        assert found == [str(k + 1) for k in range(len(found))]


def test_job_has_the_body_of_the_scene(job, scene):
    assert [numbers(node) for node in job.findall("Mesh/Nodes/node")] == scene.points.tolist()
    assert numpy.array_equal(nodes_of(job, "held"), scene.held)
    assert job.find("Boundary/bc").get("node_set") == "held"
    assert [entry.text for entry in job.find("Boundary/bc")] == ["1", "1", "1"]
    for r, name in enumerate(entry.get("name") for entry in job.findall("Mesh/Elements")):
        elements = [numbers(elem) for elem in job.findall(f"Mesh/Elements[@name='{name}']/elem")]
        assert numpy.array_equal(numpy.array(elements, int) - 1, scene.tetrahedra[scene.region == r])
        material = job.find(f"Material/material[@name='{name}']")
        assert [float(material.find(word).text) for word in ("density", "E", "v")] == [
            scene.density[r], scene.young_modulus[r], scene.poisson_ratio[r]]
    assert float(job.find("Loads/body_load/C").text) == scene.mass_damping


def test_job_takes_the_tool_along_its_way_and_lets_go(job, scene):
    held, free = job.findall("Step/step")
    assert [step.find("Control/analysis").text for step in (held, free)] == ["DYNAMIC", "DYNAMIC"]
    times = [int(step.find("Control/time_steps").text) * float(step.find("Control/step_size").text) for step in (held, free)]
    assert times[0] == pytest.approx(scene.time[scene.last_record_held]) and sum(times) == pytest.approx(scene.time[-1])
    assert free.find("Boundary") is None
    way = numpy.full((scene.last_record_held + 1, len(scene.points), 3), numpy.nan)
    for condition in held.findall("Boundary/bc"):
        value = condition.find("value")
        points = job.findall(f"LoadData/load_controller[@id='{value.get('lc')}']/points/pt")
        table = float(value.text) * numpy.array([numbers(point) for point in points])
        assert numpy.array_equal(table[::4, 0], scene.time[:scene.last_record_held + 1])
        assert numpy.allclose(numpy.diff(table[:, 0]), scene.step) and abs(numpy.diff(table[:, 1], 3)).max() < 2e-5
        node, = nodes_of(job, condition.get("node_set"))
        way[:, node, "xyz".index(condition.find("dof").text)] = table[::4, 1]
    assert numpy.array_equal(way[:, scene.tool_nodes], scene.displacement[:scene.last_record_held + 1])
    assert numpy.isnan(numpy.delete(way, scene.tool_nodes, axis=1)).all()
    steps = job.find("LoadData")[-1].findall("points/pt")  # a step of the program ends at each record
    assert numpy.array_equal([numbers(point) for point in steps], [[time, scene.step] for time in scene.time])


class Node:
    """Records what a scene adds, in place of a node of SOFA."""

    def __init__(self):
        self.objects, self.children = [], []

    def addObject(self, kind, **data):
        assert set(data) <= SOFA[kind], kind
        self.objects.append((kind, data))

    def addChild(self, name):
        self.children.append(Node())
        return self.children[-1]

    def all(self, kind):
        return [data for found, data in self.objects if found == kind]


@pytest.fixture(scope="module")
def sofa(exported):
    path = exported.with_name("press_and_slide.sofa.py")
    scope = {}
    exec(compile(path.read_text(), str(path), "exec"), scope)
    root = Node()
    scope["createScene"](root)
    return root, root.children[0]


def test_scene_of_sofa_has_the_body_of_the_scene(sofa, scene):
    root, body = sofa
    assert root.dt == scene.step
    nodes, = body.all("MechanicalObject")
    assert nodes["position"] == scene.points.tolist()
    topology, = body.all("TetrahedronSetTopologyContainer")
    assert sorted(topology["tetrahedra"]) == sorted(scene.tetrahedra.tolist())
    assert body.all("FixedProjectiveConstraint") == [{"indices": scene.held.tolist()}]
    assert body.all("EulerImplicitSolver")[0]["rayleighMass"] == scene.mass_damping
    springs = livermark.springs(scene.points, scene.tetrahedra, 5000.0, 0.45, density=scene.density[scene.region])
    assert body.all("DiagonalMass")[0]["vertexMass"] == pytest.approx(springs.node_mass.tolist(), rel=1e-12)


def test_scene_of_sofa_has_a_force_field_for_each_region(sofa, scene):
    _, body = sofa
    assert len(body.children) == len(scene.density)
    for r, region in enumerate(body.children):
        topology, = region.all("TetrahedronSetTopologyContainer")
        assert topology["tetrahedra"] == scene.tetrahedra[scene.region == r].tolist()
        field, = region.all("TetrahedronHyperelasticityFEMForceField")
        assert (field["materialName"], field["topology"]) == ("NeoHookean", "@" + topology["name"])
        mu, lame_lambda = field["ParameterSet"]
        assert mu * (3 * lame_lambda + 2 * mu) / (lame_lambda + mu) == pytest.approx(scene.young_modulus[r])
        assert 0.5 * lame_lambda / (lame_lambda + mu) == pytest.approx(scene.poisson_ratio[r])


def test_scene_of_sofa_takes_the_tool_along_its_way_and_lets_go(sofa, scene):
    _, body = sofa
    movements = body.all("LinearMovementProjectiveConstraint")
    held = slice(0, scene.last_record_held + 1)
    assert [movement["indices"] for movement in movements] == [[node] for node in scene.tool_nodes.tolist()]
    for t, movement in enumerate(movements):
        assert movement["keyTimes"] == (scene.time[held] - scene.step).tolist() and movement["relativeMovements"] is True
        assert movement["movements"] == scene.displacement[held, t].tolist()


def test_what_is_no_scene_is_refused(tmp_path):
    path = tmp_path / "other.scene.h5"
    with pytest.raises(livermark.InputError, match="this is no scene"):
        livermark.read_tool_scene(path)
    for name in (str(path), str(tmp_path / "job.feb")):
        program = subprocess.run([sys.executable, "-m", "livermark.convert.scene_files", name], capture_output=True, text=True)
        assert program.returncode == 2 and "livermark export" in program.stderr and "Traceback" not in program.stderr
