"""Reads the mesh of a MED file of Salome, gmsh or code_aster: nodes, elements, and groups by the names of their families.

The reader of meshio loses names of groups, and fails at fields and at families without groups."""
from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy

from livermark.errors import InputError

#: By the names that MED has for them. Tetrahedra whose corners turn them inside out are put right later, as in every format.
CELL_TYPES = {"PO1": "vertex", "SE2": "line", "SE3": "line3", "TR3": "triangle", "TR6": "triangle6", "TR7": "triangle7",
              "QU4": "quad", "QU8": "quad8", "QU9": "quad9", "TE4": "tetra", "T10": "tetra10", "HE8": "hexahedron",
              "H20": "hexahedron20", "H27": "hexahedron27", "PY5": "pyramid", "P13": "pyramid13", "PE6": "wedge", "P15": "wedge15"}
POLYGONS = ("POG", "PO2")


def _only(group: Any, what: str) -> Any:
    names = list(group)
    if len(names) != 1:
        raise InputError(f"it has {len(names)} {what}; save one alone")
    return group[names[0]]


def _text(characters: Any) -> str:
    return bytes(numpy.asarray(characters, dtype="u1")).split(b"\0")[0].decode("latin-1").strip()


def _points(mesh: Any, dimension: int) -> numpy.ndarray:
    coordinates = mesh["NOE/COO"]
    if dimension != 3 or coordinates.size != 3 * int(coordinates.attrs["NBR"]):
        raise InputError("its points have no three coordinates")
    return coordinates[()].reshape(3, -1).T  # all of one direction stand together


def _block(kind: str, group: Any) -> Any:
    """The elements of a type, with the number of the family that each is in."""
    if kind not in CELL_TYPES:
        raise InputError(f"beside tetrahedra there are cells of another type, {kind[:20]}; mesh all of the volume with "
                         "tetrahedra")
    nodes, count = group["NOD"][()], int(group["NOD"].attrs["NBR"])
    if count < 1 or nodes.size % count:
        raise InputError(f"its elements of type {kind} have not as many nodes each as they should")
    family = group["FAM"][()] if "FAM" in group else numpy.zeros(count, dtype=int)
    return SimpleNamespace(type=CELL_TYPES[kind], data=nodes.reshape(-1, count).T - 1, family=family)


def _sets(families: Any, cells: list[Any]) -> dict[str, list[numpy.ndarray]]:
    """Elements of each group. A family is all that is in the same groups."""
    numbers_of: dict[str, list[int]] = {}
    for family in families.values():
        for name in family["GRO/NOM"][()] if "GRO" in family else []:
            numbers_of.setdefault(_text(name), []).append(int(family.attrs["NUM"]))
    return {name: [numpy.flatnonzero(numpy.isin(block.family, numbers)) for block in cells]
            for name, numbers in numbers_of.items()}


def read(path: str) -> Any:
    """What has the attributes of a meshio.Mesh, and `remarks`. Raises InputError, in which the file is not named."""
    import h5py
    with h5py.File(path, "r") as file:
        if "ENS_MAA" not in file:
            raise InputError("there is no mesh of MED 2.3 or newer in it")
        whole = _only(file["ENS_MAA"], "meshes")
        mesh = whole if "NOE" in whole else _only(whole, "steps of time")
        points = _points(mesh, int(whole.attrs["ESP"]))
        elements = dict(mesh["MAI"]) if "MAI" in mesh else {}
        remarks = ["polygons are not used" for kind in elements if kind in POLYGONS]
        cells = [_block(kind, group) for kind, group in elements.items() if kind not in POLYGONS]
        families = f"FAS/{whole.name.rsplit('/', 1)[-1]}/ELEME"
        sets = _sets(file[families], cells) if families in file else {}
    data = {} if sets else {"cell_tags": [block.family for block in cells]}
    return SimpleNamespace(points=points, cells=cells, cell_sets=sets, cell_data=data, point_data={}, field_data={},
                           remarks=remarks)
