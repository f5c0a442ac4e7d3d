"""To and from the formats of other programs."""
from __future__ import annotations

import importlib.util
import math
import numbers
import os
import warnings
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy

from livermark.convert.mesh_files import Tetrahedra, read_apart, tetrahedra_of
from livermark.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from livermark._livermark import Springs


class _Arrays(NamedTuple):
    points: NDArray[numpy.float64]  #: (N, 3) [m]
    tetrahedra: NDArray[numpy.int64]  #: (M, 4) node numbers
    region: NDArray[numpy.int64]  #: (M) group number of the file, 0 where it has none


class Mesh(_Arrays):
    """Tetrahedra of positive volume, for springs(): points (N, 3) [m], tetrahedra (M, 4) node numbers, region (M) group
    number of the file, 0 where it has none; region_names, the names that the file has for these numbers."""

    region_names: dict[int, str]

    def __new__(cls, points: Any, tetrahedra: Any, region: Any, region_names: Optional[dict[int, str]] = None) -> Mesh:
        mesh = super().__new__(cls, points, tetrahedra, region)
        mesh.region_names = dict(region_names or {})
        return mesh


def _tetrahedra(mesh: Any) -> Tetrahedra:
    """Of a file or of a meshio.Mesh."""
    if isinstance(mesh, (str, bytes, os.PathLike)):
        if importlib.util.find_spec("meshio") is None:
            raise ImportError("this needs meshio; install python3-meshio")
        return read_apart(os.fsdecode(mesh))
    if not all(hasattr(mesh, name) for name in ("points", "cells", "cell_data", "cell_sets", "field_data")):
        raise InputError("mesh: this is no meshio.Mesh, and no path of a file")
    try:
        return tetrahedra_of(mesh)
    except InputError as error:
        raise InputError(f"mesh: {error}") from error.__cause__


def _doubts(points: NDArray[numpy.float64]) -> list[str]:
    """What speaks against lengths in metres; nothing where the package is not compiled, which then makes no springs either."""
    try:
        from livermark._livermark import _doubts_about_unit  # type: ignore[attr-defined]
    except ModuleNotFoundError:
        return []
    return [f"{doubt.partition(';')[0]}; give metres_per_unit, 0.001 for a mesh in mm" for doubt in _doubts_about_unit(points)]


def from_meshio(mesh: Any, metres_per_unit: float = 1.0) -> Mesh:
    """The tetrahedra of a meshio.Mesh, or of a file of VTK, Abaqus, Nastran, MED, TetGen or what else meshio reads.

    Give the file rather than what meshio.read() returns, which may lack pieces of a VTU, names of MED, axes and coordinate
    systems.

    Quadratic tetrahedra lose the middles of their edges, inverted ones are turned, and nodes that no tetrahedron uses are
    left out. Groups are physical groups, sets, or whole numbers of cells; what is not used is said in a warning, and so is
    a size that is no organ's. metres_per_unit: 0.001 for a mesh in mm. A file is read in a process of its own. Raises
    InputError for what is no mesh, if there are no tetrahedra, or cells of other types beside them.
    """
    if not (isinstance(metres_per_unit, numbers.Real) and 0.0 < metres_per_unit < math.inf):
        raise InputError(f"metres_per_unit: {metres_per_unit!r}; it has to be a positive number, 0.001 for a mesh in mm")
    found = _tetrahedra(mesh)
    points = float(metres_per_unit) * found.points
    for remark in _doubts(points) + found.remarks:
        warnings.warn(f"mesh: {remark}", stacklevel=2)
    return Mesh(points, found.corners, found.region, found.names)


