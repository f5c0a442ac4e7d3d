"""Springs of arrays are those of the program, and wrong arrays are refused with a sentence."""
import copy
import multiprocessing
import pickle

import livermark
import numpy
import pytest
from conftest import arguments_of


@pytest.mark.parametrize("law", ["lloyd", "van_gelder", "patch", "uniform"])
def test_springs_are_those_of_the_program_to_the_last_bit(bending, law):
    ours = livermark.springs(**arguments_of(bending), law=law)
    theirs = bending["solutions"][law]
    for name in ("edges", "stiffness", "rest_length", "node_mass"):
        assert numpy.array_equal(getattr(ours, name), theirs[name][:]), name


@pytest.mark.parametrize("term", ["nodal_volume", "tetrahedral_volume"])
def test_springs_beside_a_volume_term_are_those_of_the_program(bending, term):
    ours = livermark.springs(**arguments_of(bending), law="van_gelder", volume_term=term)
    theirs = bending["solutions"]["van_gelder_" + term]
    for name in ("edges", "stiffness", "rest_length", "node_mass"):
        assert numpy.array_equal(getattr(ours, name), theirs[name][:]), name


@pytest.mark.parametrize("engine", livermark.engines())
def test_parameters_of_engines_are_arrays_with_units(bending, engine):
    found = livermark.engine_parameters(**arguments_of(bending), engine=engine)
    assert found["engine"] == engine and found["notes"] and found["cannot"]
    names = set(found["settings"]) | set(found["arrays"])
    assert names == set(found["units"]) == set(found["meanings"])
    assert found["arrays"]["points"].shape[1] == 3
    assert (found["text"] is None) == (engine != "mujoco")


def test_jolt_gets_the_compliance_of_springs_beside_a_volume(bending):
    body = arguments_of(bending)
    springs = livermark.springs(**body, volume_term="tetrahedral_volume")
    found = livermark.engine_parameters(**body, engine="jolt", substeps=100000)["arrays"]
    assert numpy.array_equal(found["edges"], springs.edges)
    assert numpy.allclose(found["edge_compliance"] * springs.stiffness, 1.0, rtol=1e-3)
    with pytest.raises(livermark.InputError, match="no engine 'unity'; known are: bullet, godot, jolt, mujoco, newton, sofa"):
        livermark.engine_parameters(**body, engine="unity")


@pytest.mark.parametrize("model, make", [
    ("lloyd", lambda body: livermark.springs(**body)),
    ("van_gelder_nodal_volume", lambda body: livermark.springs(**body, law="van_gelder", volume_term="nodal_volume")),
    ("nodal_springs", lambda body: livermark.coupled_springs(**body, model="nodal_springs")),
    ("nodal_neo_hookean", lambda body: livermark.coupled_springs(**body))])
def test_elastic_energy_is_that_of_the_program_to_the_last_bit(bending, model, make):
    theirs = bending["solutions"][model]
    springs = make(arguments_of(bending))
    assert springs.elastic_energy(springs.points + theirs["displacement"][:]) == theirs.attrs["strain_energy"]


def test_elastic_forces_balance_the_reaction_of_the_program(bending):
    theirs = bending["solutions/lloyd"]
    springs = livermark.springs(**arguments_of(bending))
    forces = springs.elastic_forces(springs.points + theirs["displacement"][:])
    clamped = numpy.unique(bending["mesh/boundary_triangles"][:][bending["load_case/constraint"][:] == 0])
    assert -forces[clamped].sum(axis=0) == pytest.approx(theirs["reaction"][0], rel=1e-9, abs=1e-12)


def test_materials_of_tetrahedra_make_their_springs_stiffer(bar):
    points, tetrahedra = bar
    soft = livermark.springs(points, tetrahedra, 5000.0, 0.45)
    mixed = livermark.springs(points, tetrahedra, [5000.0] * 5 + [50000.0], 0.45)
    stiffer = mixed.stiffness > soft.stiffness
    of_last = [set(edge) <= set(tetrahedra[5]) for edge in soft.edges.tolist()]
    assert stiffer.tolist() == of_last


def test_masses_add_up_to_that_of_the_body(bar):
    assert livermark.springs(*bar, 5000.0, 0.45, density=1000.0).node_mass.sum() == pytest.approx(1e-3, rel=1e-14)


