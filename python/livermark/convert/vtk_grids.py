"""Makes one mesh of the unstructured grid of a VTK file: its pieces are joined where they share nodes."""
from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy

from livermark.errors import InputError
from livermark.convert.vtk_files import Dataset, Piece, checked_cells, shown

#: Types of cells and the number of their corners, 0 if it varies.
CELL_TYPES = {1: ("vertex", 1), 2: ("vertex", 0), 3: ("line", 2), 4: ("poly_line", 0), 5: ("triangle", 3), 7: ("polygon", 0),
              9: ("quad", 4), 10: ("tetra", 4), 11: ("voxel", 8), 12: ("hexahedron", 8), 13: ("wedge", 6), 14: ("pyramid", 5),
              21: ("line3", 3), 22: ("triangle6", 6), 23: ("quad8", 8), 24: ("tetra10", 10), 25: ("hexahedron20", 20),
              26: ("wedge15", 15), 27: ("pyramid13", 13), 28: ("quad9", 9), 34: ("triangle7", 7), 42: ("polyhedron", 0)}
GHOST = 1  #: bit of vtkGhostType of a cell that another piece has


def _without_ghosts(piece: Piece, remarks: list[str]) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Where the cells that count begin in their list of corners, and which they are."""
    cells = piece.cells.get("CELLS", checked_cells([], []))
    if len(cells.ends) != len(piece.types):
        raise InputError(f"it has {len(cells.ends)} cells and {len(piece.types)} types of cells")
    if cells.corners.size and not (cells.corners.min() >= 0 and cells.corners.max() < len(piece.points)):
        raise InputError("a tetrahedron names a node that is not there")
    tables = (("nodes", piece.point_data, len(piece.points)), ("cells", piece.cell_data, len(piece.types)))
    for of, values, count in tables:
        if wrong := [name for name, column in values.items() if len(column) != count]:
            raise InputError(f"the values '{shown(wrong[0])}' are not as many as its {count} {of}")
    is_ghost = piece.cell_data.get("vtkGhostType", numpy.zeros(len(piece.types))).astype(int) & GHOST > 0
    if is_ghost.any():
        remarks.append(f"{is_ghost.sum()} ghost cells, which are of another piece, are left out")
    return cells.ends - numpy.diff(cells.ends, prepend=0), numpy.flatnonzero(~is_ghost)


def _joined(pieces: list[Piece], remarks: list[str]) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Which points of all pieces count, and the number that each then has: pieces share points of the same place."""
    points = numpy.concatenate([piece.points for piece in pieces]) + 0.0  # no -0
    if len(pieces) == 1:
        return numpy.arange(len(points)), numpy.arange(len(points))
    if any(len(numpy.unique(piece.points, axis=0)) < len(piece.points) for piece in pieces):
        raise InputError(f"it has {len(pieces)} pieces, and one has two nodes in one place, so that they cannot be joined; save "
                         "it as one piece")
    _, first, number = numpy.unique(points, axis=0, return_index=True, return_inverse=True)
    order = numpy.argsort(first)
    rank = numpy.empty_like(order)
    rank[order] = numpy.arange(len(order))
    remarks.append(f"its {len(pieces)} pieces are joined at {len(points) - len(first)} nodes that they share")
    return first[order], rank[number.ravel()]


def _of_all(pieces: list[Piece], attribute: str, chosen: list[Any], remarks: list[str]) -> dict[str, numpy.ndarray]:
    """Values that all pieces have, of what is chosen in each."""
    tables = [getattr(piece, attribute) for piece in pieces]
    common = [name for name in tables[0] if all(name in table for table in tables)]
    if lost := sorted({name for table in tables for name in table} - set(common)):
        remarks.append(f"values that not every piece has are not used: {', '.join(lost)}")
    return {name: numpy.concatenate([table[name][rows] for table, rows in zip(tables, chosen)]) for name in common}


def _blocks(piece: Piece, starts: numpy.ndarray, chosen: numpy.ndarray, number: numpy.ndarray) -> list[Any]:
    """The chosen cells in their order, a block for each run of the same type. number: that each point of the piece gets."""
    cells, blocks = piece.cells["CELLS"], []
    lengths = numpy.diff(cells.ends, prepend=0)
    kinds = numpy.stack([piece.types[chosen], lengths[chosen]], axis=1)
    for run in numpy.split(chosen, numpy.flatnonzero((kinds[1:] != kinds[:-1]).any(axis=1)) + 1):
        if not len(run):
            continue
        name, corners = CELL_TYPES.get(int(piece.types[run[0]]), (f"VTK {piece.types[run[0]]}", 0))
        length = int(lengths[run[0]])
        if corners and corners != length:
            raise InputError(f"a cell of type {name} has {length} corners and not {corners}")
        blocks.append(SimpleNamespace(type=name, data=number[cells.corners[starts[run][:, None] + numpy.arange(length)]]))
    return blocks


def mesh_of(dataset: Dataset) -> Any:
    """An unstructured grid with the attributes of a meshio.Mesh, `remarks` and `space`. Raises InputError."""
    if dataset.kind != "UNSTRUCTURED_GRID":
        raise InputError("it is a surface; make a body of it with `livermark mesh --surfaces`")
    remarks: list[str] = []
    pieces = [piece for piece in dataset.pieces if len(piece.types)]
    if not pieces:
        raise InputError("there are no tetrahedra in it")
    if unread := sorted({name for piece in pieces for name in piece.not_numbers}):
        remarks.append(f"values that are not read: {', '.join(unread)}")
    found = [_without_ghosts(piece, remarks) for piece in pieces]
    chosen_points, number = _joined(pieces, remarks)
    of_pieces = numpy.split(number, numpy.cumsum([len(piece.points) for piece in pieces])[:-1])
    blocks = [block for piece, (starts, chosen), own in zip(pieces, found, of_pieces)
              for block in _blocks(piece, starts, chosen, own)]
    ends = numpy.cumsum([len(block.data) for block in blocks])[:-1]
    of_points = _of_all(pieces, "point_data", [slice(None)] * len(pieces), remarks)
    of_cells = _of_all(pieces, "cell_data", [chosen for _, chosen in found], remarks)
    return SimpleNamespace(points=numpy.concatenate([piece.points for piece in pieces])[chosen_points], cells=blocks,
                           cell_sets={}, field_data={}, remarks=remarks, space=dataset.texts.get("SPACE", "").strip().upper(),
                           point_data={name: values[chosen_points] for name, values in of_points.items()},
                           cell_data={name: numpy.split(values, ends) for name, values in of_cells.items()})
