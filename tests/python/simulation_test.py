"""Motions are those of the program, and of the formulas."""
import os
import pickle
import subprocess
import sys
import threading
import time

import livermark
import numpy
import pytest
from conftest import arguments_of


def fixed_in(file):
    """Components that a load case prescribes, (N, 3)."""
    fixed = numpy.zeros(file["mesh/points"].shape, bool)
    triangles, values = file["mesh/boundary_triangles"][:], file["load_case/value"][:]
    for facet in numpy.flatnonzero(file["load_case/condition"][:] == 1):
        fixed[triangles[facet]] |= ~numpy.isnan(values[facet])
    return fixed


@pytest.mark.parametrize("model, make", [
    ("lloyd", lambda body: livermark.springs(**body)),
    ("van_gelder_nodal_volume", lambda body: livermark.springs(**body, law="van_gelder", volume_term="nodal_volume")),
    ("nodal_springs", lambda body: livermark.coupled_springs(**body, model="nodal_springs")),
    ("nodal_neo_hookean", lambda body: livermark.coupled_springs(**body))])
@pytest.mark.parametrize("num_threads", [1, 2])
def test_motion_is_that_of_the_program_to_the_last_bit(release, model, make, num_threads):
    springs = make(arguments_of(release))
    history = release["solutions"][model]["history"]
    case = release["load_case"]
    damping = livermark.RayleighDamping(case["release"].attrs["alpha"], case["release"].attrs["beta"])
    fixed = fixed_in(release)
    assert livermark.critical_time_step(springs, "velocity_verlet", damping, fixed) == \
        history.attrs["critical_time_step"]

    step = history.attrs["time_step"]
    simulation = livermark.Simulation(springs, step, "velocity_verlet", damping, fixed,
                                      forces=springs.node_mass[:, None] * case["acceleration"][:],
                                      num_threads=num_threads)
    simulation.displacement = release["solutions"][model]["displacement"][:]
    probes = case["release/probe"][:]
    steps_per_record = round(case["release"].attrs["output_interval"] / step)
    recorded = history["displacement"][:]
    # Kernels keep positions, so a displacement that is set is rounded to their digits.
    assert simulation.displacement[probes] == pytest.approx(recorded[0], abs=1e-17)
    for record, expected in enumerate(recorded[1:]):
        simulation.step(steps_per_record)
        simulation.displacement = simulation.displacement  # the program takes the state out and in at each record
        assert numpy.array_equal(simulation.displacement[probes], expected), record
    assert simulation.num_steps == steps_per_record * case["release"].attrs["num_steps"]
    assert simulation.time == simulation.num_steps * step


def pair():
    """Two masses and a spring whose relative motion has the period 2 pi sqrt(m / (2 k))."""
    return livermark.Springs([[0, 0, 0], [1, 0, 0]], [[0, 1]], stiffness=200.0, node_mass=1.0)


def test_two_masses_swing_with_the_frequency_of_the_formula():
    assert livermark.largest_angular_frequency(pair()) == pytest.approx(20.0, rel=1e-9)
    assert livermark.largest_angular_frequency(pair(), fixed=[0]) == pytest.approx(200.0**0.5, rel=1e-9)
    assert livermark.critical_time_step(pair()) == pytest.approx(2.0 / 20.0, rel=1e-6)


def test_a_step_above_the_critical_one_grows_and_one_below_does_not():
    for part, grows in ((0.99, False), (1.01, True)):
        simulation = livermark.Simulation(pair(), part * livermark.critical_time_step(pair()), force_time_step=True)
        simulation.displacement = [[0, 0, 0], [1e-6, 0, 0]]
        simulation.step(50)
        assert (abs(simulation.displacement).max() > 1e-5) == grows


