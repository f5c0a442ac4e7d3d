"""Jobs of FEBio say what the problem says, in the structure that FEBio 4 reads. FEBio itself does not run here."""
import os
import pathlib
import subprocess
import xml.etree.ElementTree

import h5py
import livermark
import numpy
import pytest

LARGE = pathlib.Path(__file__).with_name("beam_large.toml")
SOURCE = pathlib.Path(__file__).parents[2]
COVERED = SOURCE / "examples" / "bodies" / "liver_with_capsule.toml"
SUPPORTED = SOURCE / "load_cases" / "supported"
# Sections of febio_spec 4.0, in an order in which each refers to what stands before it.
SECTIONS = ["Module", "Control", "Material", "Mesh", "MeshDomains", "MeshData", "Boundary", "Loads", "Contact", "Rigid", "Discrete",
            "LoadData", "Output"]


@pytest.fixture(scope="module")
def large():
    return livermark.problem("beam", LARGE)


def job_of(problem, tmp_path):
    livermark.to_febio(problem, tmp_path / "job.feb")
    job = xml.etree.ElementTree.parse(tmp_path / "job.feb").getroot()
    check_structure(job)
    return job


def numbers(element):
    return [float(word) for word in element.text.split(",")]


def table(elements):
    return numpy.array([numbers(element) for element in elements])


def names(job, path, attribute="name"):
    return [element.get(attribute) for element in job.findall(path)]


def check_structure(job):
    """Names are unique and resolve, numbers count up from 1, and maps have a value for each item of their set."""
    assert job.tag == "febio_spec" and job.get("version") == "4.0"
    sections = [section.tag for section in job]
    assert sections == [name for name in SECTIONS if name in sections]
    num_nodes = len(job.findall("Mesh/Nodes/node"))
    for path in ("Mesh/Nodes/node", "Mesh/Elements/elem", "Mesh/Surface/tri3", "Material/material"):
        assert names(job, path, "id") == [str(k + 1) for k in range(len(job.findall(path)))], path
    sets = {"node_set": names(job, "Mesh/NodeSet") + names(job, "Mesh/Nodes"), "surface": names(job, "Mesh/Surface"),
            "map": names(job, "MeshData/*"), "lc": names(job, "LoadData/load_controller", "id"),
            "discrete_set": names(job, "Mesh/DiscreteSet"), "dmat": names(job, "Discrete/discrete_material", "id"),
            "mat": names(job, "Material/material"), "part": names(job, "Mesh/Elements")}
    for kind, known in sets.items():
        assert len(set(known)) == len(known), kind
    for element in job.iter():
        for kind in ("node_set", "surface", "lc", "mat", "discrete_set", "dmat"):
            assert element.get(kind) is None or element.get(kind) in sets[kind], (element.tag, element.attrib)
        assert element.get("type") != "map" or element.text in sets["map"]
    assert names(job, "MeshDomains/*") == sets["part"]
    for element in job.iter("rb"):
        assert element.text in sets["mat"]
    for element in job.findall("Mesh/SurfacePair/*"):
        assert element.text in sets["surface"]
    assert names(job, "Discrete/discrete", "discrete_set") == names(job, "Mesh/DiscreteSet")
    for path in ("Mesh/Elements/elem", "Mesh/Surface/tri3", "Mesh/NodeSet", "Mesh/DiscreteSet/delem"):
        for element in job.findall(path):
            nodes = numbers(element)
            assert len(set(nodes)) == len(nodes) and 1 <= min(nodes) and max(nodes) <= num_nodes
    sizes = {entry.get("name"): len(numbers(entry)) for entry in job.findall("Mesh/NodeSet")}
    sizes |= {entry.get("name"): len(entry) for entry in job.findall("Mesh/Surface")}
    elements = {entry.get("name"): len(entry) for entry in job.findall("Mesh/Elements")}
    for entry in job.findall("MeshData/*"):
        items = {**sizes, **elements}[entry.get("node_set") or entry.get("surface") or entry.get("elem_set")]
        assert [child.get("lid") for child in entry] == [str(k + 1) for k in range(items)]
        assert table(entry).shape == (items, {"scalar": 1, "vec3": 3}[entry.get("data_type")])
    used = names(job, "Boundary/bc", "node_set") + names(job, "Loads/*", "node_set") + names(job, "Loads/*", "surface")
    used += [element.text for element in job.findall("Mesh/SurfacePair/*")]
    assert set(sizes) == set(used) - {None}


