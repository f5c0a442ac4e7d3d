"""The files that Livermark exchanges with an engine, for the adapters in Python: problems and scenes of `livermark export`, and
what `livermark score` reads. The layout is in results/schema.md, "The problem" and "Tool scenes". All is in SI units; N is the
number of nodes, M of tetrahedra, K of records and T of nodes of the tool."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time
from types import SimpleNamespace

import h5py
import numpy


def stop(reason):
    """Ends an adapter that cannot go on, with one sentence."""
    print(f"{pathlib.Path(sys.argv[0]).stem}: {reason}", file=sys.stderr)
    sys.exit(2)


def command_line(defaults):
    """Input, output and settings of ADAPTER INPUT OUTPUT [--NAME VALUE]...

    defaults: the settings by name; a value gets the type of its default. Returns (pathlib.Path, pathlib.Path, dict).
    """
    words = sys.argv[1:]
    options = " ".join(f"[--{name} {value}]" for name, value in defaults.items())
    if len(words) < 2 or len(words) % 2:
        stop(f"usage: {pathlib.Path(sys.argv[0]).name} INPUT OUTPUT {options}")
    settings = dict(defaults)
    for name, value in zip(words[2::2], words[3::2]):
        name = name.removeprefix("--")
        if name not in defaults:
            stop(f"there is no setting --{name}; there are: {options or 'none'}")
        try:
            settings[name] = type(defaults[name])(value)
        except ValueError:
            stop(f"--{name} {value} is no {type(defaults[name]).__name__}; give one, as {defaults[name]}")
    if not pathlib.Path(words[0]).is_file():
        stop(f"{words[0]} does not exist; write it with livermark export BODY LOAD_CASE")
    return pathlib.Path(words[0]), pathlib.Path(words[1]), settings


def program(name, how_to_get):
    """Path of a program. An adapter whose program is missing ends, and says how to get it."""
    return shutil.which(name) or stop(f"there is no {name} on the PATH; {how_to_get}")


def is_scene(path):
    return path.name.endswith(".scene.h5")


def stem_of(path):
    """Path of an exported file without its ending, such as out/beam/beam_bend."""
    return path.with_name(re.sub(r"\.(problem|scene)\.h5$", "", path.name))


def read_vtu(path, name, components=3):
    """Values of an array at the nodes in a .vtu of `livermark export`, shape (N, components)."""
    if not path.is_file():
        stop(f"{path} does not exist, and has the nodal forces; write it with livermark export")
    found = re.search(rf'Name="{name}"[^>]*>([^<]*)<', path.read_text())
    if not found:
        stop(f"{path} has no {name}; write it with livermark export")
    return numpy.array(found.group(1).split(), float).reshape(-1, components)


def _mesh(file, group):
    region = file[group + "region"][:]
    young, nu, density = (file[f"materials/{name}"][:] for name in ("young_modulus", "poisson_ratio", "density"))
    return dict(points=file[group + "points"][:], tetrahedra=file[group + "tetrahedra"][:].astype(int), region=region,
                young_modulus=young, poisson_ratio=nu, density=density)


def read_ball(path):
    """The rigid ball of a problem that touches without friction: radius, start (3) and press (3) [m], the centre where it just
    touches the body at rest, and by which it moves. None where there is none. Ends an adapter where the tool is another."""
    with h5py.File(path) as file:
        touch = file["load_case"].get("touch")
        if touch is None:
            return None
        start, press, slide = touch["way"][:]
        others = {"a plate": "face" in touch.attrs, "two jaws": "between" in touch, "a tool with friction": touch.attrs["friction"] != 0.0,
                  "a tool that slides": slide.any()}
        for other in (words for words, is_there in others.items() if is_there):
            stop(f"{path} has {other}, and adapters know a ball that presses without friction; choose another load case")
        return SimpleNamespace(radius=float(touch.attrs["radius"]), start=start, press=press)


def refuse_ball(path, ball):
    """Ends an adapter that knows no contact where a ball touches the body of a problem: that of read_ball()."""
    if ball is not None:
        stop(f"{path} has a ball that touches, and this adapter knows no contact; choose another load case")


def deepest(ball, points, part=1.0):
    """By how much the point (N, 3) [m] that is deepest in a ball at a part of its press is inside it [m]; 0 where none is."""
    distance = numpy.linalg.norm(points - ball.start - part * ball.press, axis=1)
    return max(0.0, ball.radius - float(distance.min()))


REFUSED = {"load_case/foundation": "elastic springs below facets", "load_case/slow_history": "tissue that relaxes",
           "load_case/release": "a release, which happens in time", "capsule": "a capsule",
           "vessels": "vessels as lines", "mesh/modulus_factor": "a map of stiffness"}


def read_foundation(path):
    """The elastic springs below facets of a problem: nodes (I, 3) and area (I) [m^2] of each, stiffness (I) [N/m^3], and normal_only
    (I), whether they resist motion along the normal alone. None where there are none."""
    with h5py.File(path) as file:
        group = file["load_case"].get("foundation")
        if group is None:
            return None
        nodes = file["mesh/boundary_triangles"][:].astype(int)[group["facet"][:]]
        corners = file["mesh/points"][:][nodes]
        area = 0.5 * numpy.linalg.norm(numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        return SimpleNamespace(nodes=nodes, area=area, stiffness=group["stiffness"][:], normal_only=group["normal_only"][:] != 0)


def read_problem(path, knows=()):
    """A problem at rest: points (N, 3), tetrahedra (M, 4), region (M) index into young_modulus, poisson_ratio and density;
    triangles (F, 3) of the surface; force (N, 3) [N]; is_prescribed (N, 3) and prescribed (N, 3) [m]; is_large; press_depth [m],
    which is 0 where force is the whole load, and else what sum force . u has to become under a multiple of force; touch, the ball
    of read_ball() or None; foundation, that of read_foundation() or None; has_capsule and has_vessels. What is in REFUSED ends the
    adapter, unless it knows it."""
    with h5py.File(path) as file:
        for words in (words for part, words in REFUSED.items() if part in file and part not in knows):
            stop(f"{path} has {words}, which adapters do not read; choose another load case or body")
        load_case = file["load_case"]
        regime = load_case.attrs.get("regime", b"small")
        problem = SimpleNamespace(**_mesh(file, "mesh/"), triangles=file["mesh/boundary_triangles"][:].astype(int),
                                  press_depth=float(load_case.attrs.get("press_depth", 0.0)),
                                  is_large=(regime.decode() if isinstance(regime, bytes) else regime) == "large",
                                  follows="follows" in load_case, has_capsule="capsule" in file, has_vessels="vessels" in file)
    problem.touch, problem.foundation = read_ball(path), read_foundation(path)
    vtu = stem_of(path).with_suffix(".vtu")
    problem.force = read_vtu(vtu, "nodal_force")
    problem.prescribed = read_vtu(vtu, "prescribed_displacement")
    problem.is_prescribed = read_vtu(vtu, "is_prescribed") != 0.0
    return problem


def read_scene(path):
    """A scene: the mesh as in read_problem(); held, nodes that never move; tool (T) nodes, way (K, T, 3) [m] and time (K) [s];
    last_held, the last record in which the tool has hold of its nodes; damping [1/s] of the mass."""
    with h5py.File(path) as file:
        tool = file["tool"]
        return SimpleNamespace(**_mesh(file, ""), held=file["held"][:].astype(int), tool=tool["nodes"][:].astype(int),
                               way=tool["displacement"][:], time=tool["time"][:], last_held=int(tool.attrs["last_record_held"]),
                               damping=float(tool.attrs["mass_damping"]))


def write_solution(path, points, displacement):
    """CSV of `livermark score`: x, y, z and ux, uy, uz of each node [m]."""
    with open(path, "w", encoding="utf-8") as file:
        print("x,y,z,ux,uy,uz", file=file)
        for x, u in zip(points.tolist(), displacement.tolist()):
            print(",".join(map(repr, x + u)), file=file)


def write_motion(path, displacement, force, seconds_per_frame=None):
    """HDF5 of `livermark score`: displacement (K, N, 3) [m], force (K, 3) of the body on the tool [N], seconds of a frame."""
    with h5py.File(path, "w", libver="latest") as file:
        file["displacement"] = displacement.astype("f4")
        file["force"] = numpy.asarray(force, float)
        if seconds_per_frame is not None:
            file.attrs["seconds_per_frame"] = seconds_per_frame


def rest_under(problem, displacement_under, steps_of_large_loads=10):
    """Displacement (N, 3) [m] under the whole load of a problem, and the force [N] of a tool that presses to a depth, or None.

    displacement_under(force_factor, displacement_factor) is the displacement at rest under multiples of problem.force and
    problem.prescribed. Large loads grow in steps; a depth is found by the secant method.
    """
    num_steps, factor, displacement = steps_of_large_loads if problem.is_large else 1, 1.0, None
    for step in range(1, num_steps + 1):
        part = step / num_steps
        if problem.press_depth <= 0.0:
            displacement = displacement_under(part, part)
            continue
        factors, depths, depth = [0.0], [0.0], part * problem.press_depth
        while abs(depths[-1] - depth) > 1e-7 * depth:
            if len(depths) > 20:
                stop(f"no force was found that presses to {depth:g} m")
            slope = (factors[-1] - factors[-2]) / (depths[-1] - depths[-2]) if len(depths) > 1 else 0.0
            factor += slope * (depth - depths[-1])
            displacement = displacement_under(factor, part)
            factors.append(factor)
            depths.append(float((problem.force * displacement).sum()))
    return displacement, factor * float(numpy.linalg.norm(problem.force.sum(axis=0))) if problem.press_depth > 0.0 else None


def solve_rest(source, output, body_of, clock=time.monotonic, knows_balls=False, knows=()):
    """Solves a problem at rest and writes its solution; returns the cost by a clock and, under a press to a depth, the force [N].

    body_of(problem) has displacement_under() as rest_under() takes it. An engine that knows balls moves them with the prescribed
    displacements, and its body has contact(), the numbers of the report under a ball; the others refuse a ball. knows: as in
    read_problem().
    """
    problem = read_problem(source, knows)
    if not knows_balls:
        refuse_ball(source, problem.touch)
    if problem.follows:
        stop("the problem has a pressure that follows the surface; choose another load case")
    start = clock()
    body = body_of(problem)
    setup, start = clock() - start, clock()
    displacement, force = rest_under(problem, body.displacement_under)
    write_solution(output, problem.points, displacement)
    return {"seconds_per_frame": None, "setup_seconds": setup, "solve_seconds": clock() - start,
            **({} if force is None else {"force": force}), **(body.contact() if problem.touch else {})}


def neo_hookean_forces_on_tool(scene, displacement):
    """Forces (K, 3) [N] of tetrahedra of W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2 on the tool, zero once it has let go.

    An engine says where nodes are; the elastic force follows from the energy that it was told.
    """
    near = scene.tetrahedra[numpy.isin(scene.tetrahedra, scene.tool).any(axis=1)]
    region = scene.region[numpy.isin(scene.tetrahedra, scene.tool).any(axis=1)]
    young, nu = scene.young_modulus[region], scene.poisson_ratio[region]
    mu, lame = (0.5 * young / (1.0 + nu))[:, None, None], (young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)))[:, None, None]
    edges = numpy.moveaxis(scene.points[near[:, 1:]] - scene.points[near[:, :1]], 1, 2)  # an edge in each column
    to_rest, volume = numpy.linalg.inv(edges), numpy.linalg.det(edges) / 6.0
    forces = numpy.zeros((len(displacement), 3))
    for k in range(min(scene.last_held, len(displacement) - 1) + 1):
        x = scene.points + displacement[k]
        f = numpy.moveaxis(x[near[:, 1:]] - x[near[:, :1]], 1, 2) @ to_rest
        inverse = numpy.swapaxes(numpy.linalg.inv(f), 1, 2)
        stress = mu * (f - inverse) + lame * numpy.log(numpy.linalg.det(f))[:, None, None] * inverse
        pull = -volume[:, None, None] * (stress @ numpy.swapaxes(to_rest, 1, 2))  # a column for each of nodes 1 to 3
        at_nodes = numpy.concatenate([-pull.sum(axis=2, keepdims=True), pull], axis=2)
        forces[k] = numpy.swapaxes(at_nodes, 1, 2)[numpy.isin(near, scene.tool)].sum(axis=0)
    return forces


def run(command, folder, **environment):
    """Runs a program in a folder with one thread, as all times are of one core.

    Returns what it printed, its exit status, its time [s], and its largest resident memory [bytes].
    """
    environment = {**os.environ, "OMP_NUM_THREADS": "1", **environment}
    with tempfile.TemporaryFile("w+") as log:
        start, memory = time.monotonic(), 0
        child = subprocess.Popen([str(word) for word in command], cwd=folder, env=environment, stdout=log, stderr=log)
        while child.poll() is None:
            try:
                peak = re.search(r"VmHWM:\s*(\d+)", pathlib.Path(f"/proc/{child.pid}/status").read_text())
            except OSError:
                peak = None
            memory = max(memory, 1024 * int(peak[1]) if peak else 0)
            time.sleep(0.02)
        seconds = time.monotonic() - start
        log.seek(0)
        return SimpleNamespace(printed=log.read(), status=child.returncode, seconds=seconds, memory=memory)


def report(engine, version, settings, **numbers):
    """The last line that an adapter prints: what ran, and its cost."""
    print(json.dumps({"engine": engine, "version": version, "settings": settings, **numbers}))
