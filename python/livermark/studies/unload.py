"""Finds the shape of a scanned body without gravity, and what taking the scan for that shape costs.

    livermark mesh unload BODY --model fem_p2p1_neo_hookean nodal_neo_hookean --direction supine -o FOLDER
      [--support LOAD_CASE.toml] [--load-case palpation traction large_traction]

A scan x is taken under gravity. Its unloaded shape X is the body at rest that gravity moves to x: phi(X) = x, where phi is the
equilibrium of a model. Each model gets its own X, by the fixed point X <- X + x - phi(X) of the inverse design of Sellier 2011 (An
iterative method for the inverse elasto-static problem, J. Fluids Struct. 27(8)), accelerated by Anderson's mixing (Walker, Ni 2011,
SIAM J. Numer. Anal. 49(4)). The search starts from the scan under reversed gravity.

FOLDER gets a .toml and .msh of the unloaded body of each model, the load case gravity.toml, and table.md. With --load-case, the
response to a tool on the scan without gravity is compared with that of the reference, which is the first model: on its unloaded
body, gravity with the tool minus gravity alone. The tool is a uniform traction on the facets that the load case loads, with its
resultant; where the load case presses to a depth, the resultant is 10 mN. Exit status 1: no unloaded shape by a model is found; 2: bad input.
"""
from __future__ import annotations

import argparse
import math
import pathlib
import sys
from dataclasses import dataclass, field
from typing import Callable, Optional

import numpy

from livermark.errors import InputError
from livermark.studies.scanned_bodies import GRAVITY, Array, NoEquilibrium, Scan, Tool, read_toml, shipped
from livermark.studies.tables import MILLIMETRES, PERCENT, Column, Table, fixed, significant
from livermark.volumes import nodal_volumes, tetrahedron_volumes

#: Directions of gravity in the axes of the patient (LPS), by how the patient lies
DIRECTIONS = {"supine": (0.0, 1.0, 0.0), "prone": (0.0, -1.0, 0.0), "left_side": (1.0, 0.0, 0.0), "right_side": (-1.0, 0.0, 0.0),
              "standing": (0.0, 0.0, -1.0)}
#: How the patient lies, by the words of DICOM for it (patient position, 0018,5100)
LYING = {"S": "supine", "P": "prone", "DL": "left_side", "DR": "right_side"}
NUM_KEPT = 8  #: earlier iterates that Anderson's mixing uses
MOST_HALVINGS = 6  #: of a step that leads to no equilibrium
FEWER_STEPS, MORE_STEPS = 1, 5  #: of growing gravity, the second where the first finds nothing
ON_THE_WAY = 0.01  #: tolerance below the whole gravity
LEAST_GAP = 1e-6  #: [m], small enough for any scan


@dataclass
class Unloaded:
    """The unloaded shape of a model, or a sentence on why none is found."""
    model: str
    points: Optional[Array] = None  #: (N, 3) [m]
    solves: int = 0  #: equilibria that were looked for
    gap: float = numpy.nan  #: largest |phi(X) - x| [m]
    sentence: str = ""
    loaded: Array = field(default_factory=lambda: numpy.zeros((0, 3)))  #: phi(X) [m]


def lengths(vectors: Array) -> Array:
    return numpy.linalg.norm(vectors, axis=1)


def mixed(shapes: list[Array], gaps: list[Array]) -> Array:
    """The next iterate by Anderson's mixing of all given ones, of which the last is the newest."""
    if len(shapes) == 1:
        return shapes[-1] + gaps[-1]
    steps = numpy.stack([(b - a).ravel() for a, b in zip(shapes, shapes[1:])], axis=1)
    changes = numpy.stack([(b - a).ravel() for a, b in zip(gaps, gaps[1:])], axis=1)
    weights = numpy.linalg.lstsq(changes, gaps[-1].ravel(), rcond=1e-10)[0]
    return shapes[-1] + gaps[-1] - ((steps + changes) @ weights).reshape(gaps[-1].shape)


