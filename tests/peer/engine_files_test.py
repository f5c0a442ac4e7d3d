"""engine_files_test.py <livermark> <folder>: the adapters of FEBio and SOFA around programs that are not theirs.

The stand-in for febio4 writes tables as FEBio documents them; those for the modules Sofa and SofaRuntime move the nodes of a
scene. Both put nodes where the test says, so files have to come out as they went in.
"""
import contextlib
import csv
import io
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

import h5py
import numpy

ENGINES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "engines"
livermark, folder = sys.argv[1], pathlib.Path(sys.argv[2])
shutil.rmtree(folder, ignore_errors=True)
programs = folder / "programs"
programs.mkdir(parents=True)

FEBIO = '''#!/usr/bin/python3
import pathlib, re, sys
job = pathlib.Path(sys.argv[sys.argv.index("-i") + 1])
text = job.read_text()
points = [[float(x) for x in row.split(",")] for row in re.findall(r'<node id="\\d+">([^<]*)</node>', text.split("</Nodes>")[0])]
times = [0.5, 1.0] if "STATIC" in text else [0.25 / 60.0 * step for step in range(1, 4 * 96 + 1)]
print("version 4.0.0")
with open(re.search(r'file="([^"]*displacement.csv)"', text)[1], "w") as out:
    for step, time in enumerate(times, 1):
        print(f"*Step  = {step}\\n*Time  = {time:.9g}\\n*Data  = ux;uy;uz", file=out)
        for node, (x, y, z) in enumerate(points, 1):
            print(f"{node},{1e-3 * time * x:.9g},{-2e-3 * time * y:.9g},{0:.9g}", file=out)
if "force.csv" in text:
    with open(re.search(r'file="([^"]*force.csv)"', text)[1], "w") as out:
        for step, time in enumerate(times, 1):
            print(f"*Step  = {step}\\n*Time  = {time:.9g}\\n*Data  = Fx;Fy;Fz\\n2,{0.3 * time},{-0.4 * time},0", file=out)
'''
SOFA = '''import contextlib, json, sys, types
import numpy

class Data:
    def __init__(self, value):
        self.value = value
    @contextlib.contextmanager
    def writeable(self):
        yield self.value

class Object:
    def __init__(self, data):
        for name, value in data.items():
            setattr(self, name, Data(numpy.array(value, float) if name in ("position", "forces") else value))
        if "position" in data:
            self.force = Data(numpy.zeros_like(self.position.value))

class Node:
    def __init__(self, name, root=None):
        self.root, self.moved, self.seconds, self.title = root or self, None, 0.0, name
    def __setattr__(self, name, value):
        object.__setattr__(self, name, Data(value) if name == "dt" else value)
    def addChild(self, name):
        child = Node(name, self.root)
        setattr(self, name, child)
        return child
    def addObject(self, kind, **data):
        made = Object(data)
        if "Spring" in kind:
            print("springs", json.dumps([self.title, kind, data, self.points.position.value.tolist() if hasattr(self, "points") else None]))
        if kind == "SphereForceField":
            self.root.sphere, self.root.sphere_start = made, numpy.array(data["center"])
        if data.get("name") == "nodes":
            self.root.moved, self.root.rest = made.position, made.position.value.copy()
        if "name" in data:
            setattr(self, data["name"], made)
        return made

def animate(root, step):
    root.seconds += step
    root.moved.value = root.rest * (1.0 + root.seconds * numpy.array([1e-3, -2e-3, 0.0]))
    if hasattr(root, "sphere"):
        print("sphere at", root.sphere.center.value.tolist())
        root.moved.value = root.rest + 0.9 * (root.sphere.center.value - root.sphere_start)

Core = types.SimpleNamespace(Node=Node)
Simulation = sys.modules["Sofa.Simulation"] = types.ModuleType("Sofa.Simulation")
Simulation.animate, Simulation.init = animate, lambda root: None
'''
(programs / "febio4").write_text(FEBIO)
(programs / "febio4").chmod(0o755)
(programs / "Sofa.py").write_text(SOFA)
(programs / "SofaRuntime.py").write_text("def importPlugin(name):\n    print('loading', name)\n")
with_programs = {**os.environ, "PATH": f"{programs}:{os.environ['PATH']}", "PYTHONPATH": str(programs)}


