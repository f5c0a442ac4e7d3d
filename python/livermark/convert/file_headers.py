"""Numbers of nodes and cells that a mesh file says itself, to check what a library has read of it.

Each function here reads the lines or bytes that hold these numbers, and nothing else. Readers of this project check the numbers
as they read."""
from __future__ import annotations

import re
import struct
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, NamedTuple, Optional

from livermark.errors import InputError


class Counts(NamedTuple):
    nodes: int
    cells: int  #: of all types that are counted
    types: Optional[tuple[str, ...]] = None  #: which begin so are counted; None: all


def _all(pattern: bytes, data: bytes) -> list[int]:
    return [int(word) for word in re.findall(pattern, data, re.MULTILINE | re.IGNORECASE)]


def _of_gmsh(data: bytes) -> Optional[Counts]:
    format_line = re.search(rb"^\$MeshFormat\s+(\S+)\s+([01])\s+\d+", data, re.MULTILINE)
    if not format_line:
        return None
    version, is_binary = float(format_line[1]), format_line[2] == b"1"
    counts = []
    for section in (rb"Nodes", rb"Elements"):
        found = re.search(rb"^\$" + section + rb"[ \r]*\n", data, re.MULTILINE)
        if not found:
            return None
        if is_binary and version >= 4.0:
            order = "<" if b"\n\1\0\0\0" in data[format_line.end():format_line.end() + 8] else ">"
            counts.append(struct.unpack_from(order + "QQ", data, found.end())[1])
        else:
            words = data[found.end():found.end() + 200].split()
            counts.append(int(words[1] if version >= 4.0 else words[0]))
    return Counts(*counts)


VOLUME_AND_FACES = ("tetra", "hexahedron", "triangle", "quad")


def _of_medit(data: bytes) -> Optional[Counts]:
    def of(name: bytes) -> int:
        return sum(_all(rb"^[ \t]*" + name + rb"[ \t\r]*\n?[ \t]*(\d+)[ \t\r]*$", text))
    text = re.sub(rb"#[^\n]*", b"", data)
    nodes = of(b"Vertices")
    cells = sum(map(of, (b"Tetrahedra", b"Hexahedra", b"Triangles", b"Quadrilaterals")))
    return Counts(nodes, cells, VOLUME_AND_FACES) if nodes else None


#: Numbers of keywords of a binary file of Medit.
GMF_END, GMF_VERTICES, GMF_COUNTED = 54, 4, (6, 7, 8, 10)  # triangles, quadrilaterals, tetrahedra, hexahedra


def _of_binary_medit(data: bytes) -> Optional[Counts]:
    """A chain of keywords, each with the place of the next."""
    order = "<" if data[:4] == b"\1\0\0\0" else ">"
    _, version = struct.unpack_from(order + "ii", data)
    place, number = ("i" if version < 3 else "q"), ("i" if version < 4 else "q")
    at, nodes, cells = 8, 0, 0
    while 0 < at < len(data):
        keyword, following = struct.unpack_from(order + "i" + place, data, at)
        if keyword == GMF_END or (following and following <= at):
            break
        count, = struct.unpack_from(order + number, data, at + struct.calcsize(order + "i" + place))
        nodes += count if keyword == GMF_VERTICES else 0
        cells += count if keyword in GMF_COUNTED else 0
        at = following
    return Counts(nodes, cells, VOLUME_AND_FACES)


def _of_su2(data: bytes) -> Optional[Counts]:
    nodes, elements = _all(rb"^[ \t]*NPOIN\s*=\s*(\d+)", data), _all(rb"^[ \t]*NELEM\s*=\s*(\d+)", data)
    return Counts(sum(nodes), sum(elements + _all(rb"^[ \t]*MARKER_ELEMS\s*=\s*(\d+)", data))) if nodes and elements else None


def _of_xdmf(data: bytes) -> Optional[Counts]:
    def first(item: Any) -> int:
        return int(item.find("DataItem").get("Dimensions").split()[0])

    root = ElementTree.fromstring(data)
    nodes, cells = [first(geometry) for geometry in root.iter("Geometry")], []
    for topology in root.iter("Topology"):
        said = topology.get("NumberOfElements") or topology.get("Dimensions")
        if not said and topology.get("TopologyType", topology.get("Type")) == "Mixed":
            return None
        cells.append(int(said.split()[0]) if said else first(topology))
    return Counts(sum(nodes), sum(cells)) if nodes and cells else None


def _of_dolfin(data: bytes) -> Optional[Counts]:
    nodes, cells = _all(rb"<vertices\s+size\s*=\s*[\"'](\d+)", data), _all(rb"<cells\s+size\s*=\s*[\"'](\d+)", data)
    return Counts(sum(nodes), sum(cells)) if nodes and cells else None


COUNTED: dict[str, Callable[[bytes], Optional[Counts]]] = {
    ".msh": _of_gmsh, ".mesh": _of_medit, ".meshb": _of_binary_medit, ".su2": _of_su2,
    ".xdmf": _of_xdmf, ".xmf": _of_xdmf, ".xml": _of_dolfin}


def check_counts(mesh: Any, ending: str, data: bytes) -> list[str]:
    """Compares a meshio.Mesh with the bytes of its file, whose name ends so, in lower case.

    Returns a sentence where the file does not say the numbers. Raises InputError if they differ."""
    blocks = [(block.type, len(block.data)) for block in mesh.cells]
    try:
        said = COUNTED[ending](data) if ending in COUNTED else None
    except Exception:  # whatever is wrong inside
        said = None
    if said is None:
        tetrahedra = sum(count for kind, count in blocks if kind.startswith("tetra"))
        return [f"a file that ends in {ending} does not say in a place known here how much it has: check that it is "
                f"{len(mesh.points)} nodes and {tetrahedra} tetrahedra"] if tetrahedra else []
    cells = sum(count for kind, count in blocks if said.types is None or kind.startswith(said.types))
    if (len(mesh.points), cells) != (said.nodes, said.cells):
        raise InputError(f"the library that reads it finds {len(mesh.points)} nodes and {cells} cells, and the file says that "
                         f"it has {said.nodes} and {said.cells}; save it as VTU or ASCII MSH")
    return []