def search(forward: Callable[[Array], Array], target: Array, start: Array, is_small: Callable[[Array, Array], bool],
           most_solves: int, tell: Callable[[str], None]) -> tuple[Array, Array]:
    """X with forward(X) = target, and forward(X). Steps that fail, or that triple the gap, are halved."""
    shapes: list[Array] = []
    gaps: list[Array] = []
    best: Optional[tuple[Array, Array]] = None
    shape, halvings, reason = start, 0, ""
    for solve in range(1, most_solves + 1):
        try:
            gap = target - forward(shape)
            size = float(lengths(gap).max())
            tell(f"  solve {solve}: the largest gap to the scan is {MILLIMETRES * size:.6f} mm")
            reason = f"the gap to the scan is still {MILLIMETRES * size:.3g} mm after {solve} equilibria"
            if is_small(gap, shape):
                return shape, target - gap
            has_failed = best is not None and size > 3.0 * lengths(best[1]).max()
        except NoEquilibrium as error:
            tell(f"  solve {solve}: {error}")
            reason, has_failed = str(error), True
        if not has_failed:
            shapes, gaps = [*shapes[1 - NUM_KEPT:], shape], [*gaps[1 - NUM_KEPT:], gap]
            if best is None or size < lengths(best[1]).max():
                best, halvings = (shape, gap), 0
            shape = mixed(shapes, gaps)
        elif best is None or halvings == MOST_HALVINGS:
            break
        else:
            halvings += 1
            shapes, gaps = [best[0]], [best[1]]
            shape = best[0] + 0.5**halvings * best[1]
    raise NoEquilibrium(reason)


def unload(scan: Scan, model: str, tolerance: float = 1e-3, least_gap: float = LEAST_GAP, most_solves: int = 40,
           tell: Callable[[str], None] = lambda line: None) -> Unloaded:
    """The unloaded shape of a scan by a model. It has been found when the largest gap between its equilibrium under gravity and the
    scan is below a tolerance of the largest displacement, or below least_gap [m]. Gravity grows in steps where one does not do."""
    result = Unloaded(model)

    def forward_under(part: float) -> Callable[[Array], Array]:
        def forward(points: Array) -> Array:
            result.solves += 1
            if (tetrahedron_volumes(points, scan.tetrahedra) * scan.volumes <= 0.0).any():
                raise NoEquilibrium("tetrahedra of the unloaded shape are inverted")
            return scan.moved(model, points, part)
        return forward

    def lifted(part: float) -> Array:
        """The scan under reversed gravity, or as it is where that has no equilibrium."""
        try:
            return forward_under(-part)(scan.points)
        except NoEquilibrium as error:
            tell(f"  the scan under reversed gravity: {error}")
            return scan.points

    def is_below(limit: float) -> Callable[[Array, Array], bool]:
        def is_small(gap: Array, points: Array) -> bool:
            largest = lengths(gap).max()
            return bool(largest <= least_gap or largest <= limit * lengths(points - scan.points).max())
        return is_small
    for steps in (FEWER_STEPS, MORE_STEPS):
        try:
            shape = scan.points
            for step in range(1, steps + 1):
                tell(f"{model}: {100.0 * step / steps:.0f} % of gravity")
                start = lifted(1.0 / steps) if step == 1 else scan.points + step / (step - 1) * (shape - scan.points)
                is_small = is_below(tolerance if step == steps else max(tolerance, ON_THE_WAY))
                shape, result.loaded = search(forward_under(step / steps), scan.points, start, is_small, most_solves, tell)
            result.points, result.gap, result.sentence = shape, float(lengths(result.loaded - scan.points).max()), ""
            return result
        except NoEquilibrium as error:
            result.sentence = f"at {100.0 * step / steps:.0f} % of gravity: {error}"
            tell(f"{model}: {result.sentence}")
    return result


