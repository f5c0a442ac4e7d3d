"""Reads the mesh of a Nastran bulk data file: GRID, tetrahedra, triangles and their property numbers.

The reader of meshio takes coordinates of any system for Cartesian ones, and knows neither exponents with a D nor files
without BEGIN BULK."""
from __future__ import annotations

import re
from typing import Any, Iterator

import numpy

from livermark.convert.abaqus import MOST_NAMED, lines_of
from livermark.errors import InputError

#: Number of corners, their number with the middles of edges, and the types of cells of both.
SHAPES = {"CTETRA": (4, 10, "tetra", "tetra10"), "CPENTA": (6, 15, "wedge", "wedge15"),
          "CHEXA": (8, 20, "hexahedron", "hexahedron20"), "CPYRAM": (5, 13, "pyramid", "pyramid13"),
          "CPYRA": (5, 13, "pyramid", "pyramid13"), "CTRIA3": (3, 3, "triangle", "triangle"),
          "CTRIAR": (3, 3, "triangle", "triangle"), "CTRIA6": (3, 6, "triangle", "triangle6"),
          "CQUAD4": (4, 4, "quad", "quad"), "CQUADR": (4, 4, "quad", "quad"), "CQUAD8": (4, 8, "quad", "quad8")}
SYSTEMS = {"CORD1R": "rectangular", "CORD2R": "rectangular", "CORD1C": "cylindrical", "CORD2C": "cylindrical",
           "CORD1S": "spherical", "CORD2S": "spherical"}
SMALL, LARGE = 8, 16  #: columns of a field


def _fields(line: str) -> tuple[str, list[str]]:
    """The first field of a line, and its eight or four others."""
    if "," in line:
        first, *others = [word.strip() for word in line.split(",")]
        num_fields = 4 if "*" in first else 8
        return first, (others + num_fields * [""])[:num_fields]
    line = line.expandtabs(SMALL)
    first = line[:SMALL].strip()
    width = LARGE if "*" in first else SMALL
    return first, [line[at:at + width].strip() for at in range(SMALL, SMALL + 8 * SMALL, width)]


def _cards(lines: list[str]) -> Iterator[tuple[str, list[str]]]:
    """Name and fields of each card, with those of the lines that continue it."""
    name, fields = "", []
    for line in lines:
        first, others = _fields(line)
        if name and (not first or first[0] in "+*"):
            fields += others
            continue
        if name:
            yield name, fields
        name, fields = first.rstrip("*").strip(), others
    if name:
        yield name, fields


def _bulk(lines: list[str]) -> list[str]:
    """The lines of the bulk data, which may be all of the file."""
    kept = [upper for line in lines if (upper := line.split("$")[0].rstrip().upper())]
    begins = [k for k, line in enumerate(kept) if re.match(r"\s*BEGIN\s+(BULK|SUPER)", line)]
    if len(begins) > 1 or any("SUPER" in kept[k] for k in begins):
        raise InputError("it has several parts (BEGIN SUPER); merge them to one, and save that alone")
    kept = kept[begins[0] + 1:] if begins else kept
    end = next((k for k, line in enumerate(kept) if line.startswith("ENDDATA")), len(kept))
    for line in kept[:end]:
        if line.startswith("INCLUDE"):
            raise InputError(f"it goes on in another file, {line[7:].strip()[:80]}; put that into it")
    return kept[:end]


def _integer(word: str, name: str) -> int:
    try:
        return int(word)
    except ValueError:
        raise InputError(f"'{word[:40]}' in {name} is no whole number; correct it") from None


def _real(word: str) -> float:
    """1.5, 1.5E3, 1.5D3 or 1.5+3; an empty field is zero."""
    try:
        return float(re.sub(r"(?<=[0-9.])(?=[+-])", "E", word.replace("D", "E"))) if word else 0.0
    except ValueError:
        raise InputError(f"'{word[:40]}' in GRID is not a number; correct it") from None


def _shape(name: str, nodes: list[str]) -> tuple[str, int]:
    """The type of cells, and how many of the nodes it has: tetrahedra may lack some middles of edges."""
    corners, with_middles, plain, curved = SHAPES[name]
    if not all(nodes[:corners]) or len(nodes) < corners:
        raise InputError(f"an element {name} has fewer than {corners} corners; correct it")
    return (curved, with_middles) if len(nodes) >= with_middles > corners and all(nodes[:with_middles]) else (plain, corners)


def _refuse_systems(nodes_of: dict[str, str], kinds: dict[str, str]) -> None:
    """nodes_of: a node of each coordinate system that a node is in."""
    for system, node in nodes_of.items():
        raise InputError(f"the coordinates of node {node} are of the {kinds.get(system, 'unknown')} system {system}, which is "
                         "not converted; save all nodes in the basic system (GRID with CP 0)")


def read(path: str) -> Any:
    """A meshio.Mesh with `remarks` on what is not used. Raises InputError, in which the file is not named."""
    import meshio
    points: list[list[float]] = []
    index: dict[int, int] = {}
    blocks: list[tuple[str, list[list[str]], list[int]]] = []  # type of cells, their nodes and properties
    elements: set[int] = set()
    usual_system, nodes_of, kinds, unused = "", {}, {}, []
    cards = list(_cards(_bulk(lines_of(path, "$"))))
    for name, fields in cards:
        if name == "GRDSET":
            usual_system = fields[1]
    for name, fields in cards:
        if name == "GRID":
            number, system = _integer(fields[0], name), (fields[1] or usual_system).lstrip("0")
            if number in index:
                raise InputError(f"node {number} occurs twice; remove one")
            if system:
                nodes_of.setdefault(system, fields[0])
            index[number] = len(points)
            points.append([_real(word) for word in fields[2:5]])
        elif name in SHAPES:
            number = _integer(fields[0], name)
            if number in elements:
                raise InputError(f"element {number} occurs twice; remove one")
            elements.add(number)
            kind, count = _shape(name, fields[2:])
            if not blocks or blocks[-1][0] != kind:
                blocks.append((kind, [], []))
            blocks[-1][1].append(fields[2:2 + count])
            blocks[-1][2].append(_integer(fields[1] or fields[0], name))  # a property that is left out has this number
        elif name in SYSTEMS:
            for place in (0, 4) if name.startswith("CORD1") else (0,):
                kinds[fields[place]] = SYSTEMS[name]
        elif name != "GRDSET":
            unused.append(name)
    _refuse_systems(nodes_of, kinds)
    try:
        cells = [(kind, numpy.array([[index[_integer(word, "an element")] for word in row] for row in rows], dtype=int))
                 for kind, rows, _ in blocks]
    except KeyError as error:
        raise InputError(f"there is no node {error}; correct the element") from None
    mesh = meshio.Mesh(numpy.array(points, dtype=float).reshape(-1, 3), cells,
                       cell_data={"nastran:ref": [numpy.array(properties) for _, _, properties in blocks]} if blocks else {})
    named = list(dict.fromkeys(unused))
    more = f" and {len(named) - MOST_NAMED} more" if len(named) > MOST_NAMED else ""
    mesh.remarks = [f"cards that are not used: {', '.join(name[:8] for name in named[:MOST_NAMED])}{more}"] if named else []
    return mesh
