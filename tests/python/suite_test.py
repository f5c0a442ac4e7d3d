"""Solutions and scores are those of the program to the last bit."""
import concurrent.futures
import pathlib
import subprocess
import sys

import h5py
import livermark
import numpy
import pytest
from conftest import BINARY, RUNS, arguments_of


@pytest.fixture(scope="module")
def bent():
    return livermark.problem("beam", "beam_bend")


@pytest.fixture
def alone():
    """The result file of a run of one load case."""
    with h5py.File(RUNS / "alone" / "beam" / "beam_bend.h5") as file:
        yield file


@pytest.mark.parametrize("model", ["fem_p1", "fem_p2p1", "lloyd", "van_gelder_nodal_volume", "nodal_springs"])
def test_static_solution_is_that_of_the_program_to_the_last_bit(bent, alone, model):
    ours, theirs = bent.solve(model), alone["solutions"][model]
    assert ours.status == theirs.attrs["status"].decode() == "ok"
    assert numpy.array_equal(ours.displacement, theirs["displacement"][:])
    assert numpy.array_equal(ours.reaction, theirs["reaction"][:])
    assert ours.strain_energy == theirs.attrs["strain_energy"]
    assert ours.degrees_of_freedom == theirs.attrs["degrees_of_freedom"]
    assert (ours.stiffness is None) == model.startswith("fem")
    if "stiffness" in theirs:
        assert numpy.array_equal(ours.stiffness, theirs["stiffness"][:])
    assert ours.time is None and ours.probe_displacement is None


def test_problem_is_that_of_the_program(bent, alone):
    for name, dataset in (("points", "points"), ("tetrahedra", "tetrahedra"), ("region", "region"),
                          ("boundary_triangles", "boundary_triangles")):
        assert numpy.array_equal(getattr(bent, name), alone["mesh"][dataset][:]), name
    of_file = arguments_of(alone)
    for name in ("young_modulus", "poisson_ratio", "density"):
        assert numpy.array_equal(getattr(bent, name), of_file[name]), name
    assert (bent.body, bent.load_case, bent.constraint_names, bent.notes) == ("beam", "beam_bend", ["x_min"], [])
    assert bent.region_names == ["solid"]


def test_arrays_of_a_problem_are_enough_to_find_its_equilibrium(bent):
    springs = livermark.springs(bent.points, bent.tetrahedra, bent.young_modulus, bent.poisson_ratio,
                                density=bent.density)
    solution = bent.solve("lloyd")
    left_over = springs.elastic_forces(bent.points + solution.displacement) + bent.forces
    assert abs(left_over[~bent.fixed]).max() < 1e-9 * abs(left_over[bent.fixed]).max()
    assert numpy.array_equal(numpy.isnan(bent.prescribed_displacement), ~bent.fixed)


def test_score_is_that_of_the_program_to_the_last_bit(bent, alone, tmp_path):
    displacement = alone["solutions/lloyd/displacement"][:]
    score = bent.score(displacement, reference_on_mesh=True, models=["van_gelder"], output=str(tmp_path / "mine.h5"))
    theirs = alone["comparisons/lloyd"]
    assert (score.name, score.reference) == ("mine", theirs.attrs["reference"].decode())
    for name in ("relative_l2", "max_error", "max_error_relative"):
        assert getattr(score, name) == theirs.attrs[name], name
    assert score.stiffness_at_tool == theirs.attrs["stiffness_at_tool"]
    assert numpy.array_equal(score.error, theirs["error"][:])
    assert score.relative_l2_of_models["van_gelder"] == alone["comparisons/van_gelder"].attrs["relative_l2"]
    assert score.uncertainty is None and not score.within_uncertainty and score.reference_on_mesh
    with livermark.open(tmp_path / "mine.h5") as file:
        assert numpy.array_equal(file["mine"].displacement, displacement)


def test_score_of_the_reference_itself_is_within_its_uncertainty(bent):
    score = livermark.score(bent.solve("fem_p2p1").displacement, "beam", "beam_bend")
    assert score.reference == "fem_p2p1_refined" and not score.reference_on_mesh
    assert 0.0 < score.relative_l2 and 0.0 < score.uncertainty < 0.01


