#!/usr/bin/env python3
"""Solves a problem or moves a scene of `livermark export` with springs of the Python package, for `livermark score`.

    livermark_springs.py out/liver_healthy/palpation.problem.h5 solution.csv [--model nodal_neo_hookean]
    livermark_springs.py out/liver_healthy/press_and_slide.scene.h5 motion.h5

At rest by Newton's method with the package's tangent and SciPy's sparse factors; in motion in explicit steps, as few in a frame as
are stable. It sees what every other engine sees, and no reference. Needs the module livermark and python3-scipy.
"""
import pathlib
import resource
import sys
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import files  # noqa: E402

SAFETY = 0.8  # of the longest stable step: a body that is pressed together is stiffer


def import_livermark():
    try:
        import livermark
        import scipy.sparse.linalg
        return livermark, scipy.sparse
    except ImportError as error:
        files.stop(f"Python finds no module {error.name}; install python3-scipy, and the package with pip install . in Livermark's root")


def springs_of(livermark, body, model):
    """Springs of a coupled model, or of a law with a spring on each edge and nothing else."""
    material = (values[body.region] for values in (body.young_modulus, body.poisson_ratio))
    density = body.density[body.region]
    if model in livermark.coupled_spring_models():
        return livermark.coupled_springs(body.points, body.tetrahedra, *material, model=model, density=density)
    if model in livermark.spring_laws():
        return livermark.springs(body.points, body.tetrahedra, *material, law=model, density=density)
    files.stop(f"there is no model {model}; there are: {', '.join([*livermark.coupled_spring_models(), *livermark.spring_laws()])}")


class SpringsAtRest:
    """Springs that Newton's method brings to rest under multiples of a load."""

    def __init__(self, springs, problem, sparse):
        self.springs, self.problem, self.sparse = springs, problem, sparse
        self.is_free = ~problem.is_prescribed.ravel()
        self.positions = problem.points.copy()

    def displacement_under(self, force_factor, displacement_factor):
        """Displacement (N, 3) [m] at rest, from where the last call ended."""
        problem, free = self.problem, self.is_free
        load = force_factor * problem.force
        target = (problem.points + displacement_factor * problem.prescribed)[problem.is_prescribed] - self.positions[problem.is_prescribed]
        size = None
        for _ in range(60):
            left = (self.springs.elastic_forces(self.positions) + load).ravel()
            moved = numpy.zeros(problem.points.size)
            moved[~free] = target
            rows, columns, values = self.springs.tangent(self.positions)
            tangent = self.sparse.csc_matrix((values, (rows, columns)), shape=(moved.size, moved.size))
            if target.any():
                left -= tangent @ moved
            norm = numpy.linalg.norm(left[free])
            size = max(size or 0.0, norm)
            if norm <= 1e-7 * size:
                return self.positions - problem.points
            factors = self.sparse.linalg.splu(tangent[free][:, free], permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0,
                                              options={"SymmetricMode": True})
            moved[free] = factors.solve(left[free])
            self.go(moved.reshape(-1, 3), load)
            target = numpy.zeros_like(target)
        files.stop(f"Newton's method finds no equilibrium at {force_factor:g} of the load")

    def go(self, moved, load):
        """Along a step as far as the energy falls; the whole of it where prescribed nodes have moved."""
        def energy(part):
            x = self.positions + part * moved
            value = self.springs.elastic_energy(x) - (load * x).sum()
            return value if numpy.isfinite(value) else numpy.inf
        part, now = 1.0, energy(0.0)
        while not moved[self.problem.is_prescribed].any() and energy(part) > now + 1e-12 * abs(now) and part > 1e-3:
            part *= 0.5
        self.positions = self.positions + part * moved


def move(livermark, source, output, model):
    scene = files.read_scene(source)
    start = time.process_time()
    springs = springs_of(livermark, scene, model)
    damping, frame = livermark.RayleighDamping(alpha=scene.damping, beta=0.0), scene.time[1] - scene.time[0]
    both = numpy.concatenate([scene.held, scene.tool])
    stable = livermark.critical_time_step(springs, damping=damping, fixed=scene.held)
    substeps = int(numpy.ceil(frame / (SAFETY * stable)))
    simulation = livermark.Simulation(springs, frame / substeps, damping=damping, fixed=both, kernel="simd_float")
    setup, seconds = time.process_time() - start, 0.0
    displacement, force = [simulation.displacement], [numpy.zeros(3)]
    for k in range(1, len(scene.time)):
        begin = time.process_time()
        if k == scene.last_held + 1:
            state = simulation.displacement, simulation.velocity
            simulation = livermark.Simulation(springs, frame / substeps, damping=damping, fixed=scene.held, kernel="simd_float")
            simulation.displacement, simulation.velocity = state
        for step in range(1, substeps + 1):
            simulation.step()
            if k <= scene.last_held:
                now = simulation.displacement
                now[scene.tool] = scene.way[k - 1] + step / substeps * (scene.way[k] - scene.way[k - 1])
                simulation.displacement = now
        seconds += time.process_time() - begin
        displacement.append(simulation.displacement)
        pull = springs.elastic_forces(simulation.positions)[scene.tool].sum(axis=0)
        force.append(pull if k <= scene.last_held else numpy.zeros(3))
    displacement = numpy.array(displacement)
    if not numpy.isfinite(displacement).all():
        files.stop(f"{substeps} steps in a frame have lost the body: positions are no numbers")
    files.write_motion(output, displacement, force, seconds / (len(scene.time) - 1))
    return {"seconds_per_frame": seconds / (len(scene.time) - 1), "setup_seconds": setup}, substeps


def main():
    source, output, settings = files.command_line({"model": "nodal_neo_hookean"})
    livermark, sparse = import_livermark()
    if files.is_scene(source):
        numbers, settings["substeps"] = move(livermark, source, output, settings["model"])
    else:
        numbers = files.solve_rest(
            source, output, lambda problem: SpringsAtRest(springs_of(livermark, problem, settings["model"]), problem, sparse),
            time.process_time)
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    files.report("livermark_springs", livermark.__version__, settings, memory_bytes=memory, **numbers)


main()