def adapter(name, *arguments, env=with_programs):
    done = subprocess.run(["/usr/bin/python3", str(ENGINES / name / f"{name}.py"), *map(str, arguments)], capture_output=True, text=True,
                          env=env)
    print(name, done.stdout, done.stderr)
    return done


def export(*arguments):
    subprocess.run([livermark, "export", *arguments, "-o", folder], check=True, stdout=subprocess.DEVNULL)


export("beam", "beam_bend", "--format", "febio", "vtu")
export("liver_healthy", "press_and_slide")
problem, scene = folder / "beam" / "beam_bend.problem.h5", folder / "liver_healthy" / "press_and_slide.scene.h5"
with h5py.File(scene) as file:
    points, time, last = file["points"][:], file["tool/time"][:], int(file["tool"].attrs["last_record_held"])
for name in ("febio", "sofa"):
    done = adapter(name, problem, folder / f"{name}.csv")
    assert done.returncode == 0 and f'"engine": "{name}"' in done.stdout, done
    with open(folder / f"{name}.csv") as file:
        rows = numpy.array([[float(value) for value in row.values()] for row in csv.DictReader(file)])
    assert numpy.allclose(rows[:, 3:], rows[:, :3] * [1e-3, -2e-3, 0.0], atol=1e-9), name
    done = adapter(name, scene, folder / f"{name}.h5")
    assert done.returncode == 0, done
    with h5py.File(folder / f"{name}.h5") as file:
        displacement, force = file["displacement"][:], file["force"][:]
        assert file.attrs["seconds_per_frame"] > 0.0
    expected = time[:, None, None] * points * [1e-3, -2e-3, 0.0]
    assert numpy.allclose(displacement, expected, atol=1e-7), name
    assert abs(force[1:last + 1]).max() > 0.0 and not force[last + 1:].any() and numpy.allclose(force[0], 0.0, atol=1e-12), name

# A stretched body under its own law: the force on the tool is that of finite differences of the energy.
sys.path.insert(0, str(ENGINES))
import files  # noqa: E402

corners = numpy.array([[0.0, 0.0, 0.0], [0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]])
body = files.SimpleNamespace(points=corners, tetrahedra=numpy.array([[0, 1, 2, 3]]), region=numpy.zeros(1, int), tool=numpy.array([1, 2]),
                             young_modulus=numpy.array([5000.0]), poisson_ratio=numpy.array([0.45]), last_held=0)
u = numpy.array([[0.0, 0.0, 0.0], [1e-3, 2e-4, 0.0], [0.0, -5e-4, 1e-4], [3e-4, 0.0, 5e-4]])


def energy(moved):
    f = numpy.linalg.solve(corners[1:], (corners + moved)[1:] - (corners + moved)[0]).T
    mu, lame, log = 5000.0 / 2.9, 5000.0 * 0.45 / (1.45 * 0.1), numpy.log(numpy.linalg.det(f))
    return 1e-6 / 6.0 * (0.5 * mu * (numpy.trace(f.T @ f) - 3.0) - mu * log + 0.5 * lame * log ** 2)


for c in range(3):
    step = numpy.zeros((4, 3))
    step[[1, 2], c] = 1e-7
    slope = (energy(u + step) - energy(u - step)) / 2e-7
    assert abs(files.neo_hookean_forces_on_tool(body, u[None])[0, c] + slope) < 1e-6 * abs(slope) + 1e-9

# A ball that touches is read as it is in the file, refused where an adapter knows no contact, and so are other tools that touch.
export(ENGINES / "bodies" / "liver_2000.toml", "large_palpation")
ball = folder / "liver_2000" / "large_palpation.problem.h5"
with h5py.File(ball) as file:
    touch = file["load_case/touch"]
    radius, way = float(touch.attrs["radius"]), touch["way"][:]
read = files.read_problem(ball).touch
assert read.radius == radius and (read.start == way[0]).all() and (read.press == way[1]).all(), read
assert files.read_problem(problem).touch is None
refused = adapter("calculix", ball, folder / "none.csv")
assert refused.returncode == 2 and "has a ball that touches, and this adapter knows no contact" in refused.stderr, refused
export(ENGINES / "bodies" / "liver_2000.toml", "large_palpation", "--format", "febio")
done = adapter("febio", ball, folder / "pressed.csv")
assert done.returncode == 0 and abs(json.loads(done.stdout.splitlines()[-1])["force"] - 0.5) < 1e-12, done