def test_the_old_name_of_the_reference_on_the_mesh_is_refused(bent):
    for old in (True, False):
        with pytest.raises(livermark.InputError, match="reference_on_mesh"):
            bent.score(bent.points, with_uncertainty=old)


def test_score_of_the_program_is_the_same(bent, tmp_path):
    displacement = bent.solve("lloyd").displacement
    lines = ["x,y,z,ux,uy,uz"] + [",".join(repr(float(v)) for v in row)
                                  for row in numpy.hstack([bent.points, displacement])]
    (tmp_path / "solution.csv").write_text("\n".join(lines) + "\n")
    subprocess.run([BINARY, "score", "beam", "beam_bend", tmp_path / "solution.csv", "--reference-on-mesh", "--output",
                    tmp_path], check=True, capture_output=True)
    with h5py.File(tmp_path / "beam" / "beam_bend.mine.h5") as file:
        theirs = file["comparisons/mine"].attrs["relative_l2"]
    assert livermark.score(displacement, "beam", "beam_bend", reference_on_mesh=True).relative_l2 == theirs


def test_motion_is_that_of_the_program(release):
    path = pathlib.Path(__file__).with_name("beam_release.toml")
    solution = livermark.solve("beam", path, "fem_p2")
    theirs = release["solutions/fem_p2/history"]
    assert solution.probe_displacement.shape == theirs["displacement"].shape
    assert solution.probe_displacement == pytest.approx(theirs["displacement"][:], rel=1e-6, abs=1e-9)
    assert solution.time.tolist() == theirs["time"][:].tolist()
    assert len(solution.kinetic_energy_history) == len(solution.strain_energy_history) == len(solution.time)


def test_poissons_ratio_and_youngs_modulus_may_be_others():
    other = livermark.problem("beam", "beam_bend", young_modulus=1000.0, poisson_ratio=0.3)
    assert set(other.young_modulus) == {1000.0} and set(other.poisson_ratio) == {0.3}


@pytest.mark.parametrize("what, ours", [("bodies", livermark.bodies), ("load-cases", livermark.load_cases),
                                        ("models", livermark.models), ("spring-laws", livermark.spring_laws)])
def test_lists_are_those_of_the_program(what, ours):
    listed = subprocess.run([BINARY, "list", what], check=True, capture_output=True, text=True).stdout
    assert ours() == [line.split()[0] for line in listed.splitlines()]


@pytest.mark.parametrize("call, sentence", [
    (lambda: livermark.problem("liver_helthy", "palpation"), "there is no body 'liver_helthy'; did you mean 'liver_healthy'"),
    (lambda: livermark.problem("beam", "beam_bent"), "there is no load case 'beam_bent'; did you mean 'beam_bend'"),
    (lambda: livermark.problem("beam", "beam_bend", poisson_ratio=0.5), "--young and --poisson: Poisson's ratio is 0.5"),
    (lambda: livermark.solve("beam", "beam_bend", "loyd"), "there is no model 'loyd'; did you mean 'lloyd'"),
    (lambda: livermark.solve("beam", "beam_bend", "fem_p2p1_neo_hookean"), "model fem_p2p1_neo_hookean does not take"),
    (lambda: livermark.score(numpy.zeros((2, 3)), "beam", "beam_bend"), r"displacement: the shape is \(2, 3\); give "),
    (lambda: livermark.problem("beam", "beam_bend").score(numpy.zeros((1142, 3)), name="lloyd", models=["lloyd"]),
     "there is a model 'lloyd' already"),
    (lambda: livermark.problem("beam", "beam_bend").score(numpy.zeros((1142, 3)), name="../mine"),
     "name: a name has letters, digits, _ and - only")])
