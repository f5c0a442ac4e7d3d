"""Scanned bodies under gravity: where they are held, tools on them, and the same bodies with their nodes elsewhere."""
from __future__ import annotations

import os
import pathlib
import tempfile
import tomllib
from dataclasses import dataclass
from typing import Any, Iterable, Optional

import numpy
from numpy.typing import NDArray

from livermark import suite
from livermark.errors import InputError
from livermark.studies import to_toml
from livermark.vessels import Vessels, swc_text
from livermark.volumes import tetrahedron_volumes

Array = NDArray[numpy.float64]
GRAVITY = 9.81  #: [m/s^2]
PATH = [0.5, 1.0]  #: parts of gravity at which a solution is stored; models choose their own steps between
PRESSING_FORCE = 0.01  #: [N] of a tool that a load case moves to a depth


class NoEquilibrium(Exception):
    """A sentence on why a model has no equilibrium, or no unloaded shape."""


@dataclass(frozen=True)
class Tool:
    """Facets that a load case loads, in parts that are not connected, with the resultant of each."""
    name: str
    facets: list[NDArray[numpy.int64]]
    forces: list[Array]  #: (3) [N], in the axes of the mesh

    def displacement(self, triangles: NDArray[numpy.int32], moved: Array, points: Array) -> float:
        """Work of the forces over their size [m]: the displacement along the forces, in the mean over the facets by area."""
        work = 0.0
        for facets, force in zip(self.facets, self.forces):
            corners = triangles[facets]
            a, b, c = (points[corners[:, k]] for k in range(3))
            area = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
            work += float(force @ (area[:, None] * moved[corners].mean(axis=1)).sum(axis=0) / area.sum())
        return work / sum(float(numpy.linalg.norm(force)) for force in self.forces)


def read_toml(path: pathlib.Path) -> dict[str, Any]:
    try:
        return tomllib.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}; give a readable .toml") from error


def shipped(name: os.PathLike[str] | str, folder: str) -> pathlib.Path:
    """The file of a path, or of a name that ships."""
    path = pathlib.Path(name)
    if path.suffix:
        return path
    here = pathlib.Path(__file__).resolve().parents
    root = os.environ.get("LIVERMARK_ROOT") or (here[1] / "data" if (here[1] / "data").is_dir() else here[3])
    return pathlib.Path(root) / folder / f"{name}.toml"


def read_supports(load_case: os.PathLike[str] | str) -> dict[str, Any]:
    """The held places and the foundations of a load case, without its loads."""
    path = shipped(load_case, "load_cases")
    table = read_toml(path)
    held = [condition for condition in table.get("condition", []) if "displacement" in condition]
    foundations = table.get("foundation", [])
    foundations = foundations if isinstance(foundations, list) else [foundations]
    for condition in [*held, *foundations]:
        if not {"patch", "patches"} & set(condition):
            raise InputError(f"{path}: a support of a body under gravity is on whole patches; write it with 'patch' or 'patches'")
        if any(value not in (0, "free") for value in condition.get("displacement", [])):
            raise InputError(f"{path}: a support of a body under gravity does not move; write zero or \"free\"")
    if not held:
        raise InputError(f"{path}: nothing is held; give a load case with a displacement of zero")
    return {"condition": held, **({"foundation": foundations} if foundations else {})}


