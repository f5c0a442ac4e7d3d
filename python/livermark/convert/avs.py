"""Reads the mesh of an AVS-UCD file in text: nodes, cells and their material numbers; its values are named.

The reader of meshio fails where cells have values. https://lanl.github.io/LaGriT/pages/docs/read_avs.html"""
from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy

from livermark.convert.abaqus import lines_of
from livermark.errors import InputError

CELL_TYPES = {"pt": ("vertex", 1), "line": ("line", 2), "tri": ("triangle", 3), "quad": ("quad", 4), "tet": ("tetra", 4),
              "pyr": ("pyramid", 5), "prism": ("wedge", 6), "hex": ("hexahedron", 8)}
FIRST_BYTES = 1 << 16  #: that have the first line without a comment


def _counts(lines: list[str]) -> list[int]:
    """Numbers of nodes, cells, and values of nodes, cells and the whole; nothing if the first line does not have them."""
    words = lines[0].split() if lines else []
    return [int(word) for word in words] if len(words) == 5 and all(word.isdecimal() for word in words) else []


def is_avs(path: str) -> bool:
    """Whether a file that may as well be of Abaqus begins as one of AVS."""
    with open(path, "rb") as file:
        start = file.read(FIRST_BYTES).decode("latin-1").splitlines()
    return bool(_counts([line for line in start if line.strip() and not line.startswith("#")]))


def _names(lines: list[str], at: int) -> list[str]:
    """Of values that are described from this line on: how many components each has, then a line for each."""
    return [line.split(",")[0].strip() for line in lines[at + 1:at + 1 + int(lines[at].split()[0])]]


def _cell(line: str, index: dict[int, int]) -> tuple[str, int, list[int]]:
    _, material, word, *nodes = line.split()
    name, corners = CELL_TYPES.get(word.lower(), (word, len(nodes)))
    if len(nodes) != corners:
        raise InputError(f"a cell of type {word[:20]} has {len(nodes)} nodes and not {corners}")
    try:
        return name, int(material), [index[int(node)] for node in nodes]
    except KeyError as error:
        raise InputError(f"there is no node {error}; correct the cell") from None


def read(path: str) -> Any:
    """What has the attributes of a meshio.Mesh, and `remarks`. Raises InputError, in which the file is not named."""
    lines = lines_of(path, "#")
    counts = _counts(lines)
    if not counts:
        raise InputError("its first line has not the five numbers of AVS-UCD in text; binary files are not read")
    num_nodes, num_cells, of_nodes, of_cells, _ = counts
    cells_end = 1 + num_nodes + num_cells
    if len(lines) < cells_end:
        raise InputError("the file ends too early")
    nodes = [line.split() for line in lines[1:1 + num_nodes]]
    index = {int(words[0]): k for k, words in enumerate(nodes)}
    points = numpy.array([[float(word) for word in words[1:4]] for words in nodes]).reshape(-1, 3)
    blocks: list[Any] = []
    for line in lines[1 + num_nodes:cells_end]:
        name, material, corners = _cell(line, index)
        if not blocks or blocks[-1].type != name or len(blocks[-1].data[-1]) != len(corners):
            blocks.append(SimpleNamespace(type=name, data=[], material=[]))
        blocks[-1].data.append(corners)
        blocks[-1].material.append(material)
    values, at = [], cells_end
    for count, rows in ((of_nodes, num_nodes), (of_cells, num_cells)):
        if count:
            values += _names(lines, at)
            at += 1 + int(lines[at].split()[0]) + rows
    for block in blocks:
        block.data = numpy.array(block.data, dtype=int)
        if block.type == "tetra":
            block.data = block.data[:, [0, 1, 3, 2]]  # AVS looks at a tetrahedron from the other side
    remarks = [f"values that are not used: {', '.join(values)}"] if values else []
    return SimpleNamespace(points=points, cells=blocks, cell_data={"avsucd:material": [numpy.array(b.material) for b in blocks]},
                           cell_sets={}, field_data={}, point_data={}, remarks=remarks)