# SOFA's sphere moves in steps to where the press ends, and the body of the stand-in goes nine tenths of the way with it. The
# numbers of the report are those of plain loops over facets.
liver = files.read_problem(ball)
young, nu = liver.young_modulus[0], liver.poisson_ratio[0]
assert len(liver.young_modulus) == 1 and liver.triangles.shape[1] == 3
stiffness, mu, lame = numpy.zeros(len(liver.points)), 0.5 * young / (1.0 + nu), young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
for nodes in liver.tetrahedra:
    edges = liver.points[nodes[1:]] - liver.points[nodes[0]]
    gradients = numpy.linalg.inv(numpy.hstack([numpy.ones((4, 1)), liver.points[nodes]]))[1:].T
    for node, gradient in zip(nodes, gradients):
        for direction in numpy.eye(3):
            strain = 0.5 * (numpy.outer(gradient, direction) + numpy.outer(direction, gradient))
            twice_energy = 2.0 * mu * (strain ** 2).sum() + lame * numpy.trace(strain) ** 2
            stiffness[node] += numpy.linalg.det(edges) / 6.0 * twice_energy / 3.0
for split in (1, 4):
    done = adapter("sofa", ball, folder / "ball.csv", "--split", split, "--penalty", 10)
    assert done.returncode == 0, done
    report, spheres = json.loads(done.stdout.splitlines()[-1]), re.findall(r"sphere at (\[.*\])", done.stdout)
    assert numpy.allclose([json.loads(sphere) for sphere in spheres], [way[0] + part * way[1] for part in numpy.arange(1, 11) / 10.0])
    with open(folder / "ball.csv") as file:
        rows = numpy.array([[float(value) for value in row.values()] for row in csv.DictReader(file)])
    moved, points = rows[:, :3] + rows[:, 3:], {}
    for a, b, c in liver.triangles:
        for i in range(split + 1):
            for j in range(split + 1 - i):
                point = (i * moved[a] + j * moved[b] + (split - i - j) * moved[c]) / split
                points[tuple(numpy.rint(1e9 * point).astype(int))] = point
    touched = numpy.array(list(points.values()))
    outwards = (moved if split == 1 else touched) - way[0] - way[1]
    distance = numpy.linalg.norm(outwards, axis=1)
    inside, one = distance < radius, 10.0 * stiffness[numpy.unique(liver.triangles)].mean() / split ** 2
    force = (one * (radius / distance[inside] - 1.0)[:, None] * outwards[inside]).sum(axis=0)
    assert report["settings"] == {"law": "corotational", "penalty": 10.0, "split": split} and report["at_rest"] is True, report
    assert report["points_in_touch"] == inside.sum() > 0 and abs(report["stiffness_of_point"] / one - 1.0) < 1e-9, report
    assert abs(report["force"] / numpy.linalg.norm(force) - 1.0) < 1e-9, report
    assert abs(report["deepest_point"] - radius + distance.min()) < 1e-12, report
    nearest = numpy.linalg.norm(moved - way[0] - way[1], axis=1).min()
    assert abs(report["deepest"] - max(0.0, radius - nearest)) < 1e-12, report
for setting in ("split", "penalty"):
    refused = adapter("sofa", ball, folder / "none.csv", f"--{setting}", 0)
    assert refused.returncode == 2 and "--split is a whole number of 1 or more, and --penalty above 0" in refused.stderr, refused


def changed(name, change):
    """A copy of the problem whose tool is another."""
    path = folder / f"{name}.problem.h5"
    shutil.copy(ball, path)
    with h5py.File(path, "r+") as file:
        change(file["load_case/touch"])
    return path


def slide(touch):
    touch["way"][2] = [0.0, 0.001, 0.0]


others = {"tool with friction": changed("friction", lambda touch: touch.attrs.modify("friction", 0.3)),
          "plate": changed("plate", lambda touch: touch.attrs.create("face", b"round")),
          "two jaws": changed("jaws", lambda touch: touch.create_dataset("between", data=numpy.zeros(3))),
          "tool that slides": changed("slide", slide)}
for words, path in others.items():
    for name in ("calculix", "sofa"):
        refused = adapter(name, path, folder / "none.csv")
        assert refused.returncode == 2 and words in refused.stderr and "adapters know a ball" in refused.stderr, refused

