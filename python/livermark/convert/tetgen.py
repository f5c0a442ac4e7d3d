"""Reads a mesh of TetGen: NAME.node and NAME.ele, with attributes of regions that need not be whole numbers.

https://wias-berlin.de/software/tetgen/fformats.html"""
from __future__ import annotations

import os
import pathlib
from typing import Any

import numpy

from livermark.errors import InputError
from livermark.convert.groups import MOST_GROUPS


def _beside(path: pathlib.Path, ending: str) -> pathlib.Path:
    """The other file, in whatever case."""
    for entry in path.parent.iterdir():
        if entry.stem == path.stem and entry.suffix.lower() == ending and entry.is_file():
            return entry
    raise InputError(f"there is no file '{path.stem}{ending}' beside it, and a mesh of TetGen is in both")


def _rows(path: pathlib.Path, header: int) -> tuple[list[int], numpy.ndarray]:
    """The numbers of the first row, and those of the others, without comments."""
    with open(path, encoding="utf-8-sig", errors="replace") as file:
        rows = [words for line in file if (words := line.split("#")[0].split())]
    try:
        first = [int(word) for word in rows[0]]
        numbers = numpy.array([[float(word) for word in row] for row in rows[1:1 + first[0]]])
    except (ValueError, IndexError):
        raise InputError(f"a row of {path.name} has no numbers, or not as many as the one before; it is damaged") from None
    if len(first) < header or len(numbers) != first[0] or numbers.ndim != 2:
        raise InputError(f"{path.name} has {len(numbers)} rows and not those that its first one tells; it is damaged")
    if not numpy.isfinite(numbers).all():
        raise InputError(f"a number of {path.name} is not finite; correct it")
    return first, numbers


def read(source: str) -> Any:
    """A meshio.Mesh. Raises InputError, in which the file is not named."""
    import meshio
    given = pathlib.Path(source)
    nodes_file = given if given.suffix.lower() == ".node" else _beside(given, ".node")
    elements_file = given if given.suffix.lower() == ".ele" else _beside(given, ".ele")
    if os.path.getsize(nodes_file) + os.path.getsize(elements_file) > 1 << 31:
        raise InputError("it has more than 2 GB; save it in another format")
    (_, dimension, *_), nodes = _rows(nodes_file, 2)
    (_, corners, *_), elements = _rows(elements_file, 2)
    if dimension != 3 or corners not in (4, 10) or nodes.shape[1] < 4 or elements.shape[1] < 1 + corners:
        raise InputError("its nodes have no three coordinates, or its tetrahedra neither four nor ten nodes")
    index = {int(number): k for k, number in enumerate(nodes[:, 0])}
    try:
        cells = numpy.array([[index[int(number)] for number in row] for row in elements[:, 1:1 + corners]], dtype=int)
    except KeyError as error:
        raise InputError(f"there is no node {error}; correct the element") from None
    data, names = {}, {}
    for k, column in enumerate(elements[:, 1 + corners:].T):
        values = numpy.unique(column)
        if not numpy.array_equal(column, numpy.round(column)) and len(values) <= MOST_GROUPS:
            if k == 0:
                names = {f"{value:g}": numpy.array([number, 3]) for number, value in enumerate(values, start=1)}
            column = numpy.searchsorted(values, column) + 1
        whole = numpy.array_equal(column, numpy.round(column))
        data["tetgen:ref" if k == 0 else f"tetgen:ref{k + 1}"] = [column.astype(int) if whole else column]
    attributes = {f"tetgen:attr{k + 1}": column for k, column in enumerate(nodes[:, 4:].T)}
    return meshio.Mesh(nodes[:, 1:4], [("tetra" if corners == 4 else "tetra10", cells)], cell_data=data,
                       point_data=attributes, field_data=names)