def of_every_kind(points, tetrahedra):
    """Springs of every constructor, on a body of two materials."""
    young = [5000.0] * 5 + [50000.0]
    yield livermark.Springs(points, [[0, 1], [7, 3]], [10.0, 0.1], 1.0 / 3.0, rest_length=[0.1, 0.3])
    for law in livermark.spring_laws():
        yield livermark.springs(points, tetrahedra, young, 0.45, law=law)
    for term in livermark.volume_terms():
        yield livermark.springs(points, tetrahedra, young, 0.45, law="van_gelder", volume_term=term, density=[1000.0] * 6)
    for model in livermark.coupled_spring_models():
        yield livermark.coupled_springs(points, tetrahedra, young, 0.45, model=model)


def assert_same_bits(one, other):
    moved = one.points + 1e-4 * numpy.sin(1e3 * one.points)
    for name in ("points", "edges", "stiffness", "rest_length", "node_mass"):
        assert numpy.array_equal(getattr(one, name), getattr(other, name)), name
    assert one.elastic_energy(moved) == other.elastic_energy(moved)
    assert numpy.array_equal(one.elastic_forces(moved), other.elastic_forces(moved))


def test_tangent_is_that_of_differences_of_the_forces(bar):
    step = 1e-7
    for springs in of_every_kind(*bar):
        for moved in (springs.points, springs.points + 1e-4 * numpy.sin(1e3 * springs.points)):
            rows, columns, values = springs.tangent(moved)
            tangent = numpy.zeros((moved.size, moved.size))
            numpy.add.at(tangent, (rows, columns), values)
            steps = step * numpy.eye(moved.size).reshape(-1, *moved.shape)
            differences = [(springs.elastic_forces(moved - s) - springs.elastic_forces(moved + s)).ravel() / (2.0 * step)
                           for s in steps]
            assert abs(tangent - differences).max() < 1e-6 * abs(tangent).max(), springs
            assert len(set(zip(rows.tolist(), columns.tolist()))) == len(values)


def test_a_masked_array_without_masked_entries_is_an_array(bar):
    points = numpy.ma.masked_invalid(bar[0])
    assert numpy.array_equal(livermark.springs(points, bar[1], 5000.0, 0.45).stiffness,
                             livermark.springs(bar[0], bar[1], 5000.0, 0.45).stiffness)


def test_springs_come_back_from_a_pickle_to_the_last_bit(bar):
    for springs in of_every_kind(*bar):
        again = pickle.loads(pickle.dumps(springs))
        assert_same_bits(springs, again)
        assert_same_bits(springs, copy.deepcopy(springs))
        assert pickle.dumps(again) == pickle.dumps(springs)


def energy_in_another_process(springs, moved):
    return springs.elastic_energy(moved)


@pytest.mark.parametrize("method", ["spawn", "fork"])
def test_springs_go_to_other_processes(bar, method):
    every = list(of_every_kind(*bar))
    moved = bar[0] + 1e-4 * numpy.sin(1e3 * bar[0])
    with multiprocessing.get_context(method).Pool(1) as pool:
        found = pool.starmap_async(energy_in_another_process, [(springs, moved) for springs in every]).get(timeout=120)
    assert found == [springs.elastic_energy(moved) for springs in every]