if shutil.which("node") and (ENGINES / "node_modules" / "h5wasm").is_dir():
    def node(path):
        text = f"""import {{ deepest, readProblem }} from {str(ENGINES / "files.mjs")!r};
            const {{ touch, points }} = readProblem({str(path)!r});
            console.log(JSON.stringify(touch && {{ ...touch, start: [...touch.start], press: [...touch.press],
                deepest: deepest(touch, points, new Float64Array(points.length)) }}));"""
        return subprocess.run(["node", "--input-type=module", "-e", text], capture_output=True, text=True)

    read = json.loads(node(ball).stdout)
    at_rest = numpy.linalg.norm(files.read_problem(ball).points - way[0] - way[1], axis=1)
    assert read["radius"] == radius and read["start"] == way[0].tolist() and read["press"] == way[1].tolist(), read
    assert abs(read["deepest"] - max(0.0, radius - at_rest.min())) < 1e-12, read
    assert json.loads(node(problem).stdout) is None
    for words, path in others.items():
        refused = node(path)
        assert refused.returncode != 0 and words in refused.stderr and "adapters know a ball" in refused.stderr, refused

# A capsule, vessels as lines and an elastic foundation are springs of SOFA, whose energy under an even strain is that of plain loops.
covered = folder / "covered"
covered.mkdir()
(covered / "covered.toml").write_text("""title = "A cube with all that goes beside tetrahedra"
mesh = "box.msh"

[regions.solid]
density = 1060.0
young_modulus = 5000.0
poisson_ratio = 0.45
source = "of this test"

[capsule]
thickness = 2e-5
young_modulus = 8e6

[vessels]
file = "tubes.swc"
""")
# SWC, in metres: number, kind, x, y, z, radius, parent
(covered / "tubes.swc").write_text("1 0 0.004 0.021 0.018 0.002 -1\n2 0 0.02 0.019 0.02 0.002 1\n3 0 0.036 0.03 0.022 0.001 2\n")
(covered / "stands.toml").write_text("""title = "A cube on springs"
regime = "large"
target_peak_displacement = 0.001
acceleration = [0.0, 0.0, -9.81]

[[condition]]
patch = "y_max"
displacement = [0.0, 0.0, 0.0]

[[foundation]]
patch = "z_min"
stiffness = 2e5

[[foundation]]
patch = "x_max"
stiffness = 1e5
""")
subprocess.run([livermark, "mesh", "box", "--size", "0.04", "0.04", "0.04", "--edge", "0.012", "-o", covered / "box.msh"], check=True)
export(covered / "covered.toml", covered / "stands.toml")
standing = folder / "covered" / "stands.problem.h5"
missing = adapter("sofa", standing, folder / "none.csv")
assert missing.returncode == 2 and "covered.sofa.json does not exist, and has the springs" in missing.stderr, missing
subprocess.run([livermark, "springs", covered / "covered.toml", "--for", "sofa", "-o", folder / "covered"], check=True, stdout=subprocess.DEVNULL)
strained = numpy.eye(3) + numpy.array([[0.1, 0.05, 0.0], [-0.02, -0.08, 0.03], [0.01, 0.0, 0.06]])


def energies(law):
    """Of the springs of each part of SOFA's scene [J]."""
    done, found = adapter("sofa", standing, folder / "standing.csv", "--law", law), {}
    assert done.returncode == 0, done
    for line in re.findall(r"^springs (.*)$", done.stdout, re.MULTILINE):
        part, kind, data, places = json.loads(line)
        places = numpy.array(standing_points if places is None else places)
        moved = places @ strained.T
        if kind == "RestShapeSpringsForceField":
            found[part] = 0.5 * (numpy.array(data["stiffness"]) * ((moved - places) ** 2).sum(axis=1)).sum()
        else:
            assert kind == "SpringForceField", kind
            i, j, k, damping, length = numpy.array(data["spring"]).T
            ends = i.astype(int), j.astype(int)
            assert not damping.any() and numpy.allclose(numpy.linalg.norm(places[ends[1]] - places[ends[0]], axis=1), length, rtol=1e-9)
            longer = numpy.linalg.norm(moved[ends[1]] - moved[ends[0]], axis=1) - length
            found[part] = found.get(part, 0.0) + 0.5 * (k * longer ** 2).sum()
    return found


