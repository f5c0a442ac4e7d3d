#!/usr/bin/env python3
"""Solves a problem or moves a scene of `livermark export` with SOFA, for `livermark score`.

    sofa.py out/beam/beam_bend.problem.h5 solution.csv [--law corotational]
    sofa.py out/liver_healthy/press_and_slide.scene.h5 motion.h5

In motion it steps through the .sofa.py that `livermark export` writes beside the scene; at rest it builds the scene here, and
Newton's method finds the equilibrium of each multiple of the load. Needs the modules of SofaPython3 on the PYTHONPATH.
"""
import importlib.util
import json
import os
import pathlib
import resource
import sys
import time

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import files  # noqa: E402

LAWS = {"linear": "small", "corotational": "polar"}  # method of TetrahedronFEMForceField
PLUGINS = ["Constraint.Projective", "LinearSolver.Direct", "LinearSolver.Iterative", "Mass", "MechanicalLoad", "ODESolver.Backward",
           "SolidMechanics.FEM.Elastic", "SolidMechanics.FEM.HyperElastic", "SolidMechanics.Spring", "StateContainer",
           "Topology.Container.Dynamic"]
NEWTON_STEPS, PER_FRAME = 50, 4  # the exported scene takes four steps in a frame


def import_sofa():
    """The module Sofa, with the plugins that both uses need. It prints a lot while it loads."""
    try:
        import Sofa
        import SofaRuntime
        import Sofa.Simulation
    except ImportError:
        files.stop("Python finds no module Sofa; build SOFA with SofaPython3, and put its site-packages on the PYTHONPATH as README.md says")
    for plugin in PLUGINS:
        SofaRuntime.importPlugin("Sofa.Component." + plugin)
    return Sofa


def add_springs(body, path):
    """Springs of `livermark springs BODY --for sofa`, a row (i, j, ks, kd, length) each."""
    if not path.is_file():
        files.stop(f"{path} does not exist, and has the springs; write it with livermark springs {path.parent.name} --for sofa "
                   f"-o {path.parent}")
    arrays = json.loads(path.read_text())["arrays"]
    edges, stiffness, length = (arrays[name]["values"] for name in ("edges", "stiffness", "rest_length"))
    body.addObject("SpringForceField", spring=[[*ends, k, 0.0, l] for ends, k, l in zip(edges, stiffness, length)])


def add_tetrahedra(body, problem, law):
    """A force field for each region."""
    for number, (young, nu) in enumerate(zip(problem.young_modulus.tolist(), problem.poisson_ratio.tolist())):
        region = body.addChild(f"region_{number}")
        region.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=problem.points.tolist(),
                         tetrahedra=problem.tetrahedra[problem.region == number].tolist())
        if law == "neo_hookean":
            mu = 0.5 * young / (1.0 + nu)
            region.addObject("TetrahedronHyperelasticityFEMForceField", topology="@tetrahedra", materialName="NeoHookean",
                             ParameterSet=[mu, 2.0 * mu * nu / (1.0 - 2.0 * nu)])
        else:
            region.addObject("TetrahedronFEMForceField", topology="@tetrahedra", youngModulus=young, poissonRatio=nu, method=LAWS[law])