def test_a_step_that_is_too_long_is_refused_in_the_words_of_the_program():
    critical = livermark.critical_time_step(pair())
    with pytest.raises(livermark.InputError, match=r"^time_step: 0.11 s is too long for symplectic_euler .*: 0.1 s is the "
                                                   r"longest that is stable, and 0.08 s is safe; take that, or force"):
        livermark.Simulation(pair(), 1.1 * critical)
    livermark.Simulation(pair(), critical)
    with pytest.raises(livermark.InputError, match="^integrator: explicit_euler is unstable at every time step"):
        livermark.Simulation(pair(), 0.01, "explicit_euler")
    livermark.Simulation(pair(), 1e9, fixed=[0, 1])  # nothing can move


@pytest.mark.parametrize("num_threads", [1, 2])
@pytest.mark.parametrize("at_once", [1, 100_000])
def test_a_motion_that_is_not_finite_raises(bar, num_threads, at_once):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    step = 1.2 * livermark.critical_time_step(springs)
    simulation = livermark.Simulation(springs, step, num_threads=num_threads, force_time_step=True)
    velocity = numpy.random.default_rng(0).normal(size=(8, 3))
    simulation.velocity = velocity
    with pytest.raises(livermark.DivergedError, match=r"^the motion is not finite any more after \d+ steps, at t = "):
        for _ in range(100_000 // at_once):
            simulation.step(at_once)
    for read in (lambda: simulation.positions, lambda: simulation.displacement, lambda: simulation.velocity,
                 lambda: simulation.step()):
        with pytest.raises(livermark.DivergedError):
            read()
    simulation.displacement = numpy.zeros((8, 3))
    simulation.velocity = velocity
    other = livermark.Simulation(springs, step, force_time_step=True)
    other.velocity = velocity
    for moved in (simulation, other):
        moved.step(5)
    assert numpy.array_equal(simulation.positions, other.positions)


def test_springs_relax_under_a_force_and_at_once_where_they_stay():
    step, series, force = 0.02, [(0.3, 0.5), (0.2, 0.1)], 2.0
    simulation = livermark.Simulation(pair(), step, fixed=[0], forces=[[0, 0, 0], [force, 0, 0]], relaxation=series,
                                      damping=livermark.RayleighDamping(20.0, 0.0))
    simulation.step(1000)
    assert simulation.displacement[1, 0] == pytest.approx(force / (0.5 * 200.0), rel=1e-6)
    held = livermark.Simulation(pair(), step, fixed=[0], relaxation=series)
    held.displacement = [[0, 0, 0], [0.01, 0, 0]]
    held.relax(numpy.inf)
    held.step()
    assert held.velocity[1, 0] == pytest.approx(-step * 0.5 * 200.0 * 0.01, rel=1e-3)


@pytest.mark.parametrize("relaxation, words", [
    ([(-0.1, 1.0)], "relaxation: -0.1 is no part"), ([(0.5, 0.0)], "relaxation: a time is 0 s"),
    ([(0.5, 1.0), (0.5, 2.0)], "relaxation: the moduli are parts that fade, and their sum 1 has to be below 1")])
def test_a_series_that_is_none_is_refused(relaxation, words):
    with pytest.raises(livermark.InputError, match="^" + words):
        livermark.Simulation(pair(), 0.01, relaxation=relaxation)


@pytest.mark.parametrize("integrator", ["velocity_verlet", "heun", "runge_kutta_4"])
def test_springs_relax_to_the_same_rest_with_other_integrators(integrator):
    series, force = [(0.3, 0.5), (0.2, 0.1)], 2.0
    simulation = livermark.Simulation(pair(), 0.02, integrator, fixed=[0], forces=[[0, 0, 0], [force, 0, 0]],
                                      relaxation=series, damping=livermark.RayleighDamping(20.0, 0.0))
    simulation.step(1000)
    assert simulation.displacement[1, 0] == pytest.approx(force / (0.5 * 200.0), rel=1e-6)


def test_springs_with_hooke_s_law_around_nodes_relax(bar):
    springs = livermark.coupled_springs(*bar, 5000.0, 0.45, model="nodal_springs")
    fixed, forces = [0, 2, 4, 6], numpy.zeros((8, 3))
    forces[1::2, 1] = 1e-4
    moved = []
    for relaxation in ((), ((0.5, 0.01),)):
        simulation = livermark.Simulation(springs, 0.5 * livermark.critical_time_step(springs), fixed=fixed, forces=forces,
                                          relaxation=relaxation, damping=livermark.RayleighDamping(100.0, 0.0))
        simulation.step(20_000)
        moved.append(numpy.linalg.norm(simulation.displacement))
    assert 1.5 < moved[1] / moved[0] < 2.1  # sheared, with half of the shear modulus


def test_a_time_to_stay_is_not_negative():
    with pytest.raises(livermark.InputError, match="^seconds: -1"):
        livermark.Simulation(pair(), 0.01, relaxation=[(0.5, 1.0)]).relax(-1.0)


def threads_of_this_process():
    return len(os.listdir("/proc/self/task"))


def test_threads_are_bounded_and_given_back():
    before = threads_of_this_process()
    simulations = []
    with pytest.raises(livermark.InputError, match=r"^num_threads: all simulations that are alive have \d+ threads already"):
        while len(simulations) < 100_000:
            simulations.append(livermark.Simulation(pair(), 0.05, num_threads=8))
    assert threads_of_this_process() <= before + 64 * max(8, 2 * os.cpu_count())
    livermark.Simulation(pair(), 0.05).step()  # one more of one thread
    simulations.clear()
    assert threads_of_this_process() == before
    with pytest.raises(livermark.InputError, match=r"^num_threads: 32365 is too many for the \d+ cores"):
        livermark.Simulation(pair(), 0.05, num_threads=32365)
    assert threads_of_this_process() == before


def test_a_system_that_starts_no_threads_is_named():
    program = ("import livermark, os, resource\n"
               "springs = livermark.Springs([[0, 0, 0], [1, 0, 0]], [[0, 1]], 10.0, 1.0)\n"
               "if os.getuid() == 0:\n"
               "    os.setuid(65534)\n"  # limits are not those of root
               "resource.setrlimit(resource.RLIMIT_NPROC, (1, 1))\n"
               "try:\n"
               "    livermark.Simulation(springs, 1e-3, num_threads=4)\n"
               "except livermark.InputError as error:\n"
               "    print(error)\n"
               "livermark.Simulation(springs, 1e-3).step(3)\n")
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.startswith("num_threads: the system starts no 4 threads (")


#: A child of fork() that still works after a minute hangs.
FORK = """import livermark, numpy, os, signal, sys, threading, time
springs = livermark.Springs(numpy.eye(3), [[0, 1], [1, 2]], 10.0, 1.0)
simulation = livermark.Simulation(springs, 1e-3, num_threads={num_threads})
simulation.velocity = [[1, 0, 0], [0, 0, 0], [0, 1, 0]]
simulation.step(100)
{before}
child = os.fork()
if child == 0:
    signal.alarm(60)
    try:
        simulation.step(100)
        other = livermark.Simulation(springs, 1e-3, num_threads={num_threads})
        other.velocity = [[1, 0, 0], [0, 0, 0], [0, 1, 0]]
        other.step(simulation.num_steps)
        print(numpy.array_equal(simulation.positions, other.positions))
    except RuntimeError as error:
        print(error)
    sys.stdout.flush()
    del simulation
    sys.exit(0)  # with all destructors
status = os.waitpid(child, 0)[1]
sys.exit(0 if status == 0 else 1)
"""


@pytest.mark.parametrize("num_threads", [1, 2])
@pytest.mark.parametrize("before, said", [
    ("", "True"),
    ("threading.Thread(target=lambda: simulation.step(10**9), daemon=True).start()\ntime.sleep(2)",
     "this process was forked while another thread used the simulation")])
def test_a_process_that_is_forked_steps_or_says_why_not(num_threads, before, said):
    program = FORK.format(num_threads=num_threads, before=before)
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    # Between two of its many steps the other thread leaves the simulation whole.
    assert ended.returncode == 0 and ended.stdout.startswith((said, "True")), ended




def test_a_force_moves_the_free_body_as_newton_says():
    simulation = livermark.Simulation(pair(), 0.01, forces=[[3.0, 0, 0], [0, 0, 0]])
    simulation.step(5)
    assert (simulation.velocity.sum(axis=0)) == pytest.approx([0.15, 0, 0], rel=1e-12)
    simulation.set_force(0, [0, 0, 0])
    simulation.step(5)
    assert (simulation.velocity.sum(axis=0)) == pytest.approx([0.15, 0, 0], rel=1e-12)
    simulation.set_forces([[0, 0, 0], [0, -2.0, 0]])
    simulation.step(5)
    assert (simulation.velocity.sum(axis=0)) == pytest.approx([0.15, -0.1, 0], rel=1e-12)


def test_a_mask_of_zeros_and_ones_is_no_list_of_nodes(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    for kind in ("uint8", "int64"):
        mask = numpy.array([1, 1, 0, 0, 1, 0, 0, 0], kind)
        with pytest.raises(livermark.InputError, match=r"fixed: these are 8 zeros and ones.*astype\(bool\)"):
            livermark.largest_angular_frequency(springs, fixed=mask)
    assert livermark.largest_angular_frequency(springs, fixed=mask.astype(bool)) > 0.0


@pytest.mark.parametrize("num_threads", [1, 2])
def test_a_program_may_end_while_a_thread_steps(num_threads):
    program = ("import livermark, numpy, threading, time\n"
               "springs = livermark.Springs(numpy.eye(3), [[0, 1], [1, 2]], 10.0, 1.0)\n"
               f"simulation = livermark.Simulation(springs, 1e-3, num_threads={num_threads})\n"
               "threading.Thread(target=lambda: simulation.step(10**9), daemon=True).start()\n"
               "time.sleep(0.3)\n")
    for _ in range(3):
        ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60)
        assert ended.returncode == 0, ended.stderr


def test_fixed_components_stay_where_they_are_put(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    fixed = numpy.zeros((8, 3), bool)
    fixed[:4] = True
    fixed[7, 1] = True
    step = 0.5 * livermark.critical_time_step(springs, fixed=fixed)
    simulation = livermark.Simulation(springs, step, fixed=fixed, forces=numpy.full((8, 3), 1e-4))
    given = numpy.zeros((8, 3))
    given[0] = [1e-4, 2e-4, 3e-4]
    simulation.displacement = given
    simulation.velocity = numpy.ones((8, 3))
    simulation.step(100)
    moved = simulation.displacement
    assert moved[fixed] == pytest.approx(given[fixed], abs=1e-17)
    assert (moved[~fixed] != 0.0).all() and (simulation.velocity[fixed] == 0.0).all()
    assert numpy.array_equal(simulation.positions, springs.points + moved)


def test_ways_to_name_fixed_nodes_mean_the_same(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    mask = numpy.arange(8) < 4
    ways = ([0, 1, 2, 3], range(4), mask, numpy.repeat(mask[:, None], 3, axis=1))
    assert len({livermark.largest_angular_frequency(springs, way) for way in ways}) == 1
    assert livermark.largest_angular_frequency(springs, []) == livermark.largest_angular_frequency(springs)


def test_single_precision_is_near_double_precision(bar):
    springs = livermark.springs(*bar, 5000.0, 0.45)
    step = 0.5 * livermark.critical_time_step(springs, fixed=range(4))
    ends = []
    for kernel in ("simd_double", "simd_float"):
        simulation = livermark.Simulation(springs, step, fixed=range(4), forces=numpy.full((8, 3), 1e-3),
                                          damping=livermark.mass_proportional_damping(0.1, 50.0), kernel=kernel)
        simulation.step(200)
        ends.append(simulation.displacement)
    assert 0.0 < abs(ends[0] - ends[1]).max() < 1e-3 * abs(ends[0]).max()


def test_other_threads_run_while_steps_are_taken():
    count = 40
    grid = numpy.stack(numpy.meshgrid(*[numpy.arange(count)] * 3, indexing="ij"), -1).reshape(-1, 3) * 0.01
    number = numpy.arange(count**3).reshape(count, count, count)
    edges = numpy.concatenate([numpy.stack([number[:-1].ravel(), number[1:].ravel()], 1),
                               numpy.stack([number[:, :-1].ravel(), number[:, 1:].ravel()], 1),
                               numpy.stack([number[:, :, :-1].ravel(), number[:, :, 1:].ravel()], 1)])
    simulation = livermark.Simulation(livermark.Springs(grid, edges, 10.0, 1e-3), 1e-3)
    ticks = []
    stepping = threading.Thread(target=simulation.step, args=(199,))  # one piece: no other chance between two
    stepping.start()
    while stepping.is_alive():
        ticks.append(time.perf_counter())
        time.sleep(1e-4)
    assert len(ticks) > 10
    assert simulation.num_steps == 199


def test_damping_can_be_pickled_and_a_simulation_says_what_to_pickle():
    damping = pickle.loads(pickle.dumps(livermark.RayleighDamping(0.3, 1e-4)))
    assert (damping.alpha, damping.beta) == (0.3, 1e-4)
    with pytest.raises(TypeError, match="^a Simulation cannot be pickled; pickle its springs, displacement and velocity"):
        pickle.dumps(livermark.Simulation(pair(), 0.01))


def test_damping_has_the_ratios_that_were_asked_for():
    assert livermark.rayleigh_damping(0.05, 10.0, 60.0).ratio(10.0) == pytest.approx(0.05, rel=1e-12)
    assert livermark.rayleigh_damping(0.05, 10.0, 60.0).ratio(60.0) == pytest.approx(0.05, rel=1e-12)
    two = livermark.two_mode_damping(0.05, 10.0, 0.08, 60.0)
    assert (two.ratio(10.0), two.ratio(60.0)) == (pytest.approx(0.05), pytest.approx(0.08))
    assert livermark.mass_proportional_damping(0.1, 5.0).alpha == pytest.approx(1.0)
    assert livermark.stiffness_proportional_damping(0.1, 5.0).beta == pytest.approx(0.04)


@pytest.mark.parametrize("call, sentence", [
    (lambda: livermark.Simulation(pair(), 0.0), "time_step: 0 s; it has to be positive"),
    (lambda: livermark.Simulation(pair(), 0.05, "leapfrog"), "there is no integrator 'leapfrog'; known are: "),
    (lambda: livermark.Simulation(pair(), 0.05, kernel="gpu"), "there is no kernel 'gpu'; known are: simd_double, "),
    (lambda: livermark.Simulation(pair(), 0.05, num_threads=0), "num_threads: 0; there has to be one at least"),
    (lambda: livermark.Simulation(pair(), 0.05, fixed=[2]), "fixed: there is no node 2; nodes are numbered from 0 to 1"),
    (lambda: livermark.Simulation(pair(), 0.05, fixed=[0.5]), "fixed: node numbers have to be integers"),
    (lambda: livermark.Simulation(pair(), 0.05, fixed=numpy.ones(3, bool)), r"fixed: the shape is \(3,\); give "),
    (lambda: livermark.Simulation(pair(), 0.05, forces=[[0, 0, 0]]), r"forces: the shape is \(1, 3\); give "),
    (lambda: livermark.Simulation(pair(), 0.05).step(-1), "num_steps: -1; there is no way back in time"),
    (lambda: livermark.Simulation(pair(), 0.05).set_force(2, [0, 0, 0]), "node: there is no node 2"),
    (lambda: livermark.critical_time_step(pair(), fixed=[0, 1]), "fixed: nothing can move"),
    (lambda: livermark.RayleighDamping(-1.0), "alpha is -1 1/s and beta 0 s; both have to be finite and not negative"),
    (lambda: livermark.rayleigh_damping(0.1, 0.0, 1.0), "a damping ratio of 0.1 at 0 and 1 rad/s; ")])
def test_wrong_input_is_refused_with_a_sentence(call, sentence):
    with pytest.raises(livermark.InputError, match="^" + sentence):
        call()
