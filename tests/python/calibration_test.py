"""Springs fitted to finite elements: the objective, its minimisation, the file, and what is refused."""
import importlib
import os
import pathlib
import subprocess
import sys

import h5py
import livermark
import numpy
import pytest
from conftest import BINARY
from livermark.calibration import files, loads
from livermark.suite import load

sparse = pytest.importorskip("scipy.sparse", reason="python3-scipy is missing")
objective = importlib.import_module("livermark.calibration.objective")
SAMPLES = pathlib.Path(os.environ["LIVERMARK_SAMPLES"])


def box(size, counts):
    """Points [m], moved a little, and five tetrahedra for each cell: mirrored in every other one."""
    grid = numpy.stack(numpy.meshgrid(*[numpy.arange(n + 1) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3)
    number = {tuple(place): i for i, place in enumerate(grid.tolist())}
    corners = {0: [(0, 3, 5, 6), (0, 1, 3, 5), (0, 3, 2, 6), (0, 6, 4, 5), (3, 5, 6, 7)],
               1: [(1, 2, 4, 7), (0, 1, 2, 4), (1, 3, 2, 7), (1, 5, 4, 7), (2, 4, 6, 7)]}
    tetrahedra = [[number[cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)] for c in nodes]
                  for cell in numpy.ndindex(*counts) for nodes in corners[sum(cell) % 2]]
    inside = ((grid > 0) & (grid < counts)).all(axis=1)
    points = (grid + 0.2 * inside[:, None] * numpy.random.default_rng(2).uniform(-1, 1, grid.shape)) * size / counts
    sides = points[numpy.array(tetrahedra)]
    turned = numpy.linalg.det(sides[:, 1:] - sides[:, :1]) < 0.0
    return points, numpy.array([[a, b, d, c] if turn else [a, b, c, d] for (a, b, c, d), turn in zip(tetrahedra, turned)])


class Task:
    """A box that is constrained at one end, under random forces, and where other springs take it."""

    def __init__(self, num_loads, change=0.5):
        self.random = numpy.random.default_rng(1)
        self.points, self.tetrahedra = box(numpy.array([0.1, 0.08, 0.06]), (3, 2, 2))
        self.springs = livermark.springs(self.points, self.tetrahedra, 5e3, 0.4, law="lloyd", volume_term="nodal_volume")
        self.fixed = numpy.repeat(self.points[:, :1] == 0.0, 3, axis=1)
        self.volume = self.random.uniform(1.0, 2.0, len(self.points))
        self.force = 1e-4 * self.random.uniform(-1, 1, (num_loads, len(self.points), 3))
        self.changed = self.springs.stiffness * numpy.exp(self.random.uniform(-change, change, len(self.springs.edges)))
        displacement = numpy.array([self.displacement(self.changed, force) for force in self.force])
        self.expected = loads.Expected(self.force, displacement, self.fixed)
        self.held_out = numpy.arange(num_loads) % 4 == 3

    def stiffness_matrix(self, stiffness):
        """Dense: springs from their definition, the volumes from differences of their forces."""
        size = self.points.size
        plain = livermark.Springs(self.points, self.springs.edges, self.springs.stiffness, self.springs.node_mass)
        matrix = numpy.zeros((size, size))
        step = 1e-6
        for column in range(size):
            moved = numpy.zeros(size)
            moved[column] = step
            moved = moved.reshape(-1, 3)
            for sign in (-1.0, 1.0):
                pull = [s.elastic_forces(self.points + sign * moved).ravel() for s in (self.springs, plain)]
                matrix[:, column] -= sign * (pull[0] - pull[1]) / (2.0 * step)
        for (i, j), k in zip(self.springs.edges.tolist(), stiffness):
            direction = self.points[j] - self.points[i]
            direction /= numpy.linalg.norm(direction)
            extension = numpy.zeros((len(self.points), 3))
            extension[i], extension[j] = -direction, direction
            matrix += k * numpy.outer(extension.ravel(), extension.ravel())
        return matrix

    def displacement(self, stiffness, force):
        free = ~self.fixed.ravel()
        found = numpy.zeros(force.size)
        if not hasattr(self, "of_volume"):
            self.of_volume = self.stiffness_matrix(numpy.zeros(len(self.springs.edges)))
            self.extension = objective._extension_matrix(self.springs, force.size).toarray()
        matrix = self.of_volume + self.extension.T @ (stiffness[:, None] * self.extension)
        found[free] = numpy.linalg.solve(matrix[free][:, free], force.ravel()[free])
        return found.reshape(force.shape)

    def objective(self, penalty=0.0):
        return objective.Objective(self.springs, self.expected, self.volume, self.held_out, penalty)


def test_a_matrix_that_is_not_positive_definite_has_no_solver():
    random = numpy.random.default_rng(4)
    root = random.uniform(-1.0, 1.0, (40, 40))
    matrix, columns = root @ root.T + numpy.eye(40), random.uniform(-1.0, 1.0, (40, 3))
    found = objective.solver(sparse.csc_matrix(matrix))(columns)
    numpy.testing.assert_allclose(matrix @ found, columns, atol=1e-10)
    matrix[20, 20] = -1.0
    assert objective.solver(sparse.csc_matrix(matrix)) is None
    matrix[20], matrix[:, 20] = 0.0, 0.0
    assert objective.solver(sparse.csc_matrix(matrix)) is None


def test_gradient_is_that_of_differences():
    task = Task(4)
    value = task.objective(penalty=0.1)
    point = value.start + task.random.uniform(-0.3, 0.3, len(value.start))
    step = 1e-4
    around = [[value.evaluate(point + sign * step * e).value for sign in (-1.0, 1.0)] for e in numpy.eye(len(point))]
    differences = numpy.array([(above - below) / (2.0 * step) for below, above in around])
    gradient = value.evaluate(point).gradient
    assert numpy.linalg.norm(gradient - differences) < 1e-6 * numpy.linalg.norm(differences)


def test_errors_are_those_of_a_dense_solution():
    task = Task(4)
    stiffness = task.springs.stiffness * task.random.uniform(0.5, 2.0, len(task.springs.edges))
    dense = task.stiffness_matrix(stiffness)
    free = ~task.fixed.ravel()
    found = numpy.zeros((4, task.fixed.size))
    found[:, free] = numpy.linalg.solve(dense[free][:, free], task.force.reshape(4, -1)[:, free].T).T
    squares = [(task.volume * (fields.reshape(4, -1, 3)**2).sum(axis=2)).sum(axis=1)
               for fields in (found - task.expected.displacement.reshape(4, -1), task.expected.displacement)]
    errors = numpy.sqrt(squares[0] / squares[1])
    state = task.objective().evaluate(numpy.log(stiffness))
    assert state.errors == pytest.approx(errors, rel=1e-6)
    assert state.value == pytest.approx((errors[:3]**2).mean(), rel=1e-6)


def test_finds_the_springs_that_made_the_solutions():
    task = Task(24)
    value = task.objective()
    assert value.evaluate(value.start).errors.max() > 0.05
    stiffness = task.springs.stiffness
    for _ in range(10):
        stiffness, errors = objective.calibration_round(value, stiffness, 50)
    assert errors.max() < 1e-3 and errors[task.held_out].max() > 0.0
    assert value.evaluate(numpy.log(stiffness)).errors.tolist() == pytest.approx(errors.tolist(), rel=1e-9)


def test_stays_within_the_bounds_and_never_gets_worse():
    value = Task(4).objective()
    stiffness, _ = objective.calibration_round(value, numpy.exp(value.start), 30, widest=1.1)
    assert abs(numpy.log(stiffness) - value.start).max() == pytest.approx(numpy.log(1.1), rel=1e-9)
    assert value.evaluate(numpy.log(stiffness)).value < value.evaluate(value.start).value
    again, _ = objective.calibration_round(value, stiffness, 1)
    assert again == pytest.approx(stiffness, rel=1e-14)


def test_a_round_evaluates_as_often_as_it_is_told():
    seen = []
    value = Task(4).objective()
    objective.calibration_round(value, numpy.exp(value.start), 7, seen.append)
    assert len(seen) == 7


def test_penalty_keeps_the_springs_near_their_start():
    task = Task(4)
    change = [((numpy.log(objective.calibration_round(task.objective(penalty), task.springs.stiffness, 50)[0]) -
                numpy.log(task.springs.stiffness))**2).sum() for penalty in (0.0, 1.0)]
    assert change[1] < 0.1 * change[0]


def test_a_body_that_gives_way_has_no_objective():
    task = Task(4)
    task.expected = task.expected._replace(fixed=numpy.zeros_like(task.fixed))
    value = task.objective()
    assert not value.evaluate(value.start).value < numpy.inf


@pytest.fixture(scope="module")
def boxes(tmp_path_factory):
    """A box of soft tissue as a user would have it, a finer one, and a load case."""
    folder = tmp_path_factory.mktemp("boxes")
    for name, edge in (("box", "0.025"), ("finer", "0.02")):
        make = ["mesh", "box", "--size", "0.12", "0.08", "0.06", "--edge", edge, "-o", folder / f"{name}.msh"]
        subprocess.run([BINARY, *make], check=True, capture_output=True)
        (folder / f"{name}.toml").write_text(
            f'mesh = "{name}.msh"\n[regions.solid]\ndensity = 1060\nyoung_modulus = 5000\npoisson_ratio = 0.45\n'
            'source = "made up"\n')
    (folder / "pull.toml").write_text(
        'target_peak_displacement = 0.001\n[[condition]]\npatch = "x_min"\ndisplacement = [0.0, 0.0, 0.0]\n'
        '[[condition]]\npatch = "x_max"\ntraction = [10.0, 0.0, 0.0]\n')
    return folder


def fit(boxes, output=None, **options):
    arguments = {"constrained": "x_min", "num_loads": 4, "iterations": 20}
    return livermark.calibrate(boxes / "box.toml", output=output, **(arguments | options))


def test_discs_lie_on_the_free_surface_and_depend_on_the_seed_alone(boxes):
    mesh = loads.mesh_of(boxes / "box.toml", None, None)
    corners = mesh.points[mesh.boundary_triangles]
    free = corners[mesh.boundary_patch != mesh.patch_names.index("x_min")].mean(axis=1)
    discs = loads.disc_loads(mesh, "x_min", 20, 1)
    for disc in discs:
        assert numpy.linalg.norm(free - disc.point, axis=1).min() < 1e-12
        assert 0.015 <= disc.radius < 0.030 and numpy.linalg.norm(disc.traction) == pytest.approx(1.0, rel=1e-14)
    longer, other = loads.disc_loads(mesh, "x_min", 25, 1), loads.disc_loads(mesh, "x_min", 20, 2)
    assert [disc.radius for disc in longer[:20]] == [disc.radius for disc in discs]
    assert not {disc.radius for disc in discs} & {disc.radius for disc in other}


def test_lowers_the_error_under_loads_that_had_no_part_in_it(boxes):
    lines = []
    found = fit(boxes, num_loads=24, iterations=40, report=lines.append)
    assert found.held_out.sum() == 6 and found.iterations == 40
    for chosen in (found.held_out, ~found.held_out):
        before, after = found.error_before[chosen].mean(), found.error_after[chosen].mean()
        assert 0.01 < before and after < 0.8 * before
    assert len(lines) == 24 + 40 and lines[-1].startswith("[40/40] objective ")


def test_the_program_runs_the_springs_of_the_file(boxes, tmp_path):
    file = tmp_path / "box.calibrated.h5"
    found = fit(boxes, file)
    run = [BINARY, "run", "--body", boxes / "box.toml", "--load-case", boxes / "pull.toml", "--reference-on-mesh",
           "--model", "patch_nodal_volume", "--calibration", file, "--output", tmp_path / "runs"]
    ran = subprocess.run(run, capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr
    with livermark.open(tmp_path / "runs" / "box" / "pull.h5") as result:
        springs = result["calibrated_nodal_volume"].springs
        assert numpy.array_equal(springs["stiffness"], found.stiffness)
        assert not numpy.array_equal(springs["stiffness"], result["patch_nodal_volume"].springs["stiffness"])
        assert numpy.array_equal(result["patch_nodal_volume"].springs["stiffness"], found.start_stiffness)
    refused = subprocess.run([*run, "--poisson", "0.3"], capture_output=True, text=True)
    assert refused.returncode == 2 and "not for 5000 Pa and 0.3" in refused.stderr


def test_goes_on_as_if_it_had_never_stopped(boxes, tmp_path):
    whole, part = fit(boxes, iterations=40), fit(boxes, tmp_path / "parts.h5")
    parts = fit(boxes, tmp_path / "parts.h5", iterations=40)
    assert part.iterations == 20 and parts.iterations == 40
    assert not numpy.array_equal(part.stiffness, whole.stiffness)
    for name in ("stiffness", "error_before", "error_after"):
        assert numpy.array_equal(getattr(parts, name), getattr(whole, name)), name
    assert files.read(tmp_path / "parts.h5").table() == whole.table()
    again = fit(boxes, tmp_path / "parts.h5", restart=True)
    assert again.iterations == 20 and numpy.array_equal(again.stiffness, part.stiffness)


def entries(file):
    """What a file consists of: attributes with type and shape; datasets with type, number of dimensions and filters."""
    found = {}

    def look(name, item):
        for key in item.attrs:
            kind = item.attrs.get_id(key).dtype
            found[f"{name}@{key}"] = (kind.kind, kind.kind != "S" and kind.str, item.attrs.get_id(key).shape)
        if isinstance(item, h5py.Dataset):
            found[name] = (item.dtype.str, item.ndim, item.fletcher32, item.compression, item.shuffle)

    look("", file)
    file.visititems(look)
    return found


def test_the_file_has_what_the_program_writes(boxes, tmp_path):
    found = fit(boxes)
    with h5py.File(SAMPLES / "sample_calibration.h5") as theirs:
        num_springs = len(theirs["springs/edges"])  # enough for chunks
        for name in ("edges", "rest_length", "start_stiffness", "stiffness"):
            values = getattr(found, name)
            setattr(found, name, numpy.resize(values, (num_springs, *values.shape[1:])))
        files.write(tmp_path / "mine.h5", found, load()._provenance)
        with h5py.File(tmp_path / "mine.h5") as mine:
            assert entries(mine) == entries(theirs)
    again = files.read(tmp_path / "mine.h5")
    for name, value in vars(found).items():
        assert numpy.array_equal(getattr(again, name), value), name


@pytest.mark.parametrize("options, sentence", [
    ({"constrained": "posterior"}, "no patch 'posterior' to constrain; choose among x_min"),
    ({"iterations": 30}, "iterations: 30; give a multiple of 20"), ({"iterations": 0}, "multiple of 20"),
    ({"iterations": 20.0}, "multiple of 20"), ({"num_loads": 3}, "num_loads: 3; give a whole number from 4 to 1000"),
    ({"seed": -1}, "seed: -1"), ({"penalty": float("nan")}, "penalty: nan"), ({"penalty": -1.0}, "penalty: -1.0"),
    ({"law": "patsch"}, "no spring law 'patsch'; did you mean 'patch'"), ({"poisson_ratio": 0.5}, "Poisson's ratio is 0.5"),
    ({"output": "/nowhere/at/all.h5"}, "there is no directory /nowhere/at"), ({"output": "/tmp"}, "not a plain file")])
def test_wrong_arguments_are_refused_with_a_sentence(boxes, options, sentence):
    with pytest.raises(livermark.InputError) as refusal:
        fit(boxes, **options)
    assert sentence in str(refusal.value) and "\n" not in str(refusal.value)


@pytest.mark.parametrize("options, sentence", [
    ({"seed": 2}, "was begun with another law"), ({"num_loads": 8}, "or restart"), ({"law": "lloyd"}, "give those again"),
    ({"penalty": 1.0}, "give those again"), ({"young_modulus": 1e3}, "another Young's modulus"),
    ({"poisson_ratio": 0.3}, "another Young's modulus or Poisson's ratio")])
def test_another_calibration_is_not_continued(boxes, tmp_path, options, sentence):
    fit(boxes, tmp_path / "box.h5")
    with pytest.raises(livermark.InputError, match=sentence):
        fit(boxes, tmp_path / "box.h5", iterations=40, **options)


def test_a_file_of_another_mesh_or_of_other_loads_is_not_continued(boxes, tmp_path):
    file = tmp_path / "box.h5"
    fit(boxes, file)
    with pytest.raises(livermark.InputError, match="another mesh than that of finer"):
        livermark.calibrate(boxes / "finer.toml", constrained="x_min", num_loads=4, output=file)
    with h5py.File(file, "r+") as changed:
        changed["loads/error_before"][0] *= 1.01
    with pytest.raises(livermark.InputError, match="was made with other loads"):
        fit(boxes, file, iterations=40)


@pytest.mark.parametrize("spoil, sentence", [
    (lambda file: file.__delitem__("springs"), "this is no calibration"),
    (lambda file: file["springs/stiffness"].__setitem__(3, -1.0), "not all positive and finite"),
    (lambda file: file.attrs.__delitem__("held"), "this is no calibration")])
def test_a_damaged_file_is_refused(boxes, tmp_path, spoil, sentence):
    fit(boxes, tmp_path / "box.h5")
    with h5py.File(tmp_path / "box.h5", "r+") as file:
        spoil(file)
    with pytest.raises(livermark.InputError, match=sentence):
        fit(boxes, tmp_path / "box.h5", iterations=40)


def test_something_else_is_refused(boxes, tmp_path):
    (tmp_path / "box.h5").write_text("no HDF5")
    with pytest.raises(livermark.InputError, match="make it again with `python3 -m livermark.calibration`"):
        fit(boxes, tmp_path / "box.h5")


def from_the_shell(*arguments):
    command = [sys.executable, "-m", "livermark.calibration", *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True)


def test_the_command_writes_the_file_and_prints_the_errors(boxes, tmp_path):
    done = from_the_shell(boxes / "box.toml", "--constrained", "x_min", "--loads", 4, "--iterations", 20, "--young", 4000,
                          "--poisson", 0.4, "--output", tmp_path / "box.h5")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("box: relative L2 errors to fem_p2p1 after 20 iterations from patch")
    assert "| held out | 1 |" in done.stdout and done.stderr.startswith("[1/4] disc_0 / fem_p2p1\n")
    same = fit(boxes, young_modulus=4000.0, poisson_ratio=0.4)
    assert numpy.array_equal(files.read(tmp_path / "box.h5").stiffness, same.stiffness)
    assert from_the_shell("--help").returncode == 0


@pytest.mark.parametrize("arguments, sentence", [
    (["--iterations", "30"], "a multiple of 20"), (["--loads", "3"], "from 4 to 1000"), (["--loads", "many"], "--loads"),
    (["--constrained", "nowhere"], "no patch 'nowhere'"), (["--no-such-option"], "--no-such-option")])
def test_the_command_refuses_nonsense_in_one_sentence(tmp_path, arguments, sentence):
    refused = from_the_shell("beam", "--output", tmp_path / "springs.h5", *arguments)
    assert refused.returncode == 2 and sentence in refused.stderr and refused.stderr.count("\n") == 1, refused.stderr
    assert not (tmp_path / "springs.h5").exists()
