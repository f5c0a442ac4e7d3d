"""Arrays and words as other programs hand them over: each is what it means, or is refused in a sentence."""
import livermark
import numpy
import pytest

NAN, INFINITY = float("nan"), float("inf")


@pytest.fixture
def springs(bar):
    return livermark.springs(*bar, 5000.0, 0.45)


def simulation(springs, **named):
    return livermark.Simulation(springs, named.pop("time_step", 1e-5), **named)


@pytest.mark.parametrize("points, tetrahedra", [
    (lambda p: p.astype(">f8"), lambda t: t.astype(">i4")), (numpy.asfortranarray, numpy.asfortranarray),
    (lambda p: numpy.repeat(p, 2, 0)[::2], lambda t: t[:, ::-1][:, ::-1]), (lambda p: p.tolist(), lambda t: t.astype("u1"))])
def test_layout_and_type_do_not_matter(bar, springs, points, tetrahedra):
    other = livermark.springs(points(bar[0]), tetrahedra(bar[1]), 5000.0, [0.45] * 6)
    assert numpy.array_equal(other.stiffness, springs.stiffness)


def test_a_column_is_read_as_its_numbers(bar, springs):
    """As files of meshes have values of cells and nodes."""
    other = livermark.springs(*bar, numpy.full((6, 1), 5000.0), numpy.full((6, 1), 0.45))
    assert numpy.array_equal(other.stiffness, springs.stiffness)
    moved = []
    for fixed in (numpy.arange(3), numpy.arange(3)[:, None], numpy.arange(8) < 3, (numpy.arange(8) < 3)[:, None]):
        run = simulation(springs, fixed=fixed, forces=numpy.full((8, 3), 1e-3))
        run.step(5)
        moved.append(run.displacement.copy())
    assert all(numpy.array_equal(one, moved[0]) for one in moved) and moved[0].any()


@pytest.mark.parametrize("tetrahedra", [
    lambda t: t.astype("u8") + 2**63, lambda t: t + 0.5, lambda t: t.astype(bool), lambda t: t.astype(object), lambda t: t.astype(str),
    lambda t: t - 1, lambda t: t[:0], lambda t: numpy.hstack([t, t[:, :1]]), lambda t: numpy.vstack([t, t[:1]])])
def test_what_is_no_list_of_tetrahedra_is_refused(bar, tetrahedra):
    with pytest.raises(livermark.InputError, match="^tetrahedra: [^\n]*$"):
        livermark.springs(bar[0], tetrahedra(bar[1]), 5000.0, 0.45)


@pytest.mark.parametrize("points", [
    lambda p: p + 1j, lambda p: p.astype(str), lambda p: p + INFINITY, lambda p: numpy.where(p > 0.005, NAN, p),
    lambda p: numpy.ma.masked_greater(p, 0.005), lambda p: numpy.vstack([p, [[1, 1, 1]]]), lambda p: numpy.vstack([p, [[NAN] * 3]])])
def test_what_is_no_list_of_points_is_refused(bar, points):
    with pytest.raises(livermark.InputError, match="^points: [^\n]*$"):
        livermark.springs(points(bar[0]), bar[1], 5000.0, 0.45)


@pytest.mark.parametrize("step", [0.0, -1.0, NAN, INFINITY, 1e9, True])
def test_what_is_no_time_step_is_refused(springs, step):
    with pytest.raises(livermark.InputError, match="^time_step: [^\n]*$"):
        simulation(springs, time_step=step)


@pytest.mark.parametrize("call", [
    lambda s: s.step(-1), lambda s: s.set_force(-1, [0, 0, 1]), lambda s: s.set_force(8, [0, 0, 1]), lambda s: s.set_force(2**40, [0, 0, 1]),
    lambda s: s.set_force(0, [0, 0, NAN]), lambda s: setattr(s, "displacement", numpy.full((8, 3), NAN)),
    lambda s: setattr(s, "displacement", numpy.zeros((3, 8))), lambda s: setattr(s, "velocity", numpy.zeros((8, 3), complex)),
    lambda s: setattr(s, "displacement", numpy.ma.masked_less(numpy.zeros((8, 3)), 1.0))])
def test_what_cannot_be_done_to_a_simulation_is_refused(springs, call):
    with pytest.raises(livermark.InputError, match="^[^\n]*$"):
        call(simulation(springs))


@pytest.mark.parametrize("fixed", [
    numpy.zeros(7, bool), numpy.zeros(8, int), numpy.zeros((8, 2), bool), [-1], [100], "all", numpy.zeros(8), numpy.ma.masked_equal([0, 1, 2], 1)])
def test_what_names_no_nodes_is_refused(springs, fixed):
    with pytest.raises(livermark.InputError, match="^fixed: [^\n]*$"):
        simulation(springs, fixed=fixed)


@pytest.mark.parametrize("call", [
    lambda: livermark.rayleigh_damping(NAN, 10.0, 60.0), lambda: livermark.rayleigh_damping(0.05, 0.0, 60.0),
    lambda: livermark.open("/tmp"), lambda: livermark.from_meshio("/tmp"), lambda: livermark.from_febio("/tmp"),
    lambda: livermark.problem("", "palpation"), lambda: livermark.problem("beam\0x", "beam_bend")])
def test_other_words_are_refused(call):
    with pytest.raises(livermark.InputError, match="^[^\n]*$"):
        call()


def test_images_and_surfaces_say_how_they_become_bodies(tmp_path):
    for name, option in (("liver.nii.gz", "--labels"), ("liver.STL", "--surfaces")):
        (tmp_path / name).write_bytes(b"x" * 1000)
        with pytest.raises(livermark.InputError, match=f"make a body of it with `livermark mesh {option} {name}"):
            livermark.problem(tmp_path / name, "palpation")


def test_paths_may_be_bytes(tmp_path):
    (tmp_path / "a.msh").write_bytes(b"x")
    with pytest.raises(livermark.InputError, match="a.msh: no mesh can be read"):
        livermark.from_meshio(str(tmp_path / "a.msh").encode())