def shape_table(scan: Scan, found: list[Unloaded]) -> Table:
    rows = []
    reference = found[0].points
    for each in found:
        if each.points is None:
            rows.append([each.model, str(each.solves), *["-"] * 8])
            continue
        volumes = tetrahedron_volumes(each.points, scan.tetrahedra)
        away = lengths(each.points - scan.points)
        apart = numpy.array([numpy.nan]) if reference is None else lengths(each.points - reference)
        numbers = [numpy.median(away), numpy.quantile(away, 0.95), away.max(), numpy.median(apart), apart.max()]
        rows.append([each.model, str(each.solves), f"{MILLIMETRES * each.gap:.1e}",
                     fixed(PERCENT * (volumes.sum() / scan.volumes.sum() - 1.0), 2),
                     *(fixed(MILLIMETRES * float(number), 2) for number in numbers), fixed(float((scan.volumes / volumes).min()), 3)])
    return Table([Column("model"), *(Column(title, True) for title in (
        "equilibria", "gap [mm]", "volume [%]", "median [mm]", "95 % [mm]", "largest [mm]", "to reference: median [mm]",
        "largest [mm]", "least J"))], rows)


def responses(scan: Scan, each: Unloaded, tool: Tool, tell: Callable[[str], None]) -> tuple[dict[bool, Array], list[str]]:
    """Displacements (N, 3) [m] by a tool, by whether gravity is there: on the unloaded body, or ignored on the scan."""
    found, sentences = {}, []
    for has_gravity in [True, False] if each.points is not None else [False]:
        words = "on its unloaded body" if has_gravity else "on the scan without gravity"
        tell(f"{tool.name}: {each.model} {words}")
        try:
            found[has_gravity] = (scan.moved(each.model, each.points, 1.0, tool) - each.loaded if has_gravity else
                                  scan.moved(each.model, scan.points, 0.0, tool) - scan.points)
        except NoEquilibrium as error:
            sentences.append(f"{tool.name}, {each.model} {words}: {error}.")
    return found, sentences


def cost_table(scan: Scan, found: list[Unloaded], load_cases: list[str], tell: Callable[[str], None]) -> tuple[Table, list[str]]:
    """Errors against the reference on its unloaded body, of each model that ignores gravity and on its own unloaded body; and
    sentences on what is left out."""
    rows, left_out = [], []
    weight = nodal_volumes(scan.points, scan.tetrahedra)[:, None]
    for load_case in load_cases:
        try:
            tool = scan.tool_of(load_case)
            scan.load_case(scan.gravity, tool)  # says where it acts on what is held
        except NoEquilibrium as error:
            left_out.append(f"{error}.")
            continue
        truth: Optional[Array] = None
        for each in found:
            moved, sentences = responses(scan, each, tool, tell)
            left_out += sentences
            truth = moved.get(True) if each is found[0] else truth
            if truth is None:
                break
            size = sum(float(numpy.linalg.norm(force)) for force in tool.forces)
            there = tool.displacement(scan.triangles, truth, scan.points)
            cells = {has_gravity: [f"{PERCENT * (there / tool.displacement(scan.triangles, field, scan.points) - 1.0):+.1f}",
                                   fixed(PERCENT * math.sqrt((weight * (field - truth)**2).sum() / (weight * truth**2).sum()), 1)]
                     for has_gravity, field in moved.items()}
            cells = {False: ["-", "-"], True: ["-", "-"], **cells, **({True: ["reference", "-"]} if each is found[0] else {})}
            rows.append([tool.name, fixed(1e3 * size, 1), significant(MILLIMETRES * there, 3), each.model, *cells[False], *cells[True]])
    return Table([Column("load case"), Column("force [mN]", True), Column("moves [mm]", True), Column("model"), *(
        Column(title, True) for title in ("ignoring gravity: tool [%]", "L2 [%]", "own unloaded: tool [%]", "L2 [%]"))], rows), left_out


