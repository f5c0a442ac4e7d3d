"""A program that is not part of the suite, of numpy and the package's springs, moves the exported scene and is scored."""
import subprocess

import h5py
import numpy
import pytest
from conftest import BINARY

import livermark

FRAME_STEPS = 8  # what the arena takes for these springs


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    printed = subprocess.run([BINARY, "export", "liver_healthy", "press_and_slide", "-o", folder], check=True,
                             capture_output=True, text=True).stdout
    with h5py.File(printed.splitlines()[0]) as file:
        yield file


def force_of(springs, positions, nodes):
    """The sum of the forces of springs on some nodes [N]."""
    ends = positions[springs.edges]
    along = ends[:, 1] - ends[:, 0]
    length = numpy.linalg.norm(along, axis=1)
    pull = (springs.stiffness * (1 - springs.rest_length / length))[:, None] * along
    return pull[numpy.isin(springs.edges[:, 0], nodes)].sum(0) - pull[numpy.isin(springs.edges[:, 1], nodes)].sum(0)


def simulation_of(scene, springs, fixed):
    time = scene["tool/time"][:]
    damping = livermark.RayleighDamping(alpha=scene["tool"].attrs["mass_damping"], beta=0.0)
    return livermark.Simulation(springs, time[1] / FRAME_STEPS, damping=damping, fixed=fixed)


def move(scene):
    """Displacement (K, N, 3) and force (K, 3) of Lloyd's springs."""
    region = scene["region"][:]
    material = {name: scene["materials"][name][:][region] for name in ("young_modulus", "poisson_ratio", "density")}
    springs = livermark.springs(scene["points"][:], scene["tetrahedra"][:], **material, law="lloyd")
    held, nodes, way = scene["held"][:], scene["tool/nodes"][:], scene["tool/displacement"][:]
    simulation = simulation_of(scene, springs, numpy.concatenate([held, nodes]))
    displacement, force = [simulation.displacement], [numpy.zeros(3)]
    for k in range(1, len(way)):
        holds = k <= scene["tool"].attrs["last_record_held"]
        if not holds and k - 1 == scene["tool"].attrs["last_record_held"]:
            state = simulation.displacement, simulation.velocity
            simulation = simulation_of(scene, springs, held)
            simulation.displacement, simulation.velocity = state
        for s in range(1, FRAME_STEPS + 1):
            simulation.step()
            if holds:
                now = simulation.displacement
                now[nodes] = way[k - 1] + s / FRAME_STEPS * (way[k] - way[k - 1])
                simulation.displacement = now
        displacement.append(simulation.displacement)
        force.append(force_of(springs, simulation.positions, nodes) if holds else numpy.zeros(3))
    return numpy.array(displacement), numpy.array(force)


def score(file, name, folder):
    """The row of the table."""
    done = subprocess.run([BINARY, "score", "liver_healthy", "press_and_slide", file, "--name", name, "--output", folder],
                          capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def test_a_motion_of_somebody_else_is_judged_as_the_arena_judges_it(scene, tmp_path):
    displacement, force = move(scene)
    for name, kept in ("all", displacement), ("every_fourth", displacement[::4]):
        with h5py.File(tmp_path / f"{name}.h5", "w", libver="latest") as file:
            file["displacement"] = kept.astype("f4")
            file["force"] = force
            file.attrs["seconds_per_frame"] = 0.004
        status, _, said = score(tmp_path / f"{name}.h5", name, tmp_path)
        assert status == 0, said
    subprocess.run([BINARY, "arena", "--mesh", "1", "--method", "lloyd", "--budget", "4", "--output", tmp_path], check=True)
    found = {}
    for name in ("press_and_slide.all", "press_and_slide.every_fourth", "arena"):
        with h5py.File(tmp_path / "liver_healthy" / f"{name}.h5") as file:
            found[name] = {key: file["arena"][key][0] for key in ("contact_error", "force_error", "after_error",
                                                                  "volume_error", "budget")}
    assert found["press_and_slide.all"] == found["press_and_slide.every_fourth"]
    for key, value in found["arena"].items():
        assert found["press_and_slide.all"][key] == pytest.approx(value, rel=0.02), key


def test_what_is_no_motion_of_the_scene_is_refused(scene, tmp_path):
    def said_of(displacement, force, **options):
        with h5py.File(tmp_path / "bad.h5", "w", **options) as file:
            file["displacement"] = displacement
            file["force"] = force
        status, _, said = score(tmp_path / "bad.h5", "bad", tmp_path)
        assert status == 2
        return said

    num_records, num_nodes = len(scene["tool/time"]), len(scene["points"])
    field, force = numpy.zeros((3, num_nodes, 3), "f4"), numpy.zeros((num_records, 3))
    assert "has 3 fields; it needs 97" in said_of(field, force, libver="latest")
    assert "has shape (3,3) instead of (97,3)" in said_of(field, force[:3], libver="latest")
    assert "instead of 32-bit" in said_of(field.astype("f8"), force, libver="latest")
    assert "libver='latest'" in said_of(field, force)
    assert not list(tmp_path.glob("**/*.bad.h5"))
