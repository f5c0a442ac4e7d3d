"""Which group each element of a mesh of meshio is in: by numbers of elements, or by sets of them. Needs numpy alone."""
from __future__ import annotations

from typing import Any, NamedTuple

import numpy

from livermark.errors import InputError

TETRAHEDRA = ("tetra", "tetra10")
TRIANGLES = ("triangle", "triangle6")
#: What programs call the number of an element's group, in lower case; any other whole numbers come after these.
KNOWN = ("gmsh:physical", "region", "regions", "materialids", "material", "materials", "medit:ref", "tetgen:ref",
         "nastran:ref", "avsucd:material", "cell_tags", "flag", "labels", "label")
#: Numbers that every file of a format has, and that say nothing of materials.
OF_THE_FORMAT = ("gmsh:geometrical", "gmsh:dim_tags", "vtkoriginalcellids", "vtkghosttype")
MOST_GROUPS = 254  #: more are numbers of the elements themselves, or a quantity
FLAT = {"quad", "quad8", "quad9", "polygon", "triangle7"}
THIN = {"line", "line3", "vertex", "poly_line", "line4"}


class Groups(NamedTuple):
    number: numpy.ndarray  #: (M) of each element, 0 where it is in no group
    names: dict[int, str]  #: of the groups that the file names
    remarks: list[str]  #: a sentence for all that was chosen or is not used


def refuse_other_cells(mesh: Any) -> list[str]:
    """Raises InputError if a part of the volume is in cells that are no tetrahedra. A sentence for faces not used."""
    counts: dict[str, int] = {}
    for block in mesh.cells:
        counts[block.type] = counts.get(block.type, 0) + len(block.data)
    volumes = {kind: count for kind, count in counts.items()
               if count and kind not in TETRAHEDRA + TRIANGLES and kind not in FLAT and kind not in THIN}
    if volumes:
        found = ", ".join(f"{count} of type {kind}" for kind, count in sorted(volumes.items()))
        raise InputError(f"beside tetrahedra there are cells of other types: {found}; mesh all of the volume with "
                         "tetrahedra")
    return [f"{count} cells of type {kind} are not used" for kind, count in sorted(counts.items()) if kind in FLAT]


def _column(values: list) -> Any:
    """One whole number for each element; None if it is something else."""
    try:
        joined = numpy.concatenate([numpy.asarray(block) for block in values]) if values else numpy.zeros(0)
    except ValueError:
        return None
    if joined.ndim == 2 and joined.shape[1] == 1:
        joined = joined[:, 0]
    if joined.ndim != 1 or joined.dtype.kind not in "biuf" or not numpy.isfinite(joined).all():
        return None
    whole = numpy.round(joined.astype(float))
    return whole.astype(numpy.int64) if numpy.array_equal(whole, joined) else None


def _of_arrays(mesh: Any, blocks: list[int]) -> tuple[list[str], dict[str, Any]]:
    """Names of the arrays that can be groups, the best first, and the numbers of all that are whole."""
    columns = {name: _column([data[b] for b in blocks]) for name, data in mesh.cell_data.items()}
    whole = {name: column for name, column in columns.items() if column is not None}
    known = [name for key in KNOWN for name in whole if name.lower() == key]
    others = [name for name, column in whole.items()
              if name not in known and name.lower() not in OF_THE_FORMAT
              and 1 < len(numpy.unique(column)) <= min(MOST_GROUPS, len(column) - 1)]
    return known + others, whole


def _of_sets(sets: dict, blocks: list[int], sizes: list[int], what: str, known: dict[str, int]) -> Groups:
    """Larger sets first, so that of two that overlap the smaller one counts. known: numbers that sets have already."""
    starts = numpy.concatenate([[0], numpy.cumsum(sizes)]).astype(int)
    members = {}
    for name, where in sets.items():
        parts = [numpy.asarray(where[b], dtype=int) + starts[k] for k, b in enumerate(blocks)
                 if where[b] is not None and len(where[b])]
        if parts:
            members[name] = numpy.unique(numpy.concatenate(parts))
    number = numpy.zeros(int(starts[-1]), dtype=numpy.int64)
    names, remarks = {}, []
    numbers = {name: known.get(name, k) for k, name in enumerate(sorted(members), start=1 + max(known.values(), default=0))}
    for name in sorted(members, key=lambda name: (-len(members[name]), name)):
        for other in numpy.unique(number[members[name]]):
            if other:
                shared = int((number[members[name]] == other).sum())
                remarks.append(f"the sets '{names[int(other)]}' and '{name}' share {shared} {what}, which count as "
                               f"'{name}', the smaller one")
        number[members[name]] = numbers[name]
        names[numbers[name]] = name
    return Groups(number, names, remarks)


def groups_of(mesh: Any, kinds: tuple[str, ...], dimension: int) -> Groups:
    """Groups of all elements of these kinds, in the order of the file.

    Numbers that a known name says to be those of groups come first, then sets of elements, then any other whole numbers.
    What is left is named in the remarks.
    """
    blocks = [b for b, block in enumerate(mesh.cells) if block.type in kinds]
    sizes = [len(mesh.cells[b].data) for b in blocks]
    what = "tetrahedra" if dimension == 3 else "triangles"
    sets = {name: where for name, where in mesh.cell_sets.items() if not name.startswith("gmsh:")
            and any(where[b] is not None and len(where[b]) for b in blocks)}
    ranked, whole = _of_arrays(mesh, blocks)
    by_name = bool(ranked) and ranked[0].lower() in KNOWN
    names = {int(number): name for name, (number, of_dimension) in mesh.field_data.items() if of_dimension == dimension}
    # A file of gmsh has its groups as numbers, of which an element has one, and as sets, which may overlap.
    of_gmsh = {name: number for number, name in names.items()} if by_name and ranked[0] == "gmsh:physical" else {}
    are_groups = bool(sets) and all(name in of_gmsh for name in sets)
    if are_groups:
        groups, used = _of_sets(sets, blocks, sizes, what, of_gmsh), ranked[0]
        without = groups.number == 0  # their groups have no name
        groups.number[without] = whole[used][without]
    elif sets and not by_name:
        groups, used = _of_sets(sets, blocks, sizes, what, {}), ""
    elif ranked:
        used = ranked[0]
        groups = Groups(whole[used], names, [] if by_name else [f"groups of {what} are the numbers '{used}'"])
        named = {name for name in names.values()}
        if left := sorted(name for name in sets if name not in named):
            groups.remarks.append(f"sets that are not used, because there are numbers '{used}': {', '.join(left)}")
    else:
        groups, used = Groups(numpy.zeros(sum(sizes), dtype=numpy.int64), names, []), ""
    unused = [name for name in mesh.cell_data if name != used and not name.lower().startswith("gmsh:")
              and name.lower() not in OF_THE_FORMAT]
    if unused and dimension == 3:
        groups.remarks.append(f"values of cells that are not used: {', '.join(unused)}")
    return groups