def values_at_nodes(job, data, num_nodes, width):
    """The values of a map as an array over all nodes, zero elsewhere."""
    values = numpy.zeros((num_nodes, width))
    entry = job.find(f"MeshData/NodeData[@name='{data}']")
    if entry is not None:
        nodes = numbers(job.find(f"Mesh/NodeSet[@name='{entry.get('node_set')}']"))
        values[numpy.array(nodes, int) - 1] = table(entry)
    return values


def constraints_of(job, num_nodes):
    """Prescribed displacements (N, 3), NaN where a component is free, as prescribed_displacement of a problem."""
    found = numpy.full((num_nodes, 3), numpy.nan)
    for condition in job.findall("Boundary/bc[@node_set]"):
        nodes = numpy.array(numbers(job.find(f"Mesh/NodeSet[@name='{condition.get('node_set')}']")), int) - 1
        if condition.get("type") == "zero displacement":
            for axis, name in enumerate(("x_dof", "y_dof", "z_dof")):
                if condition.find(name).text == "1":
                    assert numpy.isnan(found[nodes, axis]).all()
                    found[nodes, axis] = 0.0
        else:
            assert condition.get("type") == "prescribed displacement"
            axis = "xyz".index(condition.find("dof").text)
            assert numpy.isnan(found[nodes, axis]).all()
            found[nodes, axis] = values_at_nodes(job, condition.find("value").text, num_nodes, 1)[nodes, 0]
    return found


def test_job_has_the_mesh_and_the_conditions_of_the_problem(large, tmp_path):
    job = job_of(large, tmp_path)
    num_nodes = len(large.points)
    assert numpy.array_equal(table(job.findall("Mesh/Nodes/node")), large.points)
    assert numpy.array_equal(table(job.findall("Mesh/Elements/elem")) - 1, large.tetrahedra)
    sliding = numpy.isnan(large.prescribed_displacement).sum(axis=1) == 2
    assert sliding.any() and numpy.array_equal(constraints_of(job, num_nodes), large.prescribed_displacement, equal_nan=True)
    assert numpy.array_equal(values_at_nodes(job, "dead_forces", num_nodes, 3), large.dead_forces)
    assert job.find("Loads/nodal_load").get("type") == "nodal_force"


def test_follower_pressures_act_on_their_triangles(large, tmp_path):
    job = job_of(large, tmp_path)
    facets = numpy.flatnonzero(large.follower_pressure)
    assert len(facets) > 0 and large.follower_pressure[facets] == pytest.approx(15.0)
    assert numpy.array_equal(table(job.findall("Mesh/Surface/tri3")) - 1, large.boundary_triangles[facets])
    assert numpy.array_equal(table(job.find("MeshData/SurfaceData"))[:, 0], large.follower_pressure[facets])
    load = job.find("Loads/surface_load")
    assert load.get("type") == "pressure" and load.find("linear").text == "0"


def test_follower_pressures_and_dead_forces_make_the_forces_at_rest(large):
    assert large.regime == "large" and livermark.problem("beam", "beam_bend").regime == "small"
    corners = large.points[large.boundary_triangles]
    area_vector = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    forces = large.dead_forces.copy()
    for k in range(3):
        numpy.add.at(forces, large.boundary_triangles[:, k], -large.follower_pressure[:, None] * area_vector / 3.0)
    assert forces == pytest.approx(large.forces, rel=1e-12, abs=1e-18)


