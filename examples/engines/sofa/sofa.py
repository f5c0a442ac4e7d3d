#!/usr/bin/env python3
"""Solves a problem or moves a scene of `livermark export` with SOFA, for `livermark score`.

    sofa.py out/beam/beam_bend.problem.h5 solution.csv [--law corotational] [--steps 200] [--time_step 0.1]
    sofa.py out/liver_healthy/press_and_slide.scene.h5 motion.h5

In motion it runs the .sofa.py that `livermark export` writes beside the scene; at rest it builds the scene here, with implicit
steps until the last. Either way runSofa loads this file, which asks for the positions after each step. Needs runSofa with
SofaPython3 on the PATH. Nodes of prescribed displacement are moved before the first step.
"""
import importlib.util
import os
import pathlib
import sys
import tempfile

import numpy

JOB = "LIVERMARK_SOFA_JOB"  # environment variable: the .npz with what the scene needs


def recorder(node, root, job):
    """A controller that keeps the positions (N, 3) after every job["every"] steps, and writes them when all are there."""
    import Sofa

    class Recorder(Sofa.Core.Controller):
        def __init__(self, *arguments, **keywords):
            super().__init__(*arguments, **keywords)
            self.steps, self.kept = 0, []

        def onAnimateEndEvent(self, _event):
            self.steps += 1
            if self.steps % int(job["every"]) == 0:
                self.kept.append(numpy.array(node.nodes.position.value, float))
                if self.steps == int(job["steps"]):
                    numpy.save(str(job["output"]), numpy.array(self.kept))

    root.addObject(Recorder(name="recorder"))


def build_rest(root, job):
    """Tetrahedra with nodal forces and constrained nodes, in long implicit steps."""
    root.dt, root.gravity = float(job["time_step"]), [0.0, 0.0, 0.0]
    root.addObject("RequiredPlugin", pluginName=[
        "Sofa.Component.Constraint.Projective", "Sofa.Component.LinearSolver.Direct", "Sofa.Component.Mass",
        "Sofa.Component.MechanicalLoad", "Sofa.Component.ODESolver.Backward", "Sofa.Component.SolidMechanics.FEM.Elastic",
        "Sofa.Component.SolidMechanics.FEM.HyperElastic", "Sofa.Component.StateContainer",
        "Sofa.Component.Topology.Container.Dynamic"])
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("livermark")
    rest, moved = job["points"], job["points"] + job["prescribed"]
    body.addObject("EulerImplicitSolver", rayleighMass=1.0, rayleighStiffness=0.0)
    body.addObject("SparseLDLSolver", template="CompressedRowSparseMatrixMat3x3d")
    body.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=rest.tolist(),
                   tetrahedra=job["tetrahedra"].tolist())
    body.addObject("MechanicalObject", name="nodes", template="Vec3d", position=moved.tolist(), rest_position=rest.tolist())
    body.addObject("DiagonalMass", name="mass", topology="@tetrahedra", vertexMass=job["mass"].tolist())
    for components in numpy.unique(job["is_prescribed"], axis=0):
        nodes = numpy.flatnonzero((job["is_prescribed"] == components).all(axis=1)).tolist()
        if components.any():
            body.addObject("PartialFixedProjectiveConstraint", indices=nodes, fixedDirections=[int(c) for c in components])
    loaded = numpy.flatnonzero(job["force"].any(axis=1))
    body.addObject("ConstantForceField", indices=loaded.tolist(), forces=job["force"][loaded].tolist())
    for number, (young, nu) in enumerate(zip(job["young_modulus"].tolist(), job["poisson_ratio"].tolist())):
        region = body.addChild(f"region_{number}")
        region.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=rest.tolist(),
                         tetrahedra=job["tetrahedra"][job["region"] == number].tolist())
        if str(job["law"]) == "neo_hookean":
            mu = 0.5 * young / (1.0 + nu)
            region.addObject("TetrahedronHyperelasticityFEMForceField", topology="@tetrahedra", materialName="NeoHookean",
                             ParameterSet=[mu, 2.0 * mu * nu / (1.0 - 2.0 * nu)])
        else:
            region.addObject("TetrahedronFEMForceField", topology="@tetrahedra", youngModulus=young, poissonRatio=nu,
                             method={"linear": "small", "corotational": "polar"}[str(job["law"])])
    return body


