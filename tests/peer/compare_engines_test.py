"""compare_engines_test.py <engine> <livermark> <bullet adapter> <folder>: an engine through examples/engines/compare on the beam.

Converged linear tetrahedra have the error of fem_p1 on the same mesh, whoever solves them. Ends with 77 where the engine is not
installed.
"""
import os
import pathlib
import shutil
import subprocess
import sys

ENGINES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "engines"
# The error of the stiffness against linear tetrahedra that an engine has at most, and why it is not zero.
LARGEST = {
    "bullet": 0.002,    # single precision
    "calculix": 1e-4,   # seven digits in its files
    "jolt": 0.2,        # springs and volumes in place of elements
    "mujoco": 0.002,    # a law that differs from linear elasticity by the square of the strain
    "livermark_springs": 0.2,  # springs that do not lock
}

engine, livermark, bullet, folder = sys.argv[1:]
folder = pathlib.Path(folder) / engine
shutil.rmtree(folder, ignore_errors=True)
environment = {**os.environ, "LIVERMARK": livermark}
if bullet:
    environment["LIVERMARK_BULLET"] = bullet


def compare(*arguments):
    done = subprocess.run(["/usr/bin/python3", str(ENGINES / "compare"), "--engine", engine, "--reference-on-mesh", "--markdown",
                           "--output", str(folder), *map(str, arguments)], capture_output=True, text=True, env=environment)
    print(done.stdout, done.stderr)
    return done


if engine in ("jolt", "mujoco"):  # seconds on a body of some hundred nodes
    folder.mkdir(parents=True)
    shutil.copy(ENGINES / "pieces" / "cube.toml", folder / "small.toml")
    subprocess.run([livermark, "mesh", "box", "--size", "0.04", "0.04", "0.04", "--edge", "0.01", "-o", folder / "cube.msh"], check=True)
    problem = ["--body", folder / "small.toml", "--load-case", ENGINES / "pieces" / "shear.toml"]
else:
    problem = ["--body", "beam", "--load-case", "beam_bend"]
entry = folder / "entry.toml"
done = compare(*problem, "--entry", entry)
if "none of these engines is installed" in done.stderr:
    print("skipped:", done.stderr.splitlines()[0])
    sys.exit(77)
assert done.returncode == 0, done
header, _, row = [[word.strip() for word in line.strip("|").split("|")] for line in done.stdout.splitlines() if line.startswith("|")]
cells = dict(zip(header, row))
assert cells["outcome"] in ("ok", "not at rest") and cells["version"] not in ("-", "unknown"), cells
to_linear = float(cells["to fem_p1"])
assert abs(to_linear - 1.0) < LARGEST[engine] + 6e-4, cells  # three decimals
if LARGEST[engine] < 0.01:
    assert abs(float(cells["L2 [%]"]) - float(cells["of fem_p1 [%]"])) < 0.1, cells
assert float(cells["memory [MB]"]) > 0.0, cells
text = entry.read_text()
assert f'engine = "{engine}"' in text and "[[problem]]" in text and "solution = " in text, text

if engine == "bullet":  # a ball with two edges of the mesh in its radius: as near to the reference as linear tetrahedra
    pieces = folder / "ball"
    pieces.mkdir()
    shutil.copy(ENGINES / "pieces" / "cube.toml", pieces / "small.toml")
    subprocess.run([livermark, "mesh", "box", "--size", "0.04", "0.04", "0.04", "--edge", "0.006", "-o", pieces / "cube.msh"], check=True)
    (pieces / "press.toml").write_text("""title = "A rigid ball presses a cube"
regime = "large"
target_peak_displacement = 0.004

[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]

[touch]
disc = { patch = "z_max", radius = 0.012 }
radius = 0.012
depth = 0.004
""")
    pressed = compare("--body", pieces / "small.toml", "--load-case", pieces / "press.toml", "--set", "steps=150")
    assert pressed.returncode == 0, pressed
    rows = [[word.strip() for word in line.strip("|").split("|")] for line in pressed.stdout.splitlines() if line.startswith("|")]
    ball = dict(zip(rows[0], rows[2]))
    assert ball["outcome"] in ("ok", "not at rest"), ball
    assert float(ball["L2 [%]"]) < float(ball["of fem_p1 [%]"]) + 2.0, ball
    assert abs(float(ball["to fem_p1"]) - 1.0) < 0.05, ball

# An engine that fails is a row, and a setting that it does not have is named.
refused = compare(*problem, "--set", "no_such_setting=1")
assert refused.returncode == 1 and "no_such_setting" in refused.stdout, refused
wrong = compare(*problem, "--set", "iterations")
assert wrong.returncode != 0 and "write --set NAME=VALUE" in wrong.stderr, wrong
