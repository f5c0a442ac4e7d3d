"""Random loads on the surface of a body, and what finite elements find under them."""
from __future__ import annotations

import json
import os
import pathlib
import tempfile
from typing import TYPE_CHECKING, Callable, NamedTuple, Optional, Union

import numpy

from livermark.errors import InputError
from livermark.suite import problem

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from livermark._suite import Problem

Path = Union[str, "os.PathLike[str]"]
SMALLEST_RADIUS, LARGEST_RADIUS = 0.015, 0.030  #: of a disc [m]
MOST_TO_LOSE = 0.2  #: part of its area that a disc may have on the constrained patch; load cases allow 0.25
MOST_DRAWS = 10000
PEAK_DISPLACEMENT = 1e-3  #: of each load; everything is linear, so any other would do [m]

NO_LOADS = """acceleration = [0.0, 0.0, 1.0]
[[condition]]
rest = true
displacement = [0.0, 0.0, 0.0]
"""
DISC_LOAD = """[[condition]]
patch = {patch}
displacement = [0.0, 0.0, 0.0]
[[condition]]
disc = {{ point = {point}, radius = {radius!r} }}
traction = {traction}
"""


class Disc(NamedTuple):
    """A traction on the facets around one, as the selector `disc` of load cases takes them."""
    point: NDArray[numpy.float64]  #: (3) centroid of the facet [m]
    radius: float  #: [m]
    traction: NDArray[numpy.float64]  #: (3) of 1 Pa [Pa]


class Expected(NamedTuple):
    """L loads, and where finite elements take the nodes."""
    force: NDArray[numpy.float64]  #: (L, N, 3) [N]
    displacement: NDArray[numpy.float64]  #: (L, N, 3) [m]
    fixed: NDArray[numpy.bool_]  #: (N, 3) components that do not move


def _read(folder: str, name: str, text: str, body: Path, young_modulus: Optional[float],
          poisson_ratio: Optional[float]) -> Problem:
    file = pathlib.Path(folder) / f"{name}.toml"
    file.write_text(text, encoding="utf-8")
    return problem(body, file, young_modulus, poisson_ratio)


def mesh_of(body: Path, young_modulus: Optional[float], poisson_ratio: Optional[float]) -> Problem:
    """A body with nothing that moves it, for its mesh, patches and materials. Raises InputError."""
    with tempfile.TemporaryDirectory() as folder:
        return _read(folder, "mesh", NO_LOADS, body, young_modulus, poisson_ratio)


def _is_in_patch(mesh: Problem, patch: str) -> NDArray[numpy.bool_]:
    """(T) whether a facet is in a patch: one that lies in two has the names of both, joined by a '+'."""
    is_in = numpy.array([patch == name or patch in name.split("+") for name in mesh.patch_names])
    return is_in[mesh.boundary_patch]


def check_patch(mesh: Problem, constrained: str) -> None:
    """Raises InputError if the body has no such patch, or nothing else."""
    is_constrained = _is_in_patch(mesh, constrained)
    if not is_constrained.any():
        names = dict.fromkeys(part for name in mesh.patch_names for part in name.split("+"))
        raise InputError(f"the body has no patch '{constrained}' to constrain; choose among {', '.join(names)}")
    if is_constrained.all():
        raise InputError(f"all of the surface belongs to patch '{constrained}'; constrain a smaller one")


def _direction(random: numpy.random.Generator) -> NDArray[numpy.float64]:
    """Every direction alike: a point of the ball, by rejection."""
    while True:
        point = 2.0 * random.random(3) - 1.0
        length = numpy.linalg.norm(point)
        if 0.1 < length <= 1.0:
            return point / length


def disc_loads(mesh: Problem, constrained: str, count: int, seed: int) -> list[Disc]:
    """Discs around facets of the free surface, drawn at random. More of them begin with the same ones.

    constrained: the patch that does not move; a disc with more than a fifth of its area on it is drawn again.
    """
    corners = mesh.points[mesh.boundary_triangles]
    normal = 0.5 * numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])  # of the length of the area
    centroid, area = corners.mean(axis=1), numpy.linalg.norm(normal, axis=1)
    is_free = ~_is_in_patch(mesh, constrained)
    free = numpy.flatnonzero(is_free)
    random = numpy.random.Generator(numpy.random.PCG64(seed))
    discs: list[Disc] = []
    for _ in range(MOST_DRAWS):
        if len(discs) == count:
            break
        middle = free[int(random.random() * len(free))]
        radius = SMALLEST_RADIUS + (LARGEST_RADIUS - SMALLEST_RADIUS) * random.random()
        traction = _direction(random)
        inside = (numpy.linalg.norm(centroid - centroid[middle], axis=1) <= radius) & (normal @ normal[middle] > 0.0)
        if area[inside & ~is_free].sum() <= MOST_TO_LOSE * area[inside].sum():
            discs.append(Disc(centroid[middle], radius, traction))
    if len(discs) < count:
        raise InputError(f"discs of {1e3 * SMALLEST_RADIUS:g} to {1e3 * LARGEST_RADIUS:g} mm find no room beside patch "
                         f"'{constrained}'; constrain a smaller one")
    return discs


def solved(body: Path, discs: list[Disc], constrained: str, young_modulus: Optional[float], poisson_ratio: Optional[float],
           reference: str, tell: Callable[[str], None]) -> Expected:
    """The solution of a model of finite elements under each disc, with its load scaled to the same peak."""
    forces, displacements = [], []
    with tempfile.TemporaryDirectory() as folder:
        for number, disc in enumerate(discs):
            name = f"disc_{number}"
            tell(f"[{number + 1}/{len(discs)}] {name} / {reference}")
            text = DISC_LOAD.format(patch=json.dumps(constrained), point=disc.point.tolist(), radius=disc.radius,
                                    traction=disc.traction.tolist())
            loaded = _read(folder, name, text, body, young_modulus, poisson_ratio)
            solution = loaded.solve(reference)
            peak = numpy.linalg.norm(solution.displacement, axis=1).max()
            if solution.status != "ok" or not peak > 0.0:
                raise RuntimeError(f"{reference} ends with status {solution.status} on {name}: {solution.message}")
            forces.append(PEAK_DISPLACEMENT / peak * loaded.forces)
            displacements.append(PEAK_DISPLACEMENT / peak * solution.displacement)
    return Expected(numpy.array(forces), numpy.array(displacements), loaded.fixed)
