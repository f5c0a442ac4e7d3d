"""Reads the mesh of an Abaqus input file: nodes, elements, and all of their sets, whatever else stands there.

The reader of meshio loses sets that are named twice or by other sets, gives some to the wrong elements, and follows
*INCLUDE to any file."""
from __future__ import annotations

import re
from typing import Any, Iterator, NamedTuple, Optional, Union

import numpy

from livermark.errors import InputError

SOLIDS = {4: "tetra", 5: "pyramid", 6: "wedge", 8: "hexahedron", 10: "tetra10", 15: "wedge15", 20: "hexahedron20"}
SHELLS = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8", 9: "quad9"}
#: Keywords that only arrange the others.
SILENT = {"HEADING", "PREPRINT", "PART", "END PART", "ASSEMBLY", "END ASSEMBLY", "END INSTANCE"}
#: Keywords that make or move nodes and elements.
MAKING = {"NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "SYSTEM", "SUBMODEL", "IMPORT"}
MOST_NAMED = 10  #: keywords in a remark


Member = Union[str, range]  #: of a set: the number of an element, the name of another set, or many numbers


class Keyword(NamedTuple):
    name: str  #: in capitals, without the star
    parameters: dict[str, str]  #: names in capitals
    rows: list[list[str]]


class Part:
    """Nodes and elements that are numbered together."""

    def __init__(self) -> None:
        self.points: list[list[float]] = []
        self.index: dict[int, int] = {}  # of a node, by its number
        self.blocks: list[tuple[str, list[list[int]]]] = []  # type of cells, node numbers
        self.place: dict[int, tuple[int, int]] = {}  # block and row of an element, by its number
        self.sets: dict[str, list[Member]] = {}  # what they have, by name in capitals
        self.title: dict[str, str] = {}  # as it was first written


def lines_of(path: str, comment: str) -> list[str]:
    """Lines of text that have something and do not begin as a comment does."""
    with open(path, "rb") as file:
        data = file.read()
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        raise InputError("it is UTF-16; save it as UTF-8")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    return [line for line in text.splitlines() if line.strip() and not line.startswith(comment)]


def _keywords(lines: list[str]) -> Iterator[Keyword]:
    at = 0
    while at < len(lines) and not lines[at].startswith("*"):
        at += 1
    while at < len(lines):
        head = lines[at].strip()
        while head.endswith(",") and at + 1 < len(lines):
            at += 1
            head += lines[at].strip()
        words = [word.strip() for word in head[1:].split(",")]
        parameters = {}
        for word in words[1:]:
            name, _, value = word.partition("=")
            parameters[name.strip().upper()] = value.strip().strip('"')
        rows = []
        at += 1
        while at < len(lines) and not lines[at].startswith("*"):
            rows.append([word.strip() for word in lines[at].split(",")])
            at += 1
        yield Keyword(" ".join(words[0].upper().split()), parameters, rows)


def _number(word: str, kind: Any, keyword: str) -> Any:
    try:
        return kind(word if kind is int else word.upper().replace("D", "E"))
    except ValueError:
        raise InputError(f"'{word[:40]}' in *{keyword} is not a number; correct it") from None


def _cell_type(name: str) -> Optional[tuple[str, int]]:
    """The type of cells, and its number of nodes; nothing for what is neither a solid nor a shell."""
    if solid := re.fullmatch(r"(?:C|DC|AC|CC)3D(\d+)\w*", name):
        corners = int(solid.group(1))
        if corners not in SOLIDS:
            raise InputError(f"elements of type {name[:40]} are not known here; mesh all of the volume with C3D4")
        return SOLIDS[corners], corners
    if shell := re.fullmatch(r"(?:S|STRI|R3D|M3D|SFM3D|CPS|CPE)(\d+)\w*", name):
        corners = {65: 6}.get(int(shell.group(1)), int(shell.group(1)))
        return (SHELLS[corners], corners) if corners in SHELLS else None
    return None


def _add_nodes(part: Part, keyword: Keyword) -> None:
    if keyword.parameters.get("SYSTEM", "R").upper() != "R":
        raise InputError("its nodes are in cylindrical or spherical coordinates; save them in Cartesian ones")
    for row in keyword.rows:
        number = _number(row[0], int, "NODE")
        place = [_number(word, float, "NODE") if word else 0.0 for word in (row[1:4] + ["", "", ""])[:3]]
        if number in part.index:
            raise InputError(f"node {number} occurs twice; remove one")
        part.index[number] = len(part.points)
        part.points.append(place)


def _add_to_set(part: Part, name: str, members: list[Member]) -> None:
    key = name.upper()
    part.title.setdefault(key, name)
    part.sets.setdefault(key, []).extend(members)


def _add_elements(part: Part, keyword: Keyword, unknown: dict[str, int]) -> None:
    name = keyword.parameters.get("TYPE", "").upper()
    known = _cell_type(name)
    if known is None:
        unknown[name] = unknown.get(name, 0) + len(keyword.rows)
        return
    kind, corners = known
    numbers = [_number(word, int, "ELEMENT") for row in keyword.rows for word in row if word]
    if len(numbers) % (corners + 1):
        raise InputError(f"elements of type {name} have {corners} nodes each, and *ELEMENT has other numbers of them")
    rows = [numbers[i:i + corners + 1] for i in range(0, len(numbers), corners + 1)]
    for k, row in enumerate(rows):
        if row[0] in part.place:
            raise InputError(f"element {row[0]} occurs twice; remove one")
        part.place[row[0]] = (len(part.blocks), k)
    part.blocks.append((kind, [row[1:] for row in rows]))
    if keyword.parameters.get("ELSET"):
        _add_to_set(part, keyword.parameters["ELSET"], [str(row[0]) for row in rows])


def _members(keyword: Keyword) -> list[Member]:
    if "GENERATE" not in keyword.parameters:
        return [word for row in keyword.rows for word in row if word]
    members: list[Member] = []
    for row in keyword.rows:
        given = [_number(word, int, "ELSET") for word in row if word]
        if len(given) not in (2, 3):
            raise InputError("*ELSET, GENERATE has not two or three numbers in a row; correct it")
        first, last, step = (given + [1])[:3]
        if step < 1 or last < first:
            raise InputError("*ELSET, GENERATE goes in no step from its first element to its last; correct it")
        members.append(range(first, last + 1, step))
    return members


def _elements_of(part: Part, key: str, above: tuple[str, ...] = ()) -> tuple[set[int], int]:
    """Elements of a set, and of the sets that it names; how many that are not there it names itself."""
    found: set[int] = set()
    num_missing = 0
    for member in part.sets[key]:
        if isinstance(member, range):
            these = {number for number in part.place if number in member} if len(member) > len(part.place) else \
                    {number for number in member if number in part.place}
            num_missing += len(member) - len(these)
        elif member.lstrip("+").isdecimal():
            these = {_number(member, int, "ELSET")} & part.place.keys()
            num_missing += 1 - len(these)
        elif member.upper() in part.sets and member.upper() not in above + (key,):
            these, _ = _elements_of(part, member.upper(), above + (key,))
        else:
            raise InputError(f"the set '{part.title[key]}' names '{member[:40]}', which is no set before it; correct it")
        found |= these
    return found, num_missing


def _only_part(parts: dict[str, Part], instances: list[tuple[str, Keyword]]) -> tuple[Part, list[float]]:
    """The part that has elements, and where it is placed."""
    full = {name: part for name, part in parts.items() if part.blocks}
    if not full:
        raise InputError("there are no elements in it")
    placed = [(name, keyword) for name, keyword in instances if name in full]
    if len(full) > 1 or len(placed) > 1:
        names = [keyword.parameters.get("NAME", name) for name, keyword in placed] if len(placed) > 1 else list(full)
        named = ", ".join(name or "no part" for name in names)
        raise InputError(f"it has several parts or instances ({named[:80]}); merge them to one, and save that alone")
    moves = placed[0][1].rows if placed else []
    shift = [0.0, 0.0, 0.0]
    if moves:
        shift = [_number(word, float, "INSTANCE") if word else 0.0 for word in (moves[0] + ["", "", ""])[:3]]
    if len(moves) > 1:
        raise InputError("its instance is turned; save the mesh as it lies in the assembly")
    return next(iter(full.values())), shift


def _remarks(unused: list[str], unknown: dict[str, int], strays: dict[str, int]) -> list[str]:
    remarks = [f"{count} elements of type {name or 'unknown'} are not used" for name, count in unknown.items()]
    remarks += [f"the set '{name}' names {count} elements that are not there" for name, count in strays.items()]
    named = list(dict.fromkeys(unused))
    if named:
        more = f" and {len(named) - MOST_NAMED} more" if len(named) > MOST_NAMED else ""
        remarks.append(f"keywords that are not used: {', '.join('*' + name for name in named[:MOST_NAMED])}{more}")
    return remarks


def read(path: str) -> Any:
    """A meshio.Mesh with `remarks` on what is not used. Raises InputError, in which the file is not named."""
    import meshio
    parts: dict[str, Part] = {"": Part()}
    part_of_instance: dict[str, str] = {}
    instances: list[tuple[str, Keyword]] = []
    current, unused, unknown = "", [], {}
    for keyword in _keywords(lines_of(path, "**")):
        name, given = keyword.name, keyword.parameters
        if name == "INCLUDE" or (name in ("NODE", "ELEMENT", "ELSET") and given.get("INPUT")):
            raise InputError(f"it goes on in another file, '{given.get('INPUT', '')[:80]}'; put that into it")
        if name in MAKING:
            raise InputError(f"*{name} makes or moves nodes or elements, and is not followed; save the finished mesh")
        if name == "PART":
            current = given.get("NAME", "").upper()
            parts.setdefault(current, Part())
        elif name in ("END PART", "END INSTANCE"):
            current = ""
        elif name == "INSTANCE":
            current = given.get("PART", "").upper()
            part_of_instance[given.get("NAME", "").upper()] = current
            instances.append((current, keyword))
            parts.setdefault(current, Part())
        elif name == "NODE":
            _add_nodes(parts[current], keyword)
        elif name == "ELEMENT":
            _add_elements(parts[current], keyword, unknown)
        elif name == "ELSET":
            if "INTERNAL" not in given:  # which programs make for themselves
                owner = part_of_instance.get(given.get("INSTANCE", "").upper(), current)
                _add_to_set(parts[owner], given.get("ELSET", ""), _members(keyword))
        elif name not in SILENT:
            unused.append(name)
    part, shift = _only_part(parts, instances)
    cells, sets, strays = [], {}, {}
    for kind, rows in part.blocks:
        for row in rows:
            for number in row:
                if number not in part.index:
                    raise InputError(f"there is no node {number}; correct the element")
        cells.append((kind, numpy.array([[part.index[number] for number in row] for row in rows], dtype=int)))
    for key in part.sets:
        members: list[list[int]] = [[] for _ in cells]
        elements, num_missing = _elements_of(part, key)
        for number in sorted(elements):
            block, row = part.place[number]
            members[block].append(row)
        if num_missing:
            strays[part.title[key]] = num_missing
        sets[part.title[key]] = [numpy.array(rows, dtype=int) for rows in members]
    mesh = meshio.Mesh(numpy.array(part.points, dtype=float).reshape(-1, 3) + shift, cells, cell_sets=sets)
    mesh.remarks = _remarks(unused, unknown, strays)
    return mesh
