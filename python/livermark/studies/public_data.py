"""Readers of measurements that others have published: python3 -m livermark.studies.public_data NAME DATA [FILE SHA256 ...]

`livermark experiment` calls it. Prints TOML: what was done to the body and measured, in SI units, and what has to be assumed to
compute it. A FILE with another digest than the published one is named there. A reader of another data set is a function in
READERS and an entry in load_cases/experiments/experiment_files.cpp.
"""
from __future__ import annotations

import csv
import hashlib
import math
import pathlib
import struct
import sys
from typing import Any, Callable, NamedTuple

import numpy

from livermark.errors import InputError
from livermark.studies import to_toml

# --- the Truth Cube: 343 beads in a cube of silicone between plates, in a scanner (Kerdok et al. 2003)

BEADS_PER_SIDE, NUM_BEADS = 7, 343
MILLIMETRE = 1e-3  #: the unit of the file [m]
SIDE_LENGTH = 0.08  #: of the cube [m]
BEAD_NOISE = 0.29e-3  #: of the displacement of a bead [m]
BEAD_STATES = ("5 %", "12.5 %", "18.25 %")  #: nominal, as the file calls them
CUBE_LOAD_CASE = """title = "Between two layers of beads that moved as measured"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.01
[[condition]]
patch = "z_min"
displacement = [0.0, 0.0, 0.0]
[[condition]]
patch = "z_max"
displacement = [0.0, 0.0, 0.0]
"""


def _bead_rows(file: pathlib.Path) -> list[tuple[str, list[str]]]:
    """Places and cells of the lines of the beads, below those of the header."""
    try:
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror}); check its permissions") from error
    lines = [[cell.strip(' \t\r"') for cell in line] for line in csv.reader(text.splitlines(), quoting=csv.QUOTE_NONE)]
    rows = [(f"{file}:{number}", cells) for number, cells in enumerate(lines, 1) if any(cells)]
    header = next((r for r, (_, cells) in enumerate(rows) if len(cells) > 2 and cells[0] == "i" and cells[2] == "k"), None)
    if header is None:
        raise InputError(f"{file}: there is no line i,j,k,x0,y0,z0 and so on; take the public file")
    if len(rows) - header - 1 != NUM_BEADS:
        raise InputError(f"{file}: there are {len(rows) - header - 1} beads and not {NUM_BEADS}; take the public file")
    return rows[header + 1:]


def _number(place: str, cells: list[str], column: int) -> float:
    try:
        value = float(cells[column])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{place}: '{cells[column][:60]}' in column {column + 1} is not a finite number; correct the line")
    return value


def truth_cube(file: pathlib.Path) -> dict[str, Any]:
    names, drives, seen = [], [], set()
    positions = []  # (343, 4, 3), at rest and in each state
    for place, cells in _bead_rows(file):
        if len(cells) < 3 + 3 * (1 + len(BEAD_STATES)):
            raise InputError(f"{place}: the line has {len(cells)} cells and not {3 + 3 * (1 + len(BEAD_STATES))}; correct it")
        bead = []
        for column in range(3):
            index = _number(place, cells, column)
            if index != round(index) or not 1.0 <= index <= BEADS_PER_SIDE:
                raise InputError(f"{place}: a bead has numbers from 1 to {BEADS_PER_SIDE}, and here is {index:g}; correct the line")
            bead.append(int(index))
        if tuple(bead) in seen:
            raise InputError(f"{place}: bead {bead[0]} {bead[1]} {bead[2]} occurs twice; take the public file")
        seen.add(tuple(bead))
        names.append(f"{bead[0]} {bead[1]} {bead[2]}")
        drives.append({1: "z_max", BEADS_PER_SIDE: "z_min"}.get(bead[2], ""))
        positions.append([MILLIMETRE * _number(place, cells, 3 + c) for c in range(3 + 3 * len(BEAD_STATES))])
    at = numpy.array(positions).reshape(NUM_BEADS, -1, 3)
    rest, per_layer = at[:, 0], 1.0 / (BEADS_PER_SIDE * BEADS_PER_SIDE)
    middle = sum(rest / float(NUM_BEADS))
    top = sum(per_layer * z for z, patch in zip(rest[:, 2], drives) if patch == "z_max")
    bottom = sum(per_layer * z for z, patch in zip(rest[:, 2], drives) if patch == "z_min")
    if not top - bottom > 0.0:
        raise InputError(f"{file}: layer 1 is not above layer 7; take the public file")
    return {"assumptions": [
                "the body is the silicone between the outermost layers of beads, with free sides 40 mm from the middle bead",
                "both layers move as a polynomial of degree 2 fitted to their 49 beads",
                "Poisson's ratio is 0.499; Young's modulus has no effect"],
            "box": {"corner": [float(middle[0] - 0.5 * SIDE_LENGTH), float(middle[1] - 0.5 * SIDE_LENGTH), float(bottom)],
                    "size": [SIDE_LENGTH, SIDE_LENGTH, float(top - bottom)],
                    "edge_length": 0.00925},  # bricks of a centimetre
            # Of the test beside the public file; Young's modulus has no part in where the beads go.
            "material": {"density": 980.0, "young_modulus": 15.3e3, "poisson_ratio": 0.499},
            "markers": names, "drives": drives, "positions": rest.ravel().tolist(), "damping_from": "",
            "state": [{"name": name, "noise": BEAD_NOISE, "load_case": CUBE_LOAD_CASE,
                       "displacement": (at[:, s] - rest).ravel().tolist()} for s, name in enumerate(BEAD_STATES, 1)]}


