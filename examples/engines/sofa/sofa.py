#!/usr/bin/env python3
"""Solves a problem or moves a scene of `livermark export` with SOFA, for `livermark score`.

    sofa.py out/beam/beam_bend.problem.h5 solution.csv [--law corotational]
    sofa.py out/liver_healthy/large_palpation.problem.h5 solution.csv [--law neo_hookean] [--penalty 100] [--split 4]
    sofa.py out/liver_healthy/press_and_slide.scene.h5 motion.h5

In motion it steps through the .sofa.py that `livermark export` writes beside the scene; at rest it builds the scene here, and
Newton's method finds the equilibrium of each multiple of the load. A ball that touches is a SphereForceField: springs of one
stiffness between its surface and the points that are inside. A capsule, vessels as lines and elastic foundations are springs. Needs
the modules of SofaPython3 on the PYTHONPATH.
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
MAPPING = "Mapping.Linear"  # only where points move with the tetrahedra: of facets below a ball or on springs, and of vessels
KNOWS = ["load_case/foundation", "capsule", "vessels"]
PLUGINS = ["Constraint.Projective", "LinearSolver.Direct", "LinearSolver.Iterative", "Mass", "MechanicalLoad", "ODESolver.Backward",
           "SolidMechanics.FEM.Elastic", "SolidMechanics.FEM.HyperElastic", "SolidMechanics.Spring", "StateContainer",
           "Topology.Container.Dynamic"]
NEWTON_STEPS, PER_FRAME = 50, 4  # the exported scene takes four steps in a frame
SHORTEST_STEP, DEEPEST = 1e-3, 0.25  # of a press; of the ball's radius, where the ball has gone through a facet


def import_sofa(*others):
    """The module Sofa, with the plugins that all uses need, and others. It prints a lot while it loads."""
    try:
        import Sofa
        import SofaRuntime
        import Sofa.Simulation
    except ImportError:
        files.stop("Python finds no module Sofa; build SOFA with SofaPython3, and put its site-packages on the PYTHONPATH as README.md says")
    for plugin in (*PLUGINS, *others):
        SofaRuntime.importPlugin("Sofa.Component." + plugin)
    return Sofa


def read_springs(path):
    """Arrays of `livermark springs BODY --for sofa`, by name."""
    if not path.is_file():
        files.stop(f"{path} does not exist, and has the springs; write it with livermark springs {path.parent.name} --for sofa "
                   f"-o {path.parent}")
    return {name: array["values"] for name, array in json.loads(path.read_text())["arrays"].items()}


def add_springs(body, arrays, *names):
    """Springs of three of these arrays: ends, stiffness and length. A row (i, j, ks, kd, length) each."""
    if names[0] not in arrays:
        files.stop(f"the springs have no {names[0]}, and the body has; write them again with livermark springs --for sofa")
    rows = [[*ends, k, 0.0, l] for ends, k, l in zip(*(arrays[name] for name in names))]
    body.addObject("SpringForceField", spring=rows)


def add_points(body, name, positions):
    """A node whose points (P, 3) move with the tetrahedra that have them."""
    node = body.addChild(name)
    node.addObject("MechanicalObject", name="points", template="Vec3d", position=positions)
    node.addObject("BarycentricMapping")
    return node


def add_foundation(body, problem):
    """Springs to where points are at rest: the middles of the sides of each facet, each of a third of its area, by which the energy of
    linear elements is exact."""
    foundation = problem.foundation
    if foundation.normal_only.any():
        files.stop("the problem has elastic springs along normals alone, and those of SOFA resist all motion; choose another load case")
    ends = foundation.nodes[:, [[0, 1], [1, 2], [2, 0]]]
    node = add_points(body, "foundation", problem.points[ends].mean(axis=2).reshape(-1, 3).tolist())
    node.addObject("RestShapeSpringsForceField", stiffness=numpy.repeat(foundation.stiffness * foundation.area / 3.0, 3).tolist())


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


def node_stiffness(problem):
    """Stiffness (N) [N/m] that the tetrahedra of a node oppose it with while all others are held, the mean of three directions:
    the sum of V |grad N|^2 (lambda + 4 mu) / 3, of small strains."""
    young, nu = problem.young_modulus[problem.region], problem.poisson_ratio[problem.region]
    mu, lame = 0.5 * young / (1.0 + nu), young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    corners = problem.points[problem.tetrahedra]
    edges = numpy.moveaxis(corners[:, 1:] - corners[:, :1], 1, 2)  # an edge in each column
    gradients = numpy.linalg.inv(edges)  # a row for each of nodes 1 to 3
    gradients = numpy.concatenate([-gradients.sum(axis=1, keepdims=True), gradients], axis=1)
    own = (numpy.linalg.det(edges) / 6.0 * (lame + 4.0 * mu) / 3.0)[:, None] * (gradients ** 2).sum(axis=2)
    return numpy.bincount(problem.tetrahedra.ravel(), own.ravel(), len(problem.points))


def points_of_facets(problem, split):
    """Points that touch, where each edge of the surface is split in so many parts: the nodes (P, 3) that a point lies between, and
    the part (P, 3) of each. A point on an edge is there once, and points that the ball cannot reach are left out."""
    lattice = numpy.array([(i, j, split - i - j) for i in range(split + 1) for j in range(split + 1 - i)])
    nodes, parts = numpy.repeat(problem.triangles, len(lattice), axis=0), numpy.tile(lattice, (len(problem.triangles), 1))
    nodes = numpy.where(parts > 0, nodes, -1)  # no part of the point, so that its edge or node is the same in each facet
    order = numpy.argsort(nodes, axis=1)
    rows = numpy.hstack([numpy.take_along_axis(nodes, order, 1), numpy.take_along_axis(parts, order, 1)])
    rows = numpy.unique(rows, axis=0)
    nodes, parts, ball = numpy.maximum(rows[:, :3], 0), rows[:, 3:] / split, problem.touch
    distance = numpy.linalg.norm(place(problem.points, nodes, parts) - ball.start, axis=1)
    near = distance < 2.0 * ball.radius + numpy.linalg.norm(ball.press)
    return nodes[near], parts[near]


def place(positions, nodes, parts):
    """Points (P, 3) of facets where nodes are at positions (N, 3)."""
    return numpy.einsum("pc,pcd->pd", parts, positions[nodes])


class BodyAtRest:
    """A body that Newton's method brings to rest under any multiple of a load."""

    def __init__(self, sofa, problem, settings, springs):
        self.sofa, self.problem, law, self.pressed = sofa, problem, settings["law"], 0.0
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
        arrays = read_springs(springs) if law == "springs" or problem.has_capsule or problem.has_vessels else {}
        if law == "springs":  # which have the capsule too
            add_springs(body, arrays, "edges", "stiffness", "rest_length")
        else:
            add_tetrahedra(body, problem, law)
            if problem.has_capsule:
                add_springs(body, arrays, "capsule_edges", "capsule_stiffness", "capsule_length")
        if problem.has_vessels:
            add_springs(add_points(body, "vessels", arrays.get("vessel_points", [])), arrays, "vessel_springs", "vessel_stiffness",
                        "vessel_length")
        if problem.foundation:
            add_foundation(body, problem)
        if problem.touch:
            self.add_ball(body, settings["penalty"], settings["split"])
        sofa.Simulation.init(self.root)

    def add_ball(self, body, penalty, split):
        """A sphere that pushes points of the facets of the body out, or its nodes alone where edges are not split."""
        problem, ball = self.problem, self.problem.touch
        if split == 1:
            each = numpy.arange(len(problem.points))[:, None]
            self.touching = numpy.hstack([each, each, each]), numpy.tile([1.0, 0.0, 0.0], (len(each), 1))
        else:
            self.touching = points_of_facets(problem, split)
            body = add_points(body, "surface", place(problem.points, *self.touching).tolist())
        surface = numpy.unique(problem.triangles)
        # A node, with the points around it, has a penalty of so many times its own stiffness: the mean over the surface.
        self.stiffness = penalty * float(node_stiffness(problem)[surface].mean()) / split ** 2
        self.sphere = body.addObject("SphereForceField", center=ball.start.tolist(), radius=ball.radius, stiffness=self.stiffness,
                                     damping=0.0)

    def displacement_under(self, force_factor, displacement_factor):
        """Displacement (N, 3) [m] at rest, from where the last call ended."""
        if len(self.loaded):
            self.load.forces.value = force_factor * self.problem.force[self.loaded]
        if self.problem.touch:
            self.press_to(displacement_factor)
        else:
            self.solve(displacement_factor)
        displacement = self.nodes.position.value - self.problem.points
        if not numpy.isfinite(displacement).all():
            files.stop(f"SOFA found no equilibrium at {force_factor:g} of the load")
        return displacement

    def solve(self, displacement_factor):
        with self.nodes.position.writeable() as positions:
            positions[self.problem.is_prescribed] = (self.problem.points +
                                                     displacement_factor * self.problem.prescribed)[self.problem.is_prescribed]
        if self.problem.touch:
            self.sphere.center.value = self.problem.touch.start + displacement_factor * self.problem.touch.press
        self.sofa.Simulation.animate(self.root, 1.0)

    def press_to(self, part):
        """Moves the ball to a part of its press, in steps that are halved where Newton's method finds no equilibrium, or one with
        the ball through a facet, whose points then push against each other."""
        step = part - self.pressed
        while self.pressed < part:
            goal, before = min(part, self.pressed + step), numpy.array(self.nodes.position.value)
            self.solve(goal)
            found = self.contact(goal)
            if found["at_rest"] and found["deepest_point"] < DEEPEST * self.problem.touch.radius:
                self.pressed = goal
                continue
            step *= 0.5
            if step < SHORTEST_STEP:
                files.stop(f"SOFA found no equilibrium at {part:g} of the load")
            with self.nodes.position.writeable() as positions:
                positions[:] = before

    def contact(self, part=1.0):
        """Numbers of the report where the ball is at a part of its press: the force [N] of the penalty on all points, whether what
        is out of balance is less than a millionth of it, and by how much nodes and points are inside the ball [m]."""
        ball, positions = self.problem.touch, numpy.array(self.nodes.position.value)
        points = place(positions, *self.touching)
        outwards = points - ball.start - part * ball.press
        distance = numpy.linalg.norm(outwards, axis=1)
        inside = distance < ball.radius
        push = self.stiffness * (ball.radius / distance[inside] - 1.0)[:, None] * outwards[inside]
        force, left = float(numpy.linalg.norm(push.sum(axis=0))), float(numpy.linalg.norm(self.nodes.force.value))
        return {"force": force, "out_of_balance": left, "at_rest": left <= 1e-6 * force + 1e-9,
                "points_in_touch": int(inside.sum()), "stiffness_of_point": self.stiffness,
                "deepest": files.deepest(ball, positions, part), "deepest_point": files.deepest(ball, points, part)}


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