def lying(body: str, tell: Callable[[str], None]) -> str:
    """How the patient lay in the scan that a body is made of: as its header says, else supine."""
    path = shipped(body, "meshes")
    position = str(read_toml(path).get("image", {}).get("patient_position", "")) if path.suffix == ".toml" else ""
    if position[:2] in ("HF", "FF") and position[2:] in LYING:
        return LYING[position[2:]]
    said = f"says {position}, which is not understood" if position else "does not say how the patient lay"
    tell(f"The header of the scan {said}; supine is assumed, --direction sets it")
    return "supine"


def direction_of(text: str) -> tuple[float, ...]:
    if text in DIRECTIONS:
        return DIRECTIONS[text]
    try:
        vector = numpy.array([float(part) for part in text.split(",")])
    except ValueError:
        vector = numpy.zeros(0)
    if vector.shape != (3,) or not numpy.isfinite(vector).all() or not vector.any():
        raise InputError(f"--direction {text}: give one of {', '.join(DIRECTIONS)}, or three numbers such as --direction=0,1,0")
    return tuple((vector / numpy.linalg.norm(vector)).tolist())


def main(arguments: Optional[list[str]] = None) -> int:
    parser = argparse.ArgumentParser(prog="livermark mesh unload", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("body", help="one that ships, or a .toml or mesh file")
    parser.add_argument("--model", nargs="+", default=["fem_p2p1_neo_hookean", "nodal_neo_hookean"], help="the first is the reference")
    parser.add_argument("--direction", help=f"of gravity in LPS: {', '.join(DIRECTIONS)}, or =x,y,z (as the header of the scan says the "
                        "patient lay, else supine)")
    parser.add_argument("--acceleration", type=float, default=GRAVITY, help="[m/s^2] (9.81)")
    parser.add_argument("--support", default="large_tilt", help="load case whose held places and foundation bear the body (large_tilt)")
    parser.add_argument("--load-case", nargs="*", default=[], help="tools under which ignoring gravity is judged")
    parser.add_argument("--tolerance", type=float, default=1e-3, help="largest gap to the scan, of the largest displacement (1e-3)")
    parser.add_argument("--most-solves", type=int, default=40, help="equilibria for a step of gravity (40)")
    parser.add_argument("-o", "--output", required=True, type=pathlib.Path, help="folder")
    options = parser.parse_args(arguments)

    def tell(line: str) -> None:
        print(line, file=sys.stderr, flush=True)
    try:
        if not (0.0 < options.tolerance < 1.0 and options.most_solves > 0 and 0.0 < options.acceleration < 1e3):
            raise InputError("--tolerance is between 0 and 1, --most-solves above 0, --acceleration above 0 and below 1000; change them")
        direction = direction_of(options.direction or lying(options.body, tell))
        scan = Scan(options.body, options.support, direction, options.output, options.acceleration)
        found = []
        name = pathlib.Path(options.body).stem
        for model in options.model:
            found.append(unload(scan, model, options.tolerance, most_solves=options.most_solves, tell=tell))
            if (points := found[-1].points) is not None:
                scan.write_body(options.output / f"{name}_unloaded_{model}.toml", points, f"{name}, unloaded by {model}")
        parts = [shape_table(scan, found).markdown()]
        parts += [f"No unloaded shape by {each.model} is found {each.sentence}.\n" for each in found if each.points is None]
        if options.load_case and found[0].points is not None:
            tell("\n".join(parts))
            table, left_out = cost_table(scan, found, options.load_case, tell)
            parts += [table.markdown(), *(line + "\n" for line in left_out)]
        elif options.load_case:
            parts.append(f"What ignoring gravity costs is not known, as {found[0].model} is the reference.\n")
        text = "\n".join(parts)
        (options.output / "table.md").write_text(text)
    except (InputError, OSError) as error:
        print(f"livermark: {error}", file=sys.stderr)
        return 2
    print(text, end="")
    return 1 if any(each.points is None for each in found) else 0


if __name__ == "__main__":
    sys.exit(main())