# --- the Dragon Skin beam: clamped, of silicone, under its own weight and two others, seen by cameras (Dubied et al. 2022)

NUM_MARKERS, NUM_COMPARED = 6, 3  # the first three are near the tip, the others at the clamp
HELD_FRAMES = 10  #: at the start, where a hand holds the beam
FRAMES_AT_REST = 50  #: at the end
NOMINAL_MARKERS = numpy.array([[0.1, 0.015, 0.036], [0.1, -0.006, 0.024], [0.1, 0.036, 0.006], [0.006, -0.01, -0.001],
                               [0.006, 0.04, 0.0275], [0.006, 0.04, 0.0]])
"""Where the authors say that the markers are on the straight beam, with the clamp at x = 0 [m]."""


class Weight(NamedTuple):
    name: str
    file: str  #: between beam_ and _V2_a.c3d
    force: float  #: [N]
    held: float  #: about what holds the tip at the first turning point [N]


WEIGHTS = (Weight("0 N", "gravity", 0.0, 0.25), Weight("0.510 N", "load52", 0.51012, 0.5), Weight("1.001 N", "load101", 1.00062, 0.8))
GRAVITY = 9.81  #: [m/s^2]
RECORDS_OF_SWINGS = 151  #: of ring-downs: a second and a half
WEIGHT_LOW, WEIGHT_HIGH = [0.092, -1.0, 0.0225], [1.0, 1.0, 1.0]
"""What a weight hangs at: the tetrahedra beside the upper edge of the free end [m]."""
LEAST_SWING = 0.75  #: of the displacement at the end, that the first turning point is beyond


class MotionCapture(NamedTuple):
    frame_rate: float  #: [1/s]
    positions: numpy.ndarray  #: (F, Q, 3) of markers over time, in the unit of the file