def test_material_is_the_one_of_each_region(tmp_path):
    problem = livermark.problem("liver_tumours", "retraction")
    job = job_of(problem, tmp_path)
    assert names(job, "Mesh/Elements") == problem.region_names == names(job, "Material/material")
    assert set(names(job, "Material/material", "type")) == {"neo-Hookean"}
    for number, name in enumerate(problem.region_names):
        of_region = problem.region == number
        elements = table(job.findall(f"Mesh/Elements[@name='{name}']/elem")) - 1
        assert numpy.array_equal(elements, problem.tetrahedra[of_region])
        material = job.find(f"Material/material[@name='{name}']")
        for word, values in (("E", problem.young_modulus), ("v", problem.poisson_ratio), ("density", problem.density)):
            assert set(values[of_region]) == {float(material.find(word).text)}
    assert job.find("Control/time_steps").text == "1"
    assert numpy.array_equal(constraints_of(job, len(problem.points)), problem.prescribed_displacement, equal_nan=True)


def test_what_presses_to_a_depth_is_refused(tmp_path):
    problem = livermark.problem("liver_healthy", "indentation")
    assert 0.0 < problem.press_depth < 0.001 and problem.constraint_names == ["posterior", "indenter"]
    assert numpy.linalg.norm(problem.forces.sum(axis=0)) == pytest.approx(1.0)
    with pytest.raises(livermark.InputError, match="presses to a depth"):
        livermark.to_febio(problem, tmp_path / "job.feb")
    assert not (tmp_path / "job.feb").exists()


@pytest.fixture(scope="module")
def touched():
    return livermark.problem("liver_healthy", "large_palpation")