SCENE = '''"""Springs of Livermark in SOFA: runSofa -l SofaPython3 {name}

{num_nodes} nodes, {num_springs} springs, SI units. For SOFA 24.12 or newer with SofaPython3.
"""

TIME_STEP = {time_step!r}  # [s]
POINTS = {points!r}  # [m]
NODE_MASS = {node_mass!r}  # [kg]
# Nodes, stiffness [N/m], damping [N s/m] and rest length [m] of each spring
SPRINGS = {springs!r}
FIXED = {fixed!r}  # node numbers
FORCES = {forces!r}  # of all nodes [N], or none


def createScene(root):
    root.dt = TIME_STEP
    root.gravity = [0.0, 0.0, 0.0]
    root.addObject("RequiredPlugin", pluginName=[
        "Sofa.Component.Constraint.Projective", "Sofa.Component.LinearSolver.Iterative", "Sofa.Component.Mass",
        "Sofa.Component.MechanicalLoad", "Sofa.Component.ODESolver.Backward",
        "Sofa.Component.SolidMechanics.Spring", "Sofa.Component.StateContainer",
        "Sofa.Component.Topology.Container.Dynamic"])
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("livermark")
    body.addObject("EulerImplicitSolver", rayleighMass={alpha!r}, rayleighStiffness=0.0)
    body.addObject("CGLinearSolver", iterations=200, tolerance=1e-10, threshold=1e-30)
    body.addObject("EdgeSetTopologyContainer", name="edges", position=POINTS,
                   edges=[[i, j] for i, j, _, _, _ in SPRINGS])
    body.addObject("MechanicalObject", name="nodes", template="Vec3d", position=POINTS, showObject=True)
    body.addObject("DiagonalMass", name="mass", topology="@edges", vertexMass=NODE_MASS)
    body.addObject("SpringForceField", name="springs",
                   spring=" ".join(" ".join(map(repr, spring)) for spring in SPRINGS))
    if FIXED:
        body.addObject("FixedProjectiveConstraint", indices=FIXED)
    if FORCES:
        body.addObject("ConstantForceField", indices=list(range(len(POINTS))), forces=FORCES)
'''


def to_sofa(springs: Springs, path: Union[str, os.PathLike[str]], time_step: float, fixed: Optional[ArrayLike] = None,
            forces: Optional[ArrayLike] = None, damping: Any = None) -> None:
    """Writes a scene of SofaPython3 whose springs have the nodes, stiffnesses and lengths of these.

    time_step [s]. fixed: node numbers, or a mask of shape (N). forces: (N, 3) [N]. damping: RayleighDamping; the part of
    the stiffness becomes dashpots beta k. Springs of coupled_springs() and volume terms have no counterpart in SOFA: the
    first are refused, of the second only the springs are written. Raises InputError.
    """
    if len(springs.edges) == 0:
        raise InputError("springs: coupled springs are not edges of their own, which SOFA needs; take springs()")
    num_nodes = len(springs.points)
    chosen = numpy.zeros(0, int) if fixed is None else numpy.asarray(fixed)
    if chosen.dtype == bool:
        if chosen.shape != (num_nodes,):
            raise InputError(f"fixed: the shape is {chosen.shape}; SOFA fixes whole nodes, give one of shape ({num_nodes},)")
        chosen = numpy.flatnonzero(chosen)
    if len(chosen) and not (chosen.min() >= 0 and chosen.max() < num_nodes):
        raise InputError(f"fixed: nodes are numbered from 0 to {num_nodes - 1}")
    loads = [] if forces is None else numpy.asarray(forces, dtype=float)
    if len(loads) and loads.shape != (num_nodes, 3):
        raise InputError(f"forces: the shape is {loads.shape}; give one of shape ({num_nodes}, 3)")
    beta = damping.beta if damping else 0.0
    rows = [[i, j, k, beta * k, length] for (i, j), k, length in
            zip(springs.edges.tolist(), springs.stiffness.tolist(), springs.rest_length.tolist())]
    with open(path, "w", encoding="utf-8") as file:
        file.write(SCENE.format(name=os.path.basename(os.fspath(path)), num_nodes=num_nodes, num_springs=len(rows),
                                time_step=float(time_step), points=springs.points.tolist(),
                                node_mass=springs.node_mass.tolist(), springs=rows, fixed=chosen.tolist(),
                                forces=loads if isinstance(loads, list) else loads.tolist(),
                                alpha=damping.alpha if damping else 0.0))