class BodyAtRest:
    """A body that Newton's method brings to rest under any multiple of a load."""

    def __init__(self, sofa, problem, law, springs):
        self.sofa, self.problem = sofa, problem
        self.root = sofa.Core.Node("root")
        self.root.gravity = [0.0, 0.0, 0.0]
        self.root.addObject("DefaultAnimationLoop")
        body = self.root.addChild("livermark")
        body.addObject("NewtonRaphsonSolver", name="newton", maxNbIterationsNewton=NEWTON_STEPS, relativeInitialStoppingThreshold=1e-9,
                       relativeSuccessiveStoppingThreshold=0.0, absoluteResidualStoppingThreshold=1e-12,
                       maxNbIterationsLineSearch=8, warnWhenLineSearchFails=False)
        body.addObject("StaticSolver", newtonSolver="@newton")
        body.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
        body.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=problem.points.tolist(),
                       tetrahedra=problem.tetrahedra.tolist())
        self.nodes = body.addObject("MechanicalObject", name="nodes", template="Vec3d", position=problem.points.tolist())
        for components in numpy.unique(problem.is_prescribed, axis=0):
            nodes = numpy.flatnonzero((problem.is_prescribed == components).all(axis=1)).tolist()
            if components.any():
                body.addObject("PartialFixedProjectiveConstraint", indices=nodes, fixedDirections=[int(c) for c in components])
        self.loaded = numpy.flatnonzero(problem.force.any(axis=1))
        if len(self.loaded):
            self.load = body.addObject("ConstantForceField", indices=self.loaded.tolist(),
                                       forces=numpy.zeros((len(self.loaded), 3)).tolist())
        if law == "springs":
            add_springs(body, springs)
        else:
            add_tetrahedra(body, problem, law)
        sofa.Simulation.init(self.root)

    def displacement_under(self, force_factor, displacement_factor):
        """Displacement (N, 3) [m] at rest, from where the last call ended."""
        if len(self.loaded):
            self.load.forces.value = force_factor * self.problem.force[self.loaded]
        with self.nodes.position.writeable() as positions:
            positions[self.problem.is_prescribed] = (self.problem.points +
                                                     displacement_factor * self.problem.prescribed)[self.problem.is_prescribed]
        self.sofa.Simulation.animate(self.root, 1.0)
        displacement = self.nodes.position.value - self.problem.points
        if not numpy.isfinite(displacement).all():
            files.stop(f"SOFA found no equilibrium at {force_factor:g} of the load")
        return displacement


def move(source, output):
    """Returns the cost of a motion by SOFA's own clock."""
    scene = files.read_scene(source)
    path = files.stem_of(source).with_name(files.stem_of(source).name + ".sofa.py")
    if not path.is_file():
        files.stop(f"{path} does not exist; write it with livermark export")
    found = importlib.util.spec_from_file_location("exported", path)
    exported = importlib.util.module_from_spec(found)
    found.loader.exec_module(exported)
    sofa, start = import_sofa(), time.monotonic()
    root = sofa.Core.Node("root")
    exported.createScene(root)
    sofa.Simulation.init(root)
    setup, start, kept = time.monotonic() - start, time.monotonic(), [scene.points]
    for _ in scene.time[1:]:
        for _ in range(PER_FRAME):
            sofa.Simulation.animate(root, root.dt.value)
        kept.append(numpy.array(root.livermark.nodes.position.value, float))
    frame = (time.monotonic() - start) / (len(scene.time) - 1)
    displacement = numpy.array(kept) - scene.points
    if not numpy.isfinite(displacement).all():
        files.stop("SOFA's steps have lost the body: positions are no numbers")
    files.write_motion(output, displacement, files.neo_hookean_forces_on_tool(scene, displacement), frame)
    return {"seconds_per_frame": frame, "setup_seconds": setup}


def main():
    source, output, settings = files.command_line({"law": "corotational"})
    if settings["law"] not in (*LAWS, "neo_hookean", "springs"):
        files.stop("--law is linear, corotational, neo_hookean or springs")
    if files.is_scene(source):
        numbers, settings = move(source, output), {"law": "neo_hookean", "substeps": PER_FRAME}
    else:
        sofa, springs = import_sofa(), source.with_name(source.resolve().parent.name + ".sofa.json")
        numbers = files.solve_rest(source, output, lambda problem: BodyAtRest(sofa, problem, settings["law"], springs))
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    files.report("sofa", os.environ.get("SOFA_VERSION", "unknown"), settings, memory_bytes=memory, **numbers)
    sys.stdout.flush()
    os._exit(0)  # SOFA prints when it is unloaded, and the report has to be the last line


main()