def read_motion_capture(file: pathlib.Path) -> MotionCapture:
    """The points of a C3D file with numbers of single precision in the order of Intel processors, and without analog channels:
    what motion capture systems write. (The C3D file format, c3d.org, 2008)

    Raises InputError for any other file, one that ends early, a marker that was not seen or is not a number.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror}); take the public file") from error
    block, key, intel, size_of_point = 512, 0x50, 84, 16

    def refuse(fault: str) -> None:
        raise InputError(f"{file}: {fault}; export the points as C3D with floating-point numbers, without analog channels and gaps")

    def at(kind: str, offset: int) -> Any:
        return struct.unpack_from("<" + kind, content, offset)[0]
    if len(content) < 2 * block or content[1] != key:
        refuse("this is no C3D file")
    parameters = block * (content[0] - 1)
    if content[0] == 0 or parameters + 4 > len(content) or content[parameters + 3] != intel:
        refuse("its numbers are not in the order of Intel processors")
    num_markers, num_frames = at("H", 2), at("H", 8) - at("H", 6) + 1
    start, rate = block * (at("H", 16) - 1), at("f", 20)
    if at("H", 4) != 0:
        refuse("it has analog channels")
    if not at("f", 12) < 0.0:
        refuse("its numbers are integers")
    if num_markers == 0 or num_frames < 1 or not rate > 0.0 or not math.isfinite(rate):
        refuse("its header says that there are no points, no frames or no rate")
    if start < block or start > len(content) or (len(content) - start) // size_of_point < num_markers * num_frames:
        refuse(f"it ends before its {num_frames} frames of {num_markers} points")
    # x, y, z, and how good they are
    points = numpy.frombuffer(content, "<f4", 4 * num_markers * num_frames, start).reshape(num_frames, num_markers, 4).astype(float)
    unseen = numpy.argwhere(~(numpy.isfinite(points[..., :3]).all(axis=2)) | (points[..., 3] < 0.0))
    if len(unseen):
        refuse(f"point {unseen[0][1]} was not seen in frame {unseen[0][0]}")
    return MotionCapture(rate, points[..., :3])


def from_turning_point(motion: numpy.ndarray, num_records: int, place: str) -> numpy.ndarray:
    """A recording from the first turning point on, which is where the body is at rest after a hand has let it go: the first
    largest displacement, in the mean of all markers and along that at the end, above three quarters of it. The turning point
    is the vertex of a parabola through three records, and the rest is interpolated by cubic splines through four (Catmull and
    Rom 1974).

    motion: (J, K, 3) displacements. Returns (num_records, K, 3). Raises InputError if there is no turning point, or less than
    num_records behind it.
    """
    means, last = motion.mean(axis=1), len(motion) - 1
    along = means @ means[last] / (means[last] @ means[last])
    turn = 1
    while turn < last and (along[turn] < LEAST_SWING or along[turn] <= along[turn - 1] or along[turn] < along[turn + 1]):
        turn += 1
    before, there, after = along[turn - 1], along[turn], along[turn + 1] if turn < last else along[turn]
    curvature = before - 2.0 * there + after
    start = turn + (0.5 * (before - after) / curvature if curvature < 0.0 else 0.0)
    first = math.floor(start)
    if turn == last or first < 1 or first + num_records + 1 > last:
        raise InputError(f"{place}: there are not {num_records} records behind the first turning point of the markers; record for "
                         "longer, or from before the body is let go")
    a, b, c, d = (motion[first + shift:first + shift + num_records] for shift in (-1, 0, 1, 2))
    part = start - first
    return b + 0.5 * part * (c - a + part * (2.0 * a - 5.0 * b + 4.0 * c - d + part * (3.0 * (b - c) + d - a)))


def best_rotation(points: numpy.ndarray, targets: numpy.ndarray) -> numpy.ndarray:
    """(3, 3) of the rigid motion that takes points (K, 3) nearest to others (Kabsch 1976, Acta Cryst. A32)."""
    u, _, vt = numpy.linalg.svd((targets - targets.mean(axis=0)).T @ (points - points.mean(axis=0)))
    return u @ numpy.diag([1.0, 1.0, -1.0 if numpy.linalg.det(u @ vt) < 0.0 else 1.0]) @ vt  # no reflection


def _beam_load_case(force: float) -> str:
    text = """title = "A beam that is clamped at one end and bends under its weight"