class Scan:
    """A scanned body, the places where it is held, and files of bodies of other shapes that are made of it."""

    def __init__(self, body: os.PathLike[str] | str, support: os.PathLike[str] | str, direction: Iterable[float],
                 folder: pathlib.Path, acceleration: float = GRAVITY) -> None:
        self.supports = read_supports(support)
        self.gravity = acceleration * numpy.asarray(list(direction), dtype=float)
        self.body = body
        folder.mkdir(parents=True, exist_ok=True)
        case = folder / "gravity.toml"
        turned = []
        for axis in numpy.eye(3):
            case.write_text(self.load_case(axis))
            self.problem = suite.problem(body, case)
            mass = abs(tetrahedron_volumes(self.problem.points, self.problem.tetrahedra)) @ self.problem.density
            turned.append(self.problem.dead_forces.sum(axis=0) / mass)
        self.axes = numpy.array(turned)  # rows: left, posterior and superior of the patient in the axes of the mesh
        if abs(self.axes @ self.axes.T - numpy.eye(3)).max() < 1e-6:
            self.axes = numpy.round(self.axes, 12) + 0.0
        case.write_text(self.load_case(self.gravity))
        self.points = numpy.array(self.problem.points)
        self.tetrahedra, self.triangles = self.problem.tetrahedra, self.problem.boundary_triangles
        self.volumes = tetrahedron_volumes(self.points, self.tetrahedra)
        path = shipped(body, "meshes")
        table = read_toml(path) if path.suffix == ".toml" else {}
        regions = {name: {} for name in self.problem.region_names}
        for index, name in enumerate(self.problem.region_names):
            inside = numpy.flatnonzero(self.problem.region == index)
            if len(inside):
                regions[name] = {key: float(getattr(self.problem, key)[inside[0]])
                                 for key in ("density", "young_modulus", "poisson_ratio")}
        if "stiffness_map" in table:  # whose file lies beside the body
            table["stiffness_map"]["file"] = str((path.parent / table["stiffness_map"]["file"]).resolve())
        tree = self.problem.vessels
        self.move_vessels = Vessels(*tree).mover(self.points, self.tetrahedra) if tree else None
        self.table = {"regions": regions, **{key: value for key, value in table.items() if key not in (
            "mesh", "unit", "find_patches", "generator", "axes", "image")}}

    def load_case(self, acceleration: Array, tool: Optional[Tool] = None) -> str:
        """Text of gravity, in the axes of the patient, on the supports; pieces of patches that a tool loads stay supported."""
        pieces = self._pieces(tool)

        def grown(condition: dict[str, Any]) -> dict[str, Any]:
            names = condition.get("patches", [condition.get("patch")])
            beside = [piece for piece, (patch, _, _) in pieces.items() if self.problem.patch_names[patch] in names]
            if beside and "displacement" in condition:
                raise NoEquilibrium(f"{tool.name if tool else ''} acts where the body is held")
            whole = [name for name in names if not beside or name not in self._covered(pieces)]
            rest = {key: value for key, value in condition.items() if key not in ("patch", "patches")}
            return {"patches": [*whole, *beside], **rest}
        conditions = [grown(condition) for condition in self.supports["condition"]]
        for part in range(len(tool.forces) if tool else 0):
            conditions.append({"patches": [piece for piece, (_, of, _) in pieces.items() if of == part],
                               "force": (self.axes @ tool.forces[part]).tolist()})
        top: dict[str, Any] = {"title": f"{tool.name}, under gravity" if tool else "Gravity", "regime": "large", "path": PATH,
                               "acceleration": [float(value) for value in acceleration]}
        if "foundation" in self.supports:
            top["foundation"] = [grown(foundation) for foundation in self.supports["foundation"]]
        return to_toml({**top, "condition": conditions}, "condition")

    def _pieces(self, tool: Optional[Tool]) -> dict[str, tuple[int, int, NDArray[numpy.int64]]]:
        """By name: the patch that a piece is of, the part of the tool, and facets."""
        found = {}
        for part, facets in enumerate(tool.facets if tool else []):
            for patch in numpy.unique(self.problem.boundary_patch[facets]).tolist():
                found[f"tool_{part + 1}_{patch + 1}"] = (patch, part, facets[self.problem.boundary_patch[facets] == patch])
        return found

    def _covered(self, pieces: dict[str, tuple[int, int, NDArray[numpy.int64]]]) -> set[str]:
        """Names of patches of which the pieces leave nothing."""
        sizes = numpy.bincount(self.problem.boundary_patch[self.problem.boundary_patch >= 0], minlength=len(self.problem.patch_names))
        for patch, _, facets in pieces.values():
            sizes[patch] -= len(facets)
        return {name for name, size in zip(self.problem.patch_names, sizes) if size == 0}

    def write_body(self, path: pathlib.Path, points: Array, title: str, tool: Optional[Tool] = None) -> None:
        """A .toml and, beside it, a .msh (MSH 2.2) of the body with its nodes elsewhere [m]."""
        patches, patch = [*self.problem.patch_names], numpy.array(self.problem.boundary_patch)
        for name, (_, _, facets) in self._pieces(tool).items():
            patch[facets] = len(patches)
            patches.append(name)
        named = numpy.flatnonzero(patch >= 0)
        lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(patches) + len(self.problem.region_names))]
        for dimension, names in ((2, patches), (3, self.problem.region_names)):
            lines += [f'{dimension} {number} "{name}"' for number, name in enumerate(names, start=1)]
        lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
        lines += [f"{number} {x!r} {y!r} {z!r}" for number, (x, y, z) in enumerate(points.tolist(), start=1)]
        lines += ["$EndNodes", "$Elements", str(len(named) + len(self.tetrahedra))]
        elements = [(2, patch[facet] + 1, self.triangles[facet]) for facet in named]
        elements += [(4, region + 1, corners) for region, corners in zip(self.problem.region, self.tetrahedra)]
        lines += [f"{number} {kind} 2 {group} {group} " + " ".join(str(corner + 1) for corner in corners.tolist())
                  for number, (kind, group, corners) in enumerate(elements, start=1)]
        path.with_suffix(".msh").write_text("\n".join([*lines, "$EndElements"]) + "\n")
        top = {"title": title, "mesh": path.with_suffix(".msh").name, "axes": self.axes.tolist()}
        described = {key: value for key, value in self.table.items() if key != "patches" or not tool}
        if self.move_vessels:
            lines = path.with_suffix(".swc")
            lines.write_text(swc_text(self.move_vessels(points - self.points)))
            described["vessels"] = {**described["vessels"], "file": lines.name, "unit": "m"}
        path.write_text(to_toml({**described, **top}, ""))

    def moved(self, model: str, points: Array, gravity: float, tool: Optional[Tool] = None) -> Array:
        """(N, 3) positions [m] of the equilibrium of a body at rest at some points, under a part of gravity and a tool."""
        with tempfile.TemporaryDirectory() as folder:
            body, case = pathlib.Path(folder, "body.toml"), pathlib.Path(folder, "gravity.toml")
            case.write_text(self.load_case(gravity * self.gravity, tool))
            self.write_body(body, points, "Iterate", tool)
            try:
                problem = suite.problem(body, case)
            except InputError as error:
                raise NoEquilibrium(f"the body at rest at these nodes is refused: {error}") from error
            if not numpy.array_equal(problem.points, points):
                raise InputError(f"{self.body}: its nodes have another order when they are read again; give a .msh")
            solution = problem.solve(model)
        if solution.status != "ok":
            raise NoEquilibrium(solution.message or f"the status of the model is {solution.status}")
        return points + solution.displacement

    def _without_rims(self, facets: NDArray[numpy.int64]) -> NDArray[numpy.int64]:
        """Facets of patches of which a node that is in no other patch is among the corners. Others share a rim with what is loaded."""
        patch = self.problem.boundary_patch
        lowest, highest = numpy.full(len(self.points), len(patch)), numpy.full(len(self.points), -1)
        numpy.minimum.at(lowest, self.triangles.ravel(), numpy.repeat(patch, 3))
        numpy.maximum.at(highest, self.triangles.ravel(), numpy.repeat(patch, 3))
        inner = (lowest == highest)[self.triangles[facets]].any(axis=1)
        kept = facets[numpy.isin(patch[facets], patch[facets[inner]])]
        return kept if len(kept) else facets

    def tool_of(self, load_case: str) -> Tool:
        """What a load case does, as forces on facets of the scan; NoEquilibrium says why it cannot be that."""
        problem = suite.problem(self.body, load_case)
        name, forces = pathlib.Path(load_case).stem, numpy.array(problem.dead_forces)
        surface = numpy.zeros(len(self.points), dtype=bool)
        surface[numpy.unique(self.triangles)] = True
        if problem.ball is not None or problem.further_parts:
            raise NoEquilibrium(f"{name} has a ball or plate, which starts at the body at rest and not under gravity")
        if abs(problem.follower_pressure).max(initial=0.0) > 0.0:
            raise NoEquilibrium(f"{name} has a pressure that follows the surface, and no tool")
        if not forces.any() or forces[~surface].any():
            raise NoEquilibrium(f"{name} has no tool with a traction, pressure, force or press")
        facets = numpy.flatnonzero(forces.any(axis=1)[self.triangles].all(axis=1))
        facets = self._without_rims(facets)
        parts = connected(self.triangles[facets])
        pieces = [facets[parts == part] for part in range(parts.max() + 1)]
        resultants = [forces[numpy.unique(self.triangles[piece])].sum(axis=0) for piece in pieces]
        if problem.press_depth > 0.0:
            scale = PRESSING_FORCE / max(float(numpy.linalg.norm(force)) for force in resultants)
            resultants = [scale * force for force in resultants]
        return Tool(name, pieces, resultants)


def connected(triangles: NDArray[numpy.int32]) -> NDArray[numpy.int64]:
    """(T) number of the part of each triangle; triangles that share a node are of one part."""
    label = numpy.arange(len(triangles))
    lowest = numpy.zeros(int(triangles.max()) + 1, dtype=numpy.int64)
    while True:
        lowest[:] = len(triangles)
        numpy.minimum.at(lowest, triangles.ravel(), numpy.repeat(label, 3))
        new = lowest[triangles].min(axis=1)
        if numpy.array_equal(new, label):
            return numpy.unique(label, return_inverse=True)[1]
        label = new