def needs_mapping(source, touches_by_points):
    problem = files.read_problem(source, KNOWS)
    return touches_by_points or problem.has_vessels or problem.foundation is not None


def main():
    source, output, settings = files.command_line({"law": "corotational", "penalty": 100.0, "split": 4})
    if settings["law"] not in (*LAWS, "neo_hookean", "springs"):
        files.stop("--law is linear, corotational, neo_hookean or springs")
    if settings["split"] < 1 or settings["penalty"] <= 0.0:
        files.stop("--split is a whole number of 1 or more, and --penalty above 0")
    if files.is_scene(source):
        numbers, settings = move(source, output), {"law": "neo_hookean", "substeps": PER_FRAME}
    else:
        touches = files.read_ball(source) is not None
        mapping = [MAPPING] if needs_mapping(source, touches and settings["split"] > 1) else []
        sofa, springs = import_sofa(*mapping), source.with_name(source.resolve().parent.name + ".sofa.json")
        numbers = files.solve_rest(source, output, lambda problem: BodyAtRest(sofa, problem, settings, springs), knows_balls=True,
                                   knows=KNOWS)
        settings = settings if touches else {"law": settings["law"]}
    memory = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    files.report("sofa", os.environ.get("SOFA_VERSION", "unknown"), settings, memory_bytes=memory, **numbers)
    sys.stdout.flush()
    os._exit(0)  # SOFA prints when it is unloaded, and the report has to be the last line


main()