with h5py.File(standing) as file:
    standing_points, facets = file["mesh/points"][:], file["mesh/boundary_triangles"][:]
    names = [name.decode() for name in file["mesh/boundary_patch"].attrs["names"]]
    patch = [names[p] for p in file["mesh/boundary_patch"][:]]
capsule, foundation = 0.0, 0.0
for corners, name in zip(standing_points[facets], patch):
    area = 0.5 * numpy.linalg.norm(numpy.cross(corners[1] - corners[0], corners[2] - corners[0]))
    for a, b in ((0, 1), (1, 2), (2, 0)):
        span = corners[b] - corners[a]
        capsule += 0.5 * numpy.sqrt(3.0) / 4.0 * 160.0 * (numpy.linalg.norm(strained @ span) - numpy.linalg.norm(span)) ** 2
    values = corners @ (strained - numpy.eye(3)).T  # linear on the facet, so the mean of its square is that of pairs of corners
    mean = (values.sum(axis=0) ** 2 + (values ** 2).sum(axis=0)).sum() / 12.0
    foundation += 0.5 * {"z_min": 2e5, "x_max": 1e5}.get(name, 0.0) * area * mean
tubes, radius, vessels = numpy.array([[0.004, 0.021, 0.018], [0.02, 0.019, 0.02], [0.036, 0.03, 0.022]]), [2e-3, 1.5e-3], 0.0
for a, r in zip((0, 1), radius):
    span = tubes[a + 1] - tubes[a]
    stiffness = numpy.pi * r ** 2 * (0.62e6 * (1.0 - 0.81) - 5000.0)
    vessels += 0.5 * stiffness * numpy.linalg.norm(span) * (numpy.linalg.norm(strained @ span) / numpy.linalg.norm(span) - 1.0) ** 2
found = energies("corotational")
assert set(found) == {"livermark", "vessels", "foundation"}, found
for part, expected in (("livermark", capsule), ("vessels", vessels), ("foundation", foundation)):
    assert abs(found[part] / expected - 1.0) < 1e-6, (part, found, expected)
on_edges = energies("springs")
assert on_edges["livermark"] > found["livermark"] and on_edges["vessels"] == found["vessels"], (on_edges, found)
with h5py.File(standing, "r+") as file:
    file["load_case/foundation/normal_only"][0] = 1
refused = adapter("sofa", standing, folder / "none.csv")
assert refused.returncode == 2 and "has elastic springs along normals alone" in refused.stderr, refused
for part in ("load_case/foundation", "capsule", "vessels"):  # each adapter that does not name them refuses them
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said):
            files.read_problem(standing)
        raise AssertionError(part)
    except SystemExit as end:
        assert end.code == 2 and f"has {files.REFUSED[part]}, which adapters do not read" in said.getvalue(), said.getvalue()
    with h5py.File(standing, "r+") as file:
        del file[part]
assert files.read_problem(standing).foundation is None

# Programs that are missing, or stop early.
for name, sentence in (("febio", "there is no febio4 on the PATH"), ("sofa", "Python finds no module Sofa")):
    missing = adapter(name, problem, folder / "none.csv", env={**os.environ, "PATH": "/nowhere", "PYTHONPATH": ""})
    assert missing.returncode == 2 and sentence in missing.stderr, missing
(programs / "febio4").write_text(FEBIO.replace("[0.5, 1.0]", "[0.5]"))
early = adapter("febio", problem, folder / "none.csv")
assert early.returncode == 2 and "stopped at 0.5 of the load" in early.stderr, early
(programs / "Sofa.py").write_text(SOFA.replace("1e-3, -2e-3, 0.0", "numpy.nan, 0.0, 0.0"))
early = adapter("sofa", problem, folder / "none.csv")
assert early.returncode == 2 and "found no equilibrium at 1 of the load" in early.stderr, early
for follow, part in (("numpy.nan", "0.1"), ("0.0", "0.3")):  # a quarter of the radius is as deep as a point may be in a ball
    (programs / "Sofa.py").write_text(SOFA.replace("0.9 *", f"{follow} *"))
    early = adapter("sofa", ball, folder / "none.csv")
    assert early.returncode == 2 and f"found no equilibrium at {part} of the load" in early.stderr, early
assert not (folder / "none.csv").exists()