def createScene(root):
    """What runSofa calls."""
    job = numpy.load(os.environ[JOB])
    if "scene" in job:
        found = importlib.util.spec_from_file_location("exported", str(job["scene"]))
        exported = importlib.util.module_from_spec(found)
        found.loader.exec_module(exported)
        exported.createScene(root)
        body = root.livermark
    else:
        body = build_rest(root, job)
    recorder(body, root, job)


def node_masses(problem):
    corners = problem.points[problem.tetrahedra]
    volume = numpy.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    return numpy.bincount(problem.tetrahedra.ravel(), numpy.repeat(0.25 * problem.density[problem.region] * volume, 4),
                          len(problem.points))


def run_sofa(files, job):
    """Positions (records, N, 3) that the recorder kept, and what files.run() says."""
    sofa = files.program("runSofa", "build SOFA with SofaPython3 as README.md says")
    with tempfile.TemporaryDirectory() as folder:
        kept, path = pathlib.Path(folder) / "kept.npy", pathlib.Path(folder) / "job.npz"
        numpy.savez(path, output=str(kept), **job)
        ran = files.run([sofa, "-g", "batch", "-n", job["steps"], "-l", "SofaPython3", pathlib.Path(__file__).resolve()], folder,
                        **{JOB: str(path)})
        if not kept.exists():
            last = [line for line in ran.printed.splitlines() if "ERROR" in line][-1:] or ["see runSofa on the scene by hand"]
            files.stop(f"SOFA did not come to its last step: {last[0]}")
        return numpy.load(kept), ran


def main():
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
    import files
    source, output, settings = files.command_line({"law": "corotational", "steps": 200, "time_step": 0.1})
    if settings["law"] not in ("linear", "corotational", "neo_hookean"):
        files.stop("--law is linear, corotational or neo_hookean")
    if files.is_scene(source):
        scene = files.read_scene(source)
        exported = files.stem_of(source).with_name(files.stem_of(source).name + ".sofa.py").resolve()
        if not exported.is_file():
            files.stop(f"{exported} does not exist; write it with livermark export")
        num_frames, every = len(scene.time) - 1, 4  # the exported scene takes four steps in a frame
        positions, ran = run_sofa(files, {"scene": str(exported), "steps": every * num_frames, "every": every})
        displacement = numpy.concatenate([numpy.zeros((1, *scene.points.shape)), positions - scene.points])
        seconds = ran.seconds / num_frames
        files.write_motion(output, displacement, files.neo_hookean_forces_on_tool(scene, displacement), seconds)
        settings = {"law": "neo_hookean", "substeps": every}
    else:
        problem = files.read_problem(source)
        if problem.press_depth > 0.0 or problem.follows:
            files.stop("the problem presses to a depth or has a pressure that follows the surface; choose another load case")
        fields = {name: getattr(problem, name) for name in ("points", "tetrahedra", "region", "young_modulus", "poisson_ratio",
                                                            "force", "is_prescribed", "prescribed")}
        positions, ran = run_sofa(files, {**fields, **settings, "mass": node_masses(problem), "every": settings["steps"]})
        files.write_solution(output, problem.points, positions[-1] - problem.points)
        seconds = None
    files.report("sofa", os.environ.get("SOFA_VERSION", "unknown"), settings, seconds_per_frame=seconds, setup_seconds=0.0,
                 solve_seconds=ran.seconds, memory_bytes=ran.memory)


if __name__ == "__main__":
    main()