def test_wrong_input_is_refused_with_a_sentence(call, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        call()


def test_sentences_are_those_of_the_program():
    refused = subprocess.run([BINARY, "export", "beam", "palpation"], capture_output=True, text=True)
    assert refused.returncode == 2
    with pytest.raises(livermark.InputError) as error:
        livermark.problem("beam", "palpation")
    assert refused.stderr == f"livermark: {error.value}\n"


@pytest.mark.parametrize("order", ["import h5py, livermark", "import livermark, h5py"])
def test_h5py_and_the_suite_live_in_one_process(order, tmp_path):
    code = f"""{order}
import numpy
problem = livermark.problem("beam", "beam_bend")
score = problem.score(problem.solve("lloyd").displacement, reference_on_mesh=True, output="{tmp_path}/a.h5")
with h5py.File("{tmp_path}/a.h5") as file:
    assert numpy.array_equal(file["comparisons/mine/error"][:], score.error)
"""
    subprocess.run([sys.executable, "-c", code], check=True)


def test_springs_alone_do_not_load_finite_elements():
    code = """import livermark
livermark.Springs([[0, 0, 0], [1, 0, 0]], [[0, 1]], 1.0, 1.0)
loaded = open("/proc/self/maps").read()
assert "_livermark" in loaded and "deal" not in loaded and "libmpi" not in loaded and "cholmod" not in loaded
livermark.models()
assert "deal" in open("/proc/self/maps").read()
"""
    subprocess.run([sys.executable, "-c", code], check=True)


@pytest.mark.parametrize("model", ["nodal_springs", "fem_p2p1"])
def test_solutions_in_threads_are_those_of_one_thread_to_the_last_bit(model):
    problem = livermark.problem("beam", "beam_bend")
    alone = problem.solve(model)
    with concurrent.futures.ThreadPoolExecutor(3) as threads:
        for solution in threads.map(lambda _: problem.solve(model), range(6)):
            assert numpy.array_equal(solution.displacement, alone.displacement)
            assert solution.strain_energy == alone.strain_energy


def test_scores_in_threads_write_whole_files(tmp_path):
    problem = livermark.problem("beam", "beam_bend")
    displacement = problem.solve("lloyd").displacement
    with concurrent.futures.ThreadPoolExecutor(3) as threads:
        scores = list(threads.map(lambda k: problem.score(displacement, reference_on_mesh=True, output=f"{tmp_path}/{k}.h5"),
                                  range(3)))
    for k, score in enumerate(scores):
        with h5py.File(tmp_path / f"{k}.h5") as file:
            assert numpy.array_equal(file["comparisons/mine/error"][:], scores[0].error)


ENDS = """import livermark, os, signal, sys, threading, time
problem = livermark.problem("beam", "beam_bend")
def work():
    while True:
        problem.{work}
threading.Thread(target=work, daemon=True).start()
time.sleep({seconds})
"""


@pytest.mark.parametrize("work", ["solve('fem_p1')", "solve('nodal_springs')"])
def test_a_process_that_is_forked_while_a_thread_solves_solves_too(work):
    code = ENDS.format(work=work, seconds=1) + f"""
for k in range(10):
    time.sleep(0.02)
    child = os.fork()
    if child == 0:
        signal.alarm(100)
        os._exit(0 if problem.{work}.status == "ok" else 1)
    assert os.waitpid(child, 0)[1] == 0
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


def test_a_process_that_is_forked_while_a_thread_scores_says_why_it_cannot():
    """Between two scores of that thread it can."""
    score = "score(0.01 * problem.points, reference_on_mesh=True)"
    code = ENDS.format(work=score, seconds=1) + f"""
ends = []
for k in range(20):
    time.sleep(0.01)
    child = os.fork()
    if child == 0:
        signal.alarm(100)
        try:
            problem.{score}
        except RuntimeError as error:
            os._exit(3 if "forked while another thread computed a score" in str(error) else 1)
        os._exit(0)
    ends.append(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
assert set(ends) <= {{0, 3}} and 3 in ends, ends
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


@pytest.mark.parametrize("work", ["solve('fem_p1')", "solve('no model')", "score(0.01 * problem.points, reference_on_mesh=True)"])
def test_a_program_may_end_while_a_thread_solves_or_is_refused(work):
    for seconds in (0.1, 0.35, 0.8):
        code = ENDS.replace("        problem.{work}", "        try: problem.{work}\n        except ValueError: pass")
        ended = subprocess.run([sys.executable, "-c", code.format(work=work, seconds=seconds)], capture_output=True,
                               text=True, timeout=100)
        assert ended.returncode == 0, ended.stderr