def test_ball_moves_as_its_load_case_says_and_touches_what_is_near(touched, tmp_path):
    radius, start, press = touched.ball
    assert 0.005 < radius < 0.05 and 0.005 < numpy.linalg.norm(press) < 0.02 and not touched.further_parts
    job = job_of(touched, tmp_path)
    around = table(job.findall("Mesh/Nodes[@name='ball']/node")) - start
    assert numpy.linalg.norm(around, axis=1) == pytest.approx(numpy.full(len(around), radius), rel=1e-12)
    first, surface = len(touched.points) + 1, table(job.findall("Mesh/Surface[@name='on_ball']/tri3")).astype(int)
    corners = around[surface - first]
    outwards = (numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * corners.mean(axis=1)).sum(axis=1)
    assert (outwards > 0.0).all() and numpy.linalg.norm(corners.mean(axis=1), axis=1).min() > 0.998 * radius
    edges = numpy.sort(surface[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    assert (numpy.unique(edges, axis=0, return_counts=True)[1] == 2).all()  # it is closed
    near = table(job.findall("Mesh/Surface[@name='below_ball']/tri3")).astype(int) - 1
    boundary = {tuple(facet) for facet in touched.boundary_triangles.tolist()}
    assert {tuple(facet) for facet in near.tolist()} < boundary and 10 < len(near) < len(boundary) / 2
    closest = numpy.argsort(numpy.linalg.norm(touched.points[touched.boundary_triangles].mean(axis=1) - start - press, axis=1))[:10]
    assert {tuple(touched.boundary_triangles[k]) for k in closest} <= {tuple(facet) for facet in near.tolist()}
    moved = {e.find("dof").text: float(e.find("value").text) for e in job.findall("Rigid/rigid_bc[@type='rigid_displacement']")}
    held = job.find("Rigid/rigid_bc[@type='rigid_fixed']")
    for axis, by in zip("xyz", press):
        assert moved.get(axis, 0.0) == by and held.find(f"R{axis}_dof").text == str(int(by == 0.0))
    assert all(held.find(f"R{axis}_dof").text == "1" for axis in "uvw")
    assert job.find("Output/logfile/rigid_body_data").get("file") == "job.force.csv"
    assert job.find("Contact/contact").get("surface_pair") == "touch"


class Springs:
    """The springs of a job and the linear constraints that move their nodes."""

    def __init__(self, job):
        self.places, self.num_nodes = table(job.findall("Mesh/Nodes/node")), len(job.findall("Mesh/Nodes[@name='nodes']/node"))
        self.sets, self.constraints, fixed = {}, {}, numpy.zeros(self.places.shape, bool)
        for condition in job.findall("Boundary/bc[@type='zero displacement']"):
            name = condition.get("node_set")
            listed = job.find(f"Mesh/NodeSet[@name='{name}']")
            nodes = numpy.array(numbers(listed), int) - 1
            for axis, name in enumerate(("x_dof", "y_dof", "z_dof")):
                fixed[nodes, axis] |= condition.find(name).text == "1"
        for constraint in job.findall("Boundary/bc[@type='linear constraint']"):
            node, axis = int(constraint.find("node").text) - 1, "xyz".index(constraint.find("dof").text)
            assert node >= self.num_nodes and (node, axis) not in self.constraints and not fixed[node, axis]
            self.constraints[node, axis] = [(int(child.find("node").text) - 1, "xyz".index(child.find("dof").text),
                                             float(child.find("value").text)) for child in constraint.findall("child_dof")]
            assert max(child[0] for child in self.constraints[node, axis]) < self.num_nodes
        assert fixed[self.num_nodes:].sum() + len(self.constraints) == 3 * (len(self.places) - self.num_nodes)  # no equation is left
        for springs in job.findall("Discrete/discrete"):
            name, material = springs.get("discrete_set"), job.find(f"Discrete/discrete_material[@id='{springs.get('dmat')}']")
            assert material.get("type") == "linear spring"
            ends = table(job.findall(f"Mesh/DiscreteSet[@name='{name}']/delem")).astype(int).T - 1
            self.sets[name] = (ends, float(material.find("E").text))

    def energies_and_forces(self, displacement):
        """Energies of the sets by name [J], and forces (N, 3) on the nodes of the body [N] where these move so."""
        moved = numpy.vstack([displacement, numpy.zeros((len(self.places) - self.num_nodes, 3))])
        for (node, axis), children in self.constraints.items():
            moved[node, axis] = sum(factor * moved[child, of] for child, of, factor in children)
        energies, force = {}, numpy.zeros(self.places.shape)
        for name, ((i, j), stiffness) in self.sets.items():
            span = (self.places + moved)[j] - (self.places + moved)[i]
            length = numpy.linalg.norm(span, axis=1)
            longer = length - numpy.linalg.norm(self.places[j] - self.places[i], axis=1)
            energies[name] = 0.5 * stiffness * (longer ** 2).sum()
            pull = stiffness * (longer / length)[:, None] * span
            numpy.add.at(force, i, pull)
            numpy.add.at(force, j, -pull)
        for (node, axis), children in self.constraints.items():
            for child, of, factor in children:
                force[child, of] += factor * force[node, axis]
        return energies, force[:self.num_nodes]


def spring_energies(job, gradient):
    """Energies of the springs of a job by the name of their set [J], where nodes of the body move by gradient @ x."""
    springs = Springs(job)
    return springs.energies_and_forces(springs.places[:springs.num_nodes] @ gradient.T)[0]


GRADIENT = numpy.array([[0.05, 0.02, 0.0], [-0.02, -0.04, 0.03], [0.01, 0.0, 0.06]])


def test_capsule_is_springs_on_the_edges_of_the_surface(tmp_path):
    problem = livermark.problem(COVERED, "traction")
    assert not problem.further_parts and problem.ground_springs is None
    found = spring_energies(job_of(problem, tmp_path), GRADIENT)
    corners, expected = problem.points[problem.boundary_triangles], 0.0
    for a, b in ((0, 1), (1, 2), (2, 0)):  # an edge has two facets
        span = corners[:, b] - corners[:, a]
        longer = numpy.linalg.norm(span + span @ GRADIENT.T, axis=1) - numpy.linalg.norm(span, axis=1)
        expected += 0.5 * numpy.sqrt(3.0) / 4.0 * 164.4 * (longer ** 2).sum()
    assert sum(found.values()) == pytest.approx(expected, rel=1e-9) and expected > 0.0


TUBES = numpy.array([[0.01, 0.02, 0.015], [0.06, 0.018, 0.022], [0.11, 0.03, 0.02]])  # in the beam [m]
RADII = (0.002, 0.002, 0.001)  # [m]


@pytest.fixture
def beam_with_vessels(tmp_path):
    rows = [f"{p + 1} 0 {x} {y} {z} {r} {p or -1}\n" for p, ((x, y, z), r) in enumerate(zip(TUBES, RADII))]
    (tmp_path / "tubes.swc").write_text("".join(rows))
    beam = (SOURCE / "meshes" / "beam.toml").read_text().replace('"beam.msh"', f'"{SOURCE}/meshes/beam.msh"')
    (tmp_path / "body.toml").write_text(beam + '[vessels]\nfile = "tubes.swc"\n')
    return tmp_path / "body.toml"


def test_vessels_are_springs_to_nodes_that_move_with_the_body(beam_with_vessels, tmp_path):
    problem = livermark.problem(beam_with_vessels, "beam_bend")
    assert not problem.further_parts and problem.edge_springs is None
    found, expected = spring_energies(job_of(problem, tmp_path), GRADIENT), 0.0
    for k in (0, 1):
        span, radius = TUBES[k + 1] - TUBES[k], 0.5 * (RADII[k] + RADII[k + 1])
        length, stiffness = numpy.linalg.norm(span), numpy.pi * radius ** 2 * (0.62e6 * (1.0 - 0.9 ** 2) - 5000.0)
        expected += 0.5 * stiffness * length * (numpy.linalg.norm(span + GRADIENT @ span) / length - 1.0) ** 2
    assert found == {"ground_springs": pytest.approx(expected, rel=1e-6)}


@pytest.mark.parametrize("name", ["tilt", "breathing"])
def test_foundation_is_springs_to_nodes_that_move_with_facets(tmp_path, name):
    load_case = SUPPORTED / f"{name}.toml"
    problem = livermark.problem("liver_healthy", load_case)
    assert not problem.further_parts
    found = spring_energies(job_of(problem, tmp_path), GRADIENT)
    subprocess.run([os.environ["LIVERMARK_BINARY"], "export", "liver_healthy", load_case, "--format", "vtu", "-o", tmp_path], check=True,
                   stdout=subprocess.DEVNULL)
    with h5py.File(tmp_path / "liver_healthy" / f"{name}.problem.h5") as file:
        facet, stiffness, normal_only = (file["load_case/foundation"][name][:] for name in ("facet", "stiffness", "normal_only"))
    assert normal_only.all() == (name == "breathing")
    corners, expected = problem.points[problem.boundary_triangles[facet]], 0.0
    area = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    size = numpy.linalg.norm(area, axis=1)
    for a, b in ((0, 1), (1, 2), (2, 0)):  # the rule of the middles of sides is exact for squares
        u = 0.5 * (corners[:, a] + corners[:, b]) @ GRADIENT.T
        held = numpy.where(normal_only, ((u * area).sum(axis=1) / size) ** 2, (u ** 2).sum(axis=1))
        expected += 0.5 * (stiffness * size / 3.0 * held).sum()
    assert found["ground_springs"] == pytest.approx(expected, rel=1e-6)


def test_job_with_vessels_and_a_foundation_is_at_rest_where_the_model_is(beam_with_vessels, tmp_path):
    (tmp_path / "stands.toml").write_text(LARGE.read_text().replace('patch = "y_min"\ndisplacement = ["free", 0.002, "free"] # m',
                                                                    'patch = "y_min"\ntraction = [0.0, 3.0, 0.0]')
                                          + """
[[foundation]]
patch = "z_min"
stiffness = 2e4
normal_only = true

[[foundation]]
patch = "y_max"
stiffness = 1e4
""")
    problem = livermark.problem(beam_with_vessels, tmp_path / "stands.toml")
    solution = problem.solve("fem_p1_neo_hookean")
    assert solution.status == "ok" and not problem.further_parts
    job, u = job_of(problem, tmp_path), numpy.array(solution.displacement)
    young, nu = problem.young_modulus[0], problem.poisson_ratio[0]
    mu, lame = 0.5 * young / (1.0 + nu), young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    edges, moved = (numpy.swapaxes(x[problem.tetrahedra[:, 1:]] - x[problem.tetrahedra[:, :1]], 1, 2) for x in
                    (problem.points, problem.points + u))
    to_rest, volume = numpy.linalg.inv(edges), numpy.linalg.det(edges) / 6.0
    f = moved @ to_rest
    inverse = numpy.swapaxes(numpy.linalg.inv(f), 1, 2)
    stress = mu * (f - inverse) + lame * numpy.log(numpy.linalg.det(f))[:, None, None] * inverse
    pull = numpy.swapaxes(-volume[:, None, None] * stress @ numpy.swapaxes(to_rest, 1, 2), 1, 2)  # a row for each of nodes 1 to 3
    of_springs = Springs(job).energies_and_forces(u)[1]
    force = values_at_nodes(job, "dead_forces", len(u), 3) + of_springs
    numpy.add.at(force, problem.tetrahedra[:, 1:], pull)
    numpy.add.at(force, problem.tetrahedra[:, 0], -pull.sum(axis=1))
    corners = (problem.points + u)[problem.boundary_triangles]
    area = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    for k in range(3):
        numpy.add.at(force, problem.boundary_triangles[:, k], -problem.follower_pressure[:, None] * area / 3.0)
    left, size = numpy.where(problem.fixed, 0.0, force), numpy.linalg.norm(of_springs)
    assert numpy.linalg.norm(left) < 1e-5 * size and abs(u).max() > 0.002, (numpy.linalg.norm(left), size, abs(u).max())


def test_what_no_job_says_is_refused(tmp_path):
    problem = livermark.problem("beam", "beam_plate")
    assert problem.further_parts == ["a ball that touches"] and problem.ball is None
    with pytest.raises(livermark.InputError, match="has a ball that touches, which a job of FEBio cannot say"):
        livermark.to_febio(problem, tmp_path / "job.feb")
    assert not (tmp_path / "job.feb").exists()


@pytest.mark.parametrize("parts, sentence", [
    ({"edge_springs": ([[0, 1]], [1.0, 2.0])}, r"edge_springs: the shapes are \(1, 2\) and \(2,\)"),
    ({"edge_springs": ([[0, 8]], [1.0])}, "edge_springs: nodes are numbered from 0 to 7"),
    ({"edge_springs": ([[0, 1]], [0.0])}, "edge_springs: .*stiffness is above 0"),
    ({"ground_springs": livermark.GroundSprings([[1.0, 0.0, 0.0]], [[0, 0, 1]], [1.0])}, r"ground_springs: the shapes are \(1, 3\)"),
    ({"ground_springs": livermark.GroundSprings([[1.0, 0.0, 0.0]], [[0, 3, 1, 0]], [1.0])}, "ground_springs: there are 1 springs"),
    ({"ground_springs": livermark.GroundSprings([[0.0, 0.0, 0.0]], [[0, 0, 1, 0]], [1.0])}, "ground_springs: .*no place at the origin")])
def test_springs_that_cannot_be_are_refused(bar, tmp_path, parts, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.to_febio(livermark.Solid(*bar, 1e3, 0.45, **parts), tmp_path / "job.feb")


@pytest.mark.parametrize("ball, sentence", [
    ((0.0, [0.0, 0.0, 0.0], [0.0, 0.0, -0.01]), "ball: give a radius above 0 m"),
    ((0.01, [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]), "ball: give a radius above 0 m"),
    ((0.01, [0.0, 0.0], [0.0, 0.0, -0.01]), r"ball.start: the shape is \(2,\)"),
    ((0.01, [9.0, 0.0, 0.0], [0.0, 0.0, -0.01]), "ball: no boundary triangle is within two radii")])
def test_ball_that_touches_nothing_is_refused(bar, tmp_path, ball, sentence):
    solid = livermark.Solid(*bar, 1e3, 0.45, boundary_triangles=[[0, 1, 2]], ball=ball)
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.to_febio(solid, tmp_path / "job.feb")


def test_solid_of_own_arrays_makes_a_material_for_each_stiffness(bar, tmp_path):
    points, tetrahedra = bar
    moved = numpy.full((8, 3), numpy.nan)
    moved[points[:, 2] == 0.0] = [0.0, 0.0, numpy.nan]
    solid = livermark.Solid(points, tetrahedra, [1e3] * 2 + [2e3] * 3 + [1e3], 0.45, region_names=["a & b"],
                            prescribed_displacement=moved)
    job = job_of(solid, tmp_path)
    assert names(job, "Mesh/Elements") == ["a & b_1", "a & b_2"]
    assert [len(part) for part in job.findall("Mesh/Elements")] == [3, 3]
    assert [float(e.text) for e in job.findall("Material/material/E")] == [1e3, 2e3]
    assert names(job, "Boundary/bc") == ["fixed_xy"] and job.find("Loads") is None and job.find("MeshData") is None
    assert job.find("Control/time_steps").text == "10"


def test_modulus_that_varies_over_a_region_is_a_map(bar, tmp_path, monkeypatch):
    monkeypatch.setattr(livermark.convert.febio, "MOST_MATERIALS", 3)
    points, tetrahedra = bar
    solid = livermark.Solid(points, tetrahedra, [1e3, 2e3, 3e3, 4e3, 5e3, 5e3], 0.45, region=[0] * 5 + [1], region_names=["a", "b"])
    job = job_of(solid, tmp_path)
    assert names(job, "Mesh/Elements") == ["a", "b"]
    assert job.find("Material/material[@name='a']/E").attrib == {"type": "map"}
    assert table(job.find("MeshData/ElementData[@elem_set='a']"))[:, 0].tolist() == [1e3, 2e3, 3e3, 4e3, 5e3]
    assert job.find("Material/material[@name='b']/E").text == "5000.0"


@pytest.mark.parametrize("change, sentence", [
    ({"young_modulus": [1e3, 1e3]}, r"young_modulus: the shape is \(2,\); give one of shape \(6,\)"),
    ({"poisson_ratio": 0.5}, "young_modulus and poisson_ratio: give more than 0 Pa"),
    ({"dead_forces": numpy.zeros((7, 3))}, r"dead_forces: the shape is \(7, 3\); give one of shape \(8, 3\)"),
    ({"tetrahedra": [[0, 1, 2, 8]]}, "tetrahedra: nodes are numbered from 0 to 7"),
    ({"points": numpy.zeros((8, 2))}, "points and tetrahedra: the shapes are"),
    ({"region": [1] * 6}, "region: there are 1 names in region_names")])
def test_wrong_arrays_are_refused(bar, tmp_path, change, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.to_febio(livermark.Solid(*bar, 1e3, 0.45)._replace(**change), tmp_path / "job.feb")


LOG = "*Step  = {step}\n*Time  = {time}\n*Data  = ux;uy;uz\n2,{time},0,-1e-3\n1,0,0,0\n"


def test_displacements_come_back_from_the_last_step(large, tmp_path):
    job = job_of(large, tmp_path)
    written = job.find("Output/logfile/node_data")
    assert (written.get("file"), written.get("data"), written.get("delim")) == ("job.displacement.csv", "ux;uy;uz", ",")
    file = tmp_path / "job.displacement.csv"
    file.write_text(LOG.format(step=1, time=0.5) + LOG.format(step=2, time=1))
    assert livermark.from_febio(file).tolist() == [[0.0, 0.0, 0.0], [1.0, 0.0, -1e-3]]
    file.write_text(LOG.format(step=1, time=0.5))
    with pytest.raises(livermark.InputError, match="FEBio stopped at 0.5 of the load"):
        livermark.from_febio(file)


@pytest.mark.parametrize("rows, sentence", [
    ("1,nan,0,0\n2,0,0,0", "is not finite"), ("1,0,0,0\n1,1,0,0", "each once"), ("1,0,0,0\n3,1,0,0", "each once"),
    ("1.5,0,0,0", "each once"), ("1,0,0", "this is no displacement"), ("", "stopped at 1 of the load")])
def test_displacements_of_other_nodes_than_there_are_are_refused(tmp_path, rows, sentence):
    file = tmp_path / "job.displacement.csv"
    file.write_text(f"*Step  = 1\n*Time  = 1\n*Data  = ux;uy;uz\n{rows}\n")
    with pytest.raises(livermark.InputError, match=sentence):
        livermark.from_febio(file)