def test_a_pickle_of_something_else_is_refused(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    for kept in ((), ("other",), (*springs.__getstate__()[:-2], "no_law", None), springs.__getstate__()[:-1]):
        with pytest.raises(livermark.InputError):
            livermark.Springs.__new__(livermark.Springs).__setstate__(kept)


def test_arrays_are_views_that_keep_the_springs_alive_and_cannot_be_written_to(bar):
    stiffness = livermark.springs(*bar, 5000.0, 0.45).stiffness  # nothing else refers to the springs
    assert not stiffness.flags.owndata and not stiffness.flags.writeable
    assert isinstance(stiffness.base, livermark.Springs)
    assert numpy.array_equal(stiffness, livermark.springs(*bar, 5000.0, 0.45).stiffness)


def test_arrays_of_any_layout_and_type_mean_the_same(bar):
    points, tetrahedra = bar
    plain = livermark.springs(points, tetrahedra, 5000.0, 0.45)
    other = livermark.springs(numpy.asfortranarray(points), tetrahedra.astype(numpy.uint16)[:, :], 5000, 0.45)
    listed = livermark.springs(points.tolist(), tetrahedra.tolist(), [5000] * 6, 0.45)
    for springs in (other, listed):
        assert numpy.array_equal(springs.stiffness, plain.stiffness)


def test_springs_of_ones_own_have_the_energy_of_the_formula():
    springs = livermark.Springs([[0, 0, 0], [0.1, 0, 0]], [[0, 1]], stiffness=20.0, node_mass=0.01)
    assert springs.rest_length.tolist() == [0.1]
    assert springs.elastic_energy([[0, 0, 0], [0.13, 0, 0]]) == pytest.approx(0.5 * 20.0 * 0.03**2, rel=1e-12)
    assert springs.elastic_forces([[0, 0, 0], [0.13, 0, 0]])[1] == pytest.approx([-0.6, 0, 0], rel=1e-12)


@pytest.mark.parametrize("change, sentence", [
    ({"points": "points"}, r"points: this is no array of numbers; give one of shape \(N, 3\)"),
    ({"points": numpy.zeros((8, 2))}, r"points: the shape is \(8, 2\); give one of shape \(N, 3\)"),
    ({"points": numpy.full((8, 3), numpy.nan)}, "points: row 0 has a nan; every entry has to be finite"),
    ({"points": numpy.zeros((8, 3))}, "tetrahedra: number 0 is flat; remesh there"),
    ({"tetrahedra": numpy.zeros((0, 4), int)}, "tetrahedra: there are none; mesh the volume, not only the surface"),
    ({"tetrahedra": [[0.0, 1.0, 3.0, 7.0]]}, "tetrahedra: node numbers have to be integers"),
    ({"tetrahedra": [[0, 1, 3, 8]]}, "tetrahedra: there is no node 8; nodes are numbered from 0 to 7"),
    ({"tetrahedra": [[0, 1, 3, -1]]}, "tetrahedra: there is no node -1; nodes are numbered from 0 to 7"),
    ({"tetrahedra": [[1, 0, 3, 7]]}, "tetrahedra: number 0 is inverted; exchange two of its nodes"),
    ({"tetrahedra": [[0, 1, 3, 7]]}, "points: number 2 belongs to no tetrahedron; remove it"),
    ({"tetrahedra": [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7], [3, 0, 7, 2]]},
     "tetrahedra: numbers 1 and 6 have the same nodes; remove one"),
    ({"tetrahedra": [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7], [0, 3, 6, 7]]},
     "tetrahedra: more than two have the face of points 0 3 7; remesh without overlaps"),
    ({"points": numpy.ma.masked_greater(numpy.ones((8, 3)), 0.5)},
     r"points: it has masked entries; give points.filled\(...\) with numbers for them"),
    ({"young_modulus": 0.0}, "young_modulus: 0 Pa; it has to be positive"),
    ({"young_modulus": [1.0, 2.0]}, r"young_modulus: the shape is \(2,\); give a number, or an array of shape \(6,\)"),
    ({"poisson_ratio": 0.5}, "poisson_ratio: 0.5; it has to lie between -1 and 0.5, both excluded"),
    ({"density": -1.0}, "density: -1 kg/m.3; it has to be positive"),
    ({"law": "loyd"}, "there is no spring law 'loyd'; did you mean 'lloyd'?"),
    ({"volume_term": "volume"}, "there is no volume term 'volume'; known are: nodal_volume, ")])
def test_wrong_input_is_refused_with_a_sentence(bar, change, sentence):
    arguments = {"points": bar[0], "tetrahedra": bar[1], "young_modulus": 5000.0, "poisson_ratio": 0.45, **change}
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.springs(**arguments)
    assert issubclass(livermark.InputError, ValueError)


def test_two_points_in_one_place_are_warned_of(bar):
    points = numpy.vstack([bar[0], bar[0][2]])
    tetrahedra = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 8, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
    with pytest.warns(UserWarning, match="points: numbers 2 and 8 have the same coordinates; merge them, unless a cut parts"):
        livermark.springs(points, tetrahedra, young_modulus=5000.0, poisson_ratio=0.45, density=1000.0)


@pytest.mark.parametrize("edges, stiffness, sentence", [
    ([[0, 1], [1, 0]], 1.0, "edges: nodes 1 and 0 are joined twice; add the two stiffnesses"),
    ([[0, 0]], 1.0, "edges: nodes 0 and 0 have the same coordinates; merge them"),
    ([[0, 1]], -1.0, "stiffness: number 0 is -1; it has to be positive")])
def test_wrong_springs_of_ones_own_are_refused(edges, stiffness, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        livermark.Springs([[0, 0, 0], [1, 0, 0]], edges, stiffness, 1.0)