regime = "large"
path = [0.5, 1.0]
target_peak_displacement = 0.03
acceleration = [0.0, 0.0, -9.81]
[[condition]]
patch = "x_min"
displacement = [0.0, 0.0, 0.0]
"""
    if force > 0.0:
        text += ('[[condition]]\nedge = { between = ["x_max", "z_max"], width = 0.006, length = 0.04 }\n'
                 f"force = [0.0, 0.0, {-force:.6f}]\n")
    return text


class Recording(NamedTuple):
    """Positions of the markers in the frame of the cameras [m]."""
    held: numpy.ndarray  #: (6, 3) while a hand holds the beam
    at_rest: numpy.ndarray  #: (6, 3) at the end
    capture: MotionCapture


def _recording(file: pathlib.Path) -> Recording:
    capture = read_motion_capture(file)
    num_frames, num_markers, _ = capture.positions.shape
    if num_markers != NUM_MARKERS or num_frames < HELD_FRAMES + FRAMES_AT_REST:
        raise InputError(f"{file}: there are {num_markers} markers in {num_frames} frames, and {NUM_MARKERS} in at least "
                         f"{HELD_FRAMES + FRAMES_AT_REST} were recorded; take the public file")
    return Recording(capture.positions[:HELD_FRAMES].mean(axis=0), capture.positions[-FRAMES_AT_REST:].mean(axis=0), capture)


def dragon_skin_beam(folder: pathlib.Path) -> dict[str, Any]:
    states, rotation, positions = [], None, None
    for weight in WEIGHTS:
        repeats = [_recording(folder / f"beam_{weight.file}_V2_{letter}.c3d") for letter in "ab"]
        if rotation is None:  # of the first recording, which has no weight: the cameras see the beam inclined by seven degrees
            held = repeats[0].held
            rotation = best_rotation(held, NOMINAL_MARKERS)
            positions = (held[:NUM_COMPARED] - held.mean(axis=0)) @ rotation.T + NOMINAL_MARKERS.mean(axis=0)
        first, second = ((repeat.at_rest - repeat.held)[:NUM_COMPARED] @ rotation.T for repeat in repeats)
        swings = [from_turning_point((repeat.capture.positions - repeat.held)[:, :NUM_COMPARED] @ rotation.T, RECORDS_OF_SWINGS,
                                     str(folder)) for repeat in repeats]
        states.append({
            "name": weight.name, "load_case": _beam_load_case(weight.force),
            "displacement": (0.5 * (first + second)).ravel().tolist(),
            "noise": 0.5 * math.sqrt(((first - second) ** 2).sum() / NUM_COMPARED),  # of the mean of two
            "interval": 1.0 / repeats[0].capture.frame_rate, "motions": [swing.ravel().tolist() for swing in swings],
            # While it rings down a weight is a mass there, and a hand pulls the free end down until it lets go.
            "held": _beam_load_case(0.0) + f'[[condition]]\npatch = "x_max"\nforce = [0.0, 0.0, {-weight.held:.6f}]\n',
            "added_mass": weight.force / GRAVITY, "low": WEIGHT_LOW, "high": WEIGHT_HIGH})
    return {"assumptions": [
                "the clamp holds all of one end face, and its end is 100 mm from the free end",
                "the weight pulls on the 7.5 mm beside the upper edge of the free end, and keeps its direction",
                "the beam is straight where a hand holds it at the start; displacements are from there",
                "directions are those in which the six markers of the beam without a weight fit the places that the authors "
                "give best",
                "markers stand on pegs, which move with the surface under them",
                "while the beam rings, the weight is a mass in the tetrahedra at that edge, and the swing starts at its first "
                "turning point, in the shape that a force on the end face gives",
                "Young's modulus is the one that the authors fitted to this beam"],
            "box": {"size": [0.1, 0.03, 0.03], "edge_length": 0.0069},  # bricks of 7.5 mm
            "material": {"density": 1070.0, "young_modulus": 263824.0, "poisson_ratio": 0.499},
            "markers": [str(k) for k in range(NUM_COMPARED)], "drives": [""] * NUM_COMPARED,
            "positions": positions.ravel().tolist(), "damping_from": WEIGHTS[1].name, "state": states}


# --- cylinders of silicone that plates compress, with the force (Dawood et al. 2026)

RADIUS, HEIGHT = 0.025, 0.03  #: [m]
FIT_AT, COMPARE_AT = 0.0015, [0.003, 0.006, 0.01, 0.015]  #: compressions [m]
TESTS = [batch + str(number) for batch in "AB" for number in range(1, 6)]
LAWS = {  # the authors' fits to engineering stress: C10, C20, C30 and C01 [kPa], and Ogden's exponent
    "EF10_50T": ([2.1502, 0.0606, 0.0724], [-0.4985, 1.6206], 5.0295),
    "EF10_75T": ([1.2861, 0.0607, 0.0640], [-1.0896, 1.4588], 5.7802),
    "EF30_25T": ([7.4313, 0.0202, 0.1348], [2.9285, 2.6847], 3.9272),
    "EF50_0T": ([23.3326, -0.4941, 0.4918], [9.5120, 7.7635], 3.8748)}
PLANES_OF_SYMMETRY = """regime = "large"
[[condition]]
patch = "x_min"
displacement = [0.0, "free", "free"]
[[condition]]
patch = "y_min"
displacement = ["free", 0.0, "free"]
[[condition]]
patch = "z_min"
displacement = ["free", "free", 0.0]
[[condition]]
"""  #: the place that is moved comes next
MIDDLE_LOAD_CASE = """title = "A quarter of the upper half of a cylinder under a plate"
target_peak_displacement = 0.0075
""" + PLANES_OF_SYMMETRY + 'patch = "z_max"\n'
PLATES = {"free plates": 'displacement = ["free", "free", -0.0075]\n', "glued plates": "displacement = [0.0, 0.0, -0.0075]\n"}


def _curve_at(file: pathlib.Path, names: tuple[str, ...], at: list[float], separator: str = ",") -> list[numpy.ndarray]:
    """Values at those of the first column, of the other columns of a CSV file with these names in a line above; linear between
    lines in the order of the first column, and NaN outside.
    """
    try:
        lines = [line.split(separator) for line in file.read_text(encoding="utf-8", errors="replace").splitlines()]
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror}); take the public file") from error
    head = next((n for n, cells in enumerate(lines) if set(names) <= {cell.strip() for cell in cells}), None)
    if head is None:
        raise InputError(f"{file}: there is no line with {', '.join(names)}; take the public file")
    columns = [[cell.strip() for cell in lines[head]].index(name) for name in names]
    rows = [[_number(f"{file}:{number}", cells, column) if column < len(cells) else math.nan for column in columns]
            for number, cells in enumerate(lines[head + 1:], head + 2) if any(cell.strip() for cell in cells)]
    found = numpy.array(rows).reshape(-1, len(names))
    if len(found) < 2 or not numpy.isfinite(found).all():
        raise InputError(f"{file}: there are not two lines of numbers, or one is too short; take the public file")
    found = found[numpy.argsort(found[:, 0], kind="stable")]
    return [numpy.interp(at, found[:, 0], column, left=math.nan, right=math.nan) for column in found[:, 1:].T]


def compression_curve(data: pathlib.Path, at: list[float]) -> tuple[list[float], list[float]]:
    """Mean and standard deviation [N] of the load at compressions [m]: of a folder with the ten tests as they are published, or
    of a file with compression_mm,load_N,standard_deviation_N.
    """
    wanted = [way / MILLIMETRE for way in at]
    if data.is_dir():
        loads = [_curve_at(data / f"{data.name}_{test}.csv", ("Compression (mm)", "Load (N)"), wanted)[0] for test in TESTS]
        mean, deviation = numpy.mean(loads, axis=0), numpy.std(loads, axis=0, ddof=1)
    else:
        mean, deviation = _curve_at(data, ("compression_mm", "load_N", "standard_deviation_N"), wanted)
    if not (mean > 0.0).all() or not numpy.isfinite(deviation).all():
        raise InputError(f"{data}: the load is not known or not positive at {' '.join(f'{way:g}' for way in wanted)} mm; take the "
                         "public files")
    return mean.tolist(), deviation.tolist()


def uniform_modulus(stress: float, stretch: float) -> float:
    """Young's modulus [Pa] of an incompressible neo-Hookean body whose engineering stress at a stretch l is |stress|:
    3 |stress| / |l - l^-2|.
    """
    return 3.0 * abs(stress) / abs(stretch - stretch ** -2)


def ecoflex_cylinder(data: pathlib.Path) -> dict[str, Any]:
    summary = [] if data.is_dir() else [f"{data.name} is a summary of the ten published files"]
    way = [FIT_AT, *COMPARE_AT]
    force, deviation = compression_curve(data, way)
    modulus = uniform_modulus(force[0] / (math.pi * RADIUS ** 2), 1.0 - FIT_AT / HEIGHT)
    material: dict[str, Any] = {"density": 1040.0, "young_modulus": modulus, "poisson_ratio": 0.499}
    if data.stem in LAWS:
        (c10, c20, c30), (first, second), exponent = LAWS[data.stem]
        material["laws"] = {"yeoh": [c20 / c10, c30 / c10], "mooney_rivlin": [second / (first + second)], "ogden": [exponent]}
    return {"assumptions": [
                "friction at the plates is not known: plates free of friction and plates that the silicone sticks to are the two "
                "bounds of it",
                "the side of the cylinder never touches a plate that it sticks to",
                "Young's modulus is that of a uniform neo-Hookean cylinder at a compression of 1.5 mm; each model then has its own "
                "there, so only the shape of the curve is compared",
                "Poisson's ratio is 0.499",
                "the test is slow, and nothing relaxes",
                "a quarter of the upper half is solved, as plane symmetry lets it", *summary],
            "cylinder": {"radius": RADIUS, "height": 0.5 * HEIGHT, "edge_length": 0.0035, "quarter": True},
            "material": material, "damping_from": "",
            "state": [{"name": name, "noise": 0.0, "load_case": MIDDLE_LOAD_CASE + plate, "displacement": [],
                       "force": {"place": "z_max", "way": way, "force": force, "deviation": deviation, "parts": 4.0,
                                 "length": HEIGHT}} for name, plate in PLATES.items()]}


# --- a strip of the silicone of the beam that is pulled, with the force (Marechal et al. 2020)

STRIP = [0.033, 0.006, 0.003]  #: length, width and thickness between the grips [m]
PULLED_TO = [0.1, 0.2, 0.3, 0.5, 1.0]  #: engineering strains; a modulus is fitted at the first
PULLED_LOAD_CASE = """title = "A strip that is pulled, and narrows freely"
target_peak_displacement = 0.033
""" + PLANES_OF_SYMMETRY + 'patch = "x_max"\ndisplacement = [0.033, "free", "free"]\n'


def dragon_skin_tension(file: pathlib.Path) -> dict[str, Any]:
    stress = 1e6 * _curve_at(file, ("Engineering Strain", "Engineering Stress (MPa)"), PULLED_TO, ";")[0]
    if not (stress > 0.0).all():
        raise InputError(f"{file}: the stress is not known or not positive at strains of {PULLED_TO}; take the public file")
    return {"assumptions": [
                "the strip is as long between the grips as its file says, and strains are those of the grips, which the file says too",
                "it narrows freely up to the grips",
                "Young's modulus is that of a uniform neo-Hookean strip at a strain of 0.1",
                "Poisson's ratio is 0.499",
                "the test took 4 s to a strain of 1, and nothing relaxes",
                "one test is published, so its deviation is not known"],
            "box": {"size": STRIP, "edge_length": 0.003},
            "material": {"density": 1070.0, "young_modulus": uniform_modulus(float(stress[0]), 1.0 + PULLED_TO[0]),
                         "poisson_ratio": 0.499},
            "damping_from": "",
            "state": [{"name": "pulled", "noise": 0.0, "load_case": PULLED_LOAD_CASE, "displacement": [],
                       "force": {"place": "x_max", "way": [STRIP[0] * strain for strain in PULLED_TO],
                                 "force": (STRIP[1] * STRIP[2] * stress).tolist(), "deviation": [0.0] * len(PULLED_TO),
                                 "parts": 1.0, "length": STRIP[0]}}]}


READERS: dict[str, Callable[[pathlib.Path], dict[str, Any]]] = {  # by what the name of an experiment begins with
    "dragon_skin_beam": dragon_skin_beam, "dragon_skin_tension": dragon_skin_tension, "ecoflex_": ecoflex_cylinder,
    "truth_cube": truth_cube}


def doubts_about_files(digests: dict[pathlib.Path, str]) -> list[str]:
    """A sentence for each file, or folder of CSV files, whose SHA-256 digest is not the published one; what is not there has none."""
    doubts = []
    for file, published in digests.items():
        parts = sorted(file.glob("*.csv")) if file.is_dir() else [file] if file.is_file() else []
        found = hashlib.sha256(b"".join(part.read_bytes() for part in parts)).hexdigest() if parts else published
        if found != published:
            doubts.append(f"{file.name} is not the published file (its SHA-256 begins with {found[:12]}, and that of the published one "
                          f"with {published[:12]}), so numbers may differ from published ones")
    return doubts


def main(name: str, data: str, *digests: str) -> int:
    try:
        made = next(reader for start, reader in READERS.items() if name.startswith(start))(pathlib.Path(data))
        made["assumptions"] += doubts_about_files(dict(zip(map(pathlib.Path, digests[::2]), digests[1::2])))
        text = to_toml(made, "state")
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return 2
    sys.stdout.buffer.write(text.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
