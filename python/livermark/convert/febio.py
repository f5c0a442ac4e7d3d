"""Input files of FEBio 4 (febio_spec 4.0), and the displacements that come back.

python3 -m livermark.convert.febio NAME prints the job of a problem that comes as JSON, in the words of Solid, for
`livermark export --format febio`; FEBio writes NAME.displacement.csv.
"""
from __future__ import annotations

import json
import os
import sys
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Sequence, Union
from xml.sax.saxutils import quoteattr

import numpy

from livermark.convert.pictures import WOUND
from livermark.errors import InputError
from livermark.plain_files import plain_file

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from livermark._suite import Problem

Path = Union[str, "os.PathLike[str]"]
AXES = "xyz"
HALVINGS = 5  # of the edges of a ball: 8192 triangles, which lie within 0.12 % of its radius
MOST_MATERIALS = 20  # of a region, above which its Young's modulus is a map
PENALTY = 100.0  # of contact, times FEBio's own guess: 10 needs twice the augmentations for the same gap


class Ball(NamedTuple):
    """A rigid ball that presses into the surface without friction and does not turn."""
    radius: float  #: [m]
    start: ArrayLike  #: (3) its centre where it just touches the body at rest [m]
    press: ArrayLike  #: (3) by which the centre moves while the load grows [m]


class GroundSprings(NamedTuple):
    """Springs of 1 N/m from the origin to nodes of their own, which move as sums of displacements of a body times factors: the form
    in which a job has vessels as lines and elastic foundations."""
    rest: ArrayLike  #: (G, 3) places of these nodes [m]
    terms: ArrayLike  #: (K, 4) spring, component of its node, and the node and component of the body that it is a part of
    factor: ArrayLike  #: (K)


class Solid(NamedTuple):
    """A body of your own with its loads, in the words of Problem: for to_febio(), to_vtk() and to_slicer()."""
    points: ArrayLike  #: (N, 3) [m]
    tetrahedra: ArrayLike  #: (M, 4) node numbers
    young_modulus: ArrayLike  #: one, or (M) [Pa]
    poisson_ratio: ArrayLike  #: one, or (M)
    density: ArrayLike = 1060.0  #: one, or (M) [kg/m^3]
    region: Optional[ArrayLike] = None  #: (M) index into region_names
    region_names: Sequence[str] = ("solid",)  #: (R)
    prescribed_displacement: Optional[ArrayLike] = None  #: (N, 3) [m], NaN where a component is free
    dead_forces: Optional[ArrayLike] = None  #: (N, 3) [N], they keep their direction
    boundary_triangles: Optional[ArrayLike] = None  #: (T, 3) node numbers, right-handed seen from outside
    follower_pressure: Optional[ArrayLike] = None  #: (T) [Pa], stays perpendicular to the triangles as they move
    regime: str = "large"  #: small loads are applied in one step, large ones in ten
    ball: Optional[Ball] = None  #: it presses against the boundary triangles
    edge_springs: Optional[tuple[ArrayLike, ArrayLike]] = None  #: (S, 2) nodes and (S) stiffness [N/m] of springs that are at rest
    ground_springs: Optional[GroundSprings] = None


class _Arrays(NamedTuple):
    """A Problem or Solid whose arrays have the shapes that they say."""
    points: NDArray[numpy.float64]
    tetrahedra: NDArray[numpy.int64]
    materials: NDArray[numpy.float64]  # (M, 4) region, Young's modulus, Poisson's ratio, density
    region_names: Sequence[str]
    displacement: NDArray[numpy.float64]
    forces: NDArray[numpy.float64]
    triangles: NDArray[numpy.int64]
    pressure: NDArray[numpy.float64]


def _shaped(name: str, values: Any, shape: tuple, default: float = 0.0) -> NDArray[numpy.float64]:
    if values is None:
        return numpy.full(shape, default)
    array = numpy.asarray(values, dtype=float)
    if array.ndim == 0 and len(shape) == 1:
        return numpy.full(shape, float(array))
    if array.shape != shape:
        raise InputError(f"{name}: the shape is {array.shape}; give one of shape {shape}")
    return array


def _arrays(problem: Union[Problem, Solid]) -> _Arrays:
    if getattr(problem, "press_depth", 0.0):
        raise InputError(f"load case {problem.load_case} presses to a depth, and FEBio wants the force beforehand; write a load "
                         "case that gives the 'force', or a Solid with the forces times the newtons that livermark run found")
    for noun in getattr(problem, "further_parts", ()):
        raise InputError(f"load case {problem.load_case} on {problem.body} has {noun}, which a job of FEBio cannot say; choose another "
                         "load case or body, or add it to a Solid of your own")
    points = numpy.asarray(problem.points, dtype=float)
    tetrahedra = numpy.asarray(problem.tetrahedra, dtype=numpy.int64)
    if points.ndim != 2 or points.shape[1] != 3 or tetrahedra.ndim != 2 or tetrahedra.shape[1] != 4:
        raise InputError(f"points and tetrahedra: the shapes are {points.shape} and {tetrahedra.shape}; give (N, 3) and (M, 4)")
    count, nodes = (len(tetrahedra),), (len(points), 3)
    triangles = numpy.zeros((0, 3), int) if problem.boundary_triangles is None else numpy.asarray(problem.boundary_triangles)
    for name, numbers in (("tetrahedra", tetrahedra), ("boundary_triangles", triangles)):
        if numbers.size and not (numbers.min() >= 0 and numbers.max() < len(points)):
            raise InputError(f"{name}: nodes are numbered from 0 to {len(points) - 1}")
    region = _shaped("region", problem.region, count)
    if region.size and not (region.min() >= 0 and region.max() < len(problem.region_names)):
        raise InputError(f"region: there are {len(problem.region_names)} names in region_names")
    materials = numpy.column_stack([region] + [_shaped(name, getattr(problem, name), count)
                                               for name in ("young_modulus", "poisson_ratio", "density")])
    if not (numpy.isfinite(materials).all() and (materials[:, 1] > 0.0).all() and (abs(materials[:, 2]) < 0.5).all()):
        raise InputError("young_modulus and poisson_ratio: give more than 0 Pa, and ratios between -0.5 and 0.5")
    return _Arrays(points, tetrahedra, materials, problem.region_names,
                   _shaped("prescribed_displacement", problem.prescribed_displacement, nodes, numpy.nan),
                   _shaped("dead_forces", problem.dead_forces, nodes), triangles,
                   _shaped("follower_pressure", problem.follower_pressure, (len(triangles),)))


def _numbers(values) -> str:
    return ",".join(map(repr, values.tolist()))


def _rows(tag: str, key: str, first: int, rows) -> list[str]:
    return [f'<{tag} {key}="{k}">{_numbers(row)}</{tag}>' for k, row in enumerate(rows, first)]


def _element(tag: str, inside: list[str], **attributes: Any) -> list[str]:
    opening = "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())
    return [f"<{tag}{opening}>", *inside, f"</{tag}>"]


class _Parts:
    """Sections of the file that grow together: a set of nodes in the mesh, its values, what uses them; a ball, and springs."""

    def __init__(self, num_nodes: int = 0) -> None:
        self.num_nodes = num_nodes
        self.num_facets = 0
        self.mesh: list[str] = []
        self.data: list[str] = []
        self.boundary: list[str] = []
        self.loads: list[str] = []
        self.nodes: list[str] = []
        self.elements: list[str] = []
        self.domains: list[str] = []
        self.materials: list[str] = []
        self.rigid: list[str] = []
        self.contact: list[str] = []
        self.spring_materials: list[str] = []
        self.spring_sets: list[str] = []

    def add_nodes(self, name: str, points: NDArray) -> int:
        """Number of the first, counted from 1."""
        first = self.num_nodes + 1
        self.nodes += _element("Nodes", _rows("node", "id", first, points), name=name)
        self.num_nodes += len(points)
        return first

    def add_springs(self, name: str, ends: NDArray, stiffness: float) -> None:
        """Springs of FEBio, whose energy is stiffness / 2 (length - length at rest)^2. ends: (S, 2), counted from 1."""
        self.mesh += _element("DiscreteSet", [f"<delem>{_numbers(pair)}</delem>" for pair in ends], name=name)
        self.spring_materials += _element("discrete_material", [f"<E>{stiffness!r}</E>"], id=len(self.spring_sets) + 1, name=name,
                                          type="linear spring")
        self.spring_sets.append(f'<discrete dmat="{len(self.spring_sets) + 1}" discrete_set="{name}"/>')

    def fix(self, name: str, nodes: NDArray, components: NDArray) -> None:
        """Takes components (3) of nodes, counted from 0, out of the system."""
        self.add_node_set(name, nodes)
        self.boundary += _element("bc", [f"<{axis}_dof>{int(f)}</{axis}_dof>" for axis, f in zip(AXES, components)],
                                  name=name, type="zero displacement", node_set=name)

    def add_surface(self, name: str, triangles: NDArray) -> None:
        """triangles: (T, 3), counted from 1."""
        self.mesh += _element("Surface", _rows("tri3", "id", self.num_facets + 1, triangles), name=name)
        self.num_facets += len(triangles)

    def add_node_set(self, name: str, nodes: NDArray) -> None:
        self.mesh.append(f'<NodeSet name="{name}">{_numbers(nodes + 1)}</NodeSet>')


def _add_constraints(parts: _Parts, displacement: NDArray) -> None:
    """Zeros are taken out of the system, other values grow with the load; components that are NaN stay free."""
    is_zero = displacement == 0.0
    for mask in numpy.unique(is_zero[is_zero.any(axis=1)], axis=0):
        name = "fixed_" + "".join(axis for axis, is_fixed in zip(AXES, mask) if is_fixed)
        parts.fix(name, numpy.flatnonzero((is_zero == mask).all(axis=1)), mask)
    for axis, values in zip(AXES, displacement.T):
        nodes = numpy.flatnonzero(~numpy.isnan(values) & (values != 0.0))
        if len(nodes):
            name = "moved_" + axis
            parts.add_node_set(name, nodes)
            parts.data += _element("NodeData", _rows("node", "lid", 1, values[nodes, None]),
                                   name="displacement_" + axis, node_set=name, data_type="scalar")
            parts.boundary += _element(
                "bc", [f"<dof>{axis}</dof>", f'<value lc="1" type="map">displacement_{axis}</value>'],
                name=name, type="prescribed displacement", node_set=name)


def _add_loads(parts: _Parts, arrays: _Arrays) -> None:
    nodes = numpy.flatnonzero((arrays.forces != 0.0).any(axis=1))
    if len(nodes):
        parts.add_node_set("loaded", nodes)
        parts.data += _element("NodeData", _rows("node", "lid", 1, arrays.forces[nodes]),
                               name="dead_forces", node_set="loaded", data_type="vec3")
        parts.loads += _element("nodal_load", ['<value lc="1" type="map">dead_forces</value>'],
                                name="dead_forces", type="nodal_force", node_set="loaded")
    facets = numpy.flatnonzero(arrays.pressure)
    if len(facets):
        parts.add_surface("pressed", arrays.triangles[facets] + 1)
        parts.data += _element("SurfaceData", _rows("face", "lid", 1, arrays.pressure[facets, None]),
                               name="follower_pressure", surface="pressed", data_type="scalar")
        parts.loads += _element("surface_load", ['<pressure lc="1" type="map">follower_pressure</pressure>',
                                                 "<linear>0</linear>", "<symmetric_stiffness>1</symmetric_stiffness>"],
                                name="follower_pressure", type="pressure", surface="pressed")


def _sphere(num_halvings: int) -> tuple[NDArray, NDArray]:
    """Points (N, 3) on a sphere of radius 1 and triangles (T, 3) seen from outside: an octahedron whose edges are halved."""
    points = numpy.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
    triangles = numpy.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
    for _ in range(num_halvings):
        edges = numpy.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
        edges, middle = numpy.unique(edges, axis=0, return_inverse=True)
        middles, (a, b, c) = points[edges].sum(axis=1), triangles.T
        ab, bc, ca = middle.reshape(-1, 3).T + len(points)
        points = numpy.vstack([points, middles / numpy.linalg.norm(middles, axis=1)[:, None]])
        triangles = numpy.vstack([numpy.column_stack(corners) for corners in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return points, triangles


def _checked(radius: float, start: ArrayLike, press: ArrayLike) -> Ball:
    ball = Ball(float(radius), _shaped("ball.start", start, (3,)), _shaped("ball.press", press, (3,)))
    if not (numpy.isfinite([ball.radius, *ball.start, *ball.press]).all() and ball.radius > 0.0 and ball.press.any()):
        raise InputError("ball: give a radius above 0 m, where its centre is, and by which it moves")
    return ball


def _facets_near(ball: Ball, arrays: _Arrays) -> NDArray:
    """Triangles (T, 3) whose middle is within two radii of the way of a ball."""
    middles = arrays.points[arrays.triangles].mean(axis=1) - ball.start
    along = numpy.clip(middles @ ball.press / (ball.press @ ball.press), 0.0, 1.0)
    near = arrays.triangles[numpy.linalg.norm(middles - along[:, None] * ball.press, axis=1) < 2.0 * ball.radius]
    if not len(near):
        raise InputError("ball: no boundary triangle is within two radii of its way; move it, or give the boundary_triangles")
    return near


def _add_ball(parts: _Parts, ball: Ball, arrays: _Arrays, material: int) -> None:
    """A rigid shell of triangles around the ball that moves with the load, and its contact."""
    directions, triangles = _sphere(HALVINGS)
    near = _facets_near(ball, arrays)
    first_node = parts.add_nodes("ball", ball.start + ball.radius * directions)
    parts.add_surface("below_ball", near + 1)
    parts.add_surface("on_ball", triangles + first_node)
    parts.mesh += _element("SurfacePair", ["<primary>below_ball</primary>", "<secondary>on_ball</secondary>"], name="touch")
    parts.elements += _element("Elements", _rows("elem", "id", len(arrays.tetrahedra) + 1, triangles + first_node),
                               type="tri3", name="ball")
    parts.domains += _element("ShellDomain", [f"<shell_thickness>{1e-3 * ball.radius!r}</shell_thickness>"],
                              name="ball", mat="ball")
    parts.materials += _element("material", ["<density>1</density>", f"<center_of_mass>{_numbers(ball.start)}</center_of_mass>"],
                                id=material, name="ball", type="rigid body")
    _add_way(parts, ball.press)
    parts.contact += _element("contact", [
        "<laugon>AUGLAG</laugon>", "<tolerance>0</tolerance>", f"<gaptol>{1e-3 * float(numpy.linalg.norm(ball.press))!r}</gaptol>",
        "<maxaug>20</maxaug>", "<auto_penalty>1</auto_penalty>", f"<penalty>{PENALTY}</penalty>",
        f"<search_radius>{2.0 * ball.radius!r}</search_radius>"], name="touch", type="sliding-facet-on-facet", surface_pair="touch")


def _add_way(parts: _Parts, press: NDArray) -> None:
    """The ball moves by press as the load grows, and does not turn."""
    held = [f"<R{axis}_dof>{int(by == 0.0)}</R{axis}_dof>" for axis, by in zip(AXES, press)]
    turns = [f"<R{axis}_dof>1</R{axis}_dof>" for axis in "uvw"]
    parts.rigid += _element("rigid_bc", ["<rb>ball</rb>", *held, *turns], name="ball_held", type="rigid_fixed")
    for axis, by in zip(AXES, press.tolist()):
        if by != 0.0:
            parts.rigid += _element("rigid_bc", ["<rb>ball</rb>", f"<dof>{axis}</dof>", f'<value lc="1">{by!r}</value>',
                                                 "<relative>0</relative>"], name=f"ball_moved_{axis}", type="rigid_displacement")


def _add_edge_springs(parts: _Parts, springs: Any, num_nodes: int) -> None:
    """Springs between nodes of the body, a set for each stiffness."""
    nodes, stiffness = numpy.asarray(springs[0], dtype=numpy.int64), numpy.asarray(springs[1], dtype=float)
    if nodes.ndim != 2 or nodes.shape[1] != 2 or stiffness.shape != nodes.shape[:1]:
        raise InputError(f"edge_springs: the shapes are {nodes.shape} and {stiffness.shape}; give (S, 2) and (S)")
    if nodes.size and not (nodes.min() >= 0 and nodes.max() < num_nodes and (stiffness > 0.0).all()):
        raise InputError(f"edge_springs: nodes are numbered from 0 to {num_nodes - 1}, and stiffness is above 0 N/m")
    for k, each in enumerate(numpy.unique(stiffness).tolist(), 1):
        parts.add_springs(f"edge_springs_{k}", nodes[stiffness == each] + 1, each)


def _add_ground_springs(parts: _Parts, springs: Any, num_nodes: int) -> None:
    """Springs to nodes of their own, which linear constraints move with the body."""
    rest, factor = numpy.asarray(springs[0], dtype=float), numpy.asarray(springs[2], dtype=float)
    terms = numpy.asarray(springs[1], dtype=numpy.int64)
    if rest.ndim != 2 or rest.shape[1] != 3 or terms.shape != (len(factor), 4) or factor.ndim != 1:
        raise InputError(f"ground_springs: the shapes are {rest.shape}, {terms.shape} and {factor.shape}; give (G, 3), (K, 4) and (K)")
    if terms.size and not (terms.min() >= 0 and (terms.max(axis=0) < [len(rest), 3, num_nodes, 3]).all()):
        raise InputError(f"ground_springs: there are {len(rest)} springs, {num_nodes} nodes, and components 0, 1 and 2")
    if not (numpy.isfinite(rest).all() and numpy.isfinite(factor).all() and rest.any(axis=1).all()):
        raise InputError("ground_springs: give finite numbers, and no place at the origin, where the springs begin")
    if not len(rest):
        return
    origin = parts.add_nodes("origin_of_ground_springs", numpy.zeros((1, 3)))
    first = parts.add_nodes("ends_of_ground_springs", rest)
    numbers = numpy.arange(len(rest))
    parts.fix("ground", numpy.array([origin - 1]), numpy.ones(3, bool))
    is_moved = numpy.zeros((len(rest), 3), bool)
    is_moved[terms[:, 0], terms[:, 1]] = True
    for mask in numpy.unique(is_moved, axis=0):
        if not mask.all():
            parts.fix("ends_moved_" + ("".join(axis for axis, moves in zip(AXES, mask) if moves) or "nowhere"),
                      first - 1 + numpy.flatnonzero((is_moved == mask).all(axis=1)), ~mask)
    constraints: dict[tuple[int, int], list[str]] = {}
    for (spring, component, node, of_node), value in zip(terms.tolist(), factor.tolist()):
        constraints.setdefault((spring, component), []).extend(_element(
            "child_dof", [f"<node>{node + 1}</node>", f"<dof>{AXES[of_node]}</dof>", f"<value>{value!r}</value>"]))
    for (spring, component), children in constraints.items():
        parts.boundary += _element("bc", [f"<node>{first + spring}</node>", f"<dof>{AXES[component]}</dof>", *children],
                                   type="linear constraint")
    parts.add_springs("ground_springs", numpy.column_stack([numpy.full(len(rest), origin), first + numbers]), 1.0)


def _add_wound(parts: _Parts, problem: Union[Problem, Solid]) -> None:
    """The surface of a cut, for whoever has a use for it: contact, or pictures."""
    names = list(getattr(problem, "patch_names", ()))
    if WOUND in names:
        facets = numpy.asarray(problem.boundary_triangles)[numpy.asarray(problem.boundary_patch) == names.index(WOUND)]
        parts.add_surface(WOUND, facets + 1)


def _kinds(arrays: _Arrays) -> tuple[NDArray, NDArray]:
    """Materials (K, 4) with 0 for a Young's modulus that varies over a region, and which of them each tetrahedron has (M)."""
    materials = arrays.materials.copy()
    for region in numpy.unique(materials[:, 0]):
        inside = materials[:, 0] == region
        if len(numpy.unique(materials[inside, 1])) > MOST_MATERIALS:
            materials[inside, 1] = 0.0
    kinds, kind = numpy.unique(materials, axis=0, return_inverse=True)
    return kinds, kind.ravel()


def _regions(parts: _Parts, arrays: _Arrays) -> tuple[list[str], list[str], list[str]]:
    """Material, Elements and SolidDomain of each region, one more where a region has several materials."""
    kinds, kind = _kinds(arrays)
    materials, elements, domains, number = [], [], [], 1
    for k, (region, young_modulus, poisson_ratio, density) in enumerate(kinds):
        name = arrays.region_names[int(region)]
        if (kinds[:, 0] == region).sum() > 1:
            name += f"_{k + 1}"
        modulus = f"<E>{float(young_modulus)!r}</E>"
        if young_modulus == 0.0:
            modulus = f'<E type="map">young_modulus_{k + 1}</E>'
            parts.data += _element("ElementData", _rows("elem", "lid", 1, arrays.materials[kind == k, 1:2]),
                                   name=f"young_modulus_{k + 1}", elem_set=name, data_type="scalar")
        inside = [f"<density>{float(density)!r}</density>", modulus, f"<v>{float(poisson_ratio)!r}</v>"]
        materials += _element("material", inside, id=k + 1, name=name, type="neo-Hookean")
        chosen = arrays.tetrahedra[kind == k] + 1
        elements += _element("Elements", _rows("elem", "id", number, chosen), type="tet4", name=name)
        domains.append(f"<SolidDomain name={quoteattr(name)} mat={quoteattr(name)}/>")
        number += len(chosen)
    return materials, elements, domains


def _solver() -> list[str]:
    """Newton's method with a new tangent in each iteration, to a millionth of the displacement."""
    inside = ["<symmetric_stiffness>symmetric</symmetric_stiffness>", "<dtol>1e-06</dtol>", "<etol>1e-10</etol>",
              '<qn_method type="BFGS"><max_ups>0</max_ups></qn_method>']
    return _element("solver", inside, type="solid")


def _control(num_steps: int) -> list[str]:
    stepper = ["<max_retries>10</max_retries>", "<opt_iter>10</opt_iter>", "<dtmin>0.0001</dtmin>",
               f"<dtmax>{1.0 / num_steps!r}</dtmax>"]
    return ["<analysis>STATIC</analysis>", f"<time_steps>{num_steps}</time_steps>",
            f"<step_size>{1.0 / num_steps!r}</step_size>", *_solver(),
            *_element("time_stepper", stepper, type="default")]


def _job(sections: dict[str, list[str]]) -> str:
    inside = ['<Module type="solid"/>']
    for name, section in sections.items():
        if section:
            inside += _element(name, section)
    return ('<?xml version="1.0" encoding="UTF-8"?>\n'
            + "\n".join(_element("febio_spec", inside, version="4.0")) + "\n")


def _write_job(path: Path, sections: dict[str, list[str]]) -> None:
    with open(path, "w", encoding="utf-8") as file:
        file.write(_job(sections))


def to_febio(problem: Union[Problem, Solid], path: Path) -> None:
    """Writes a job of FEBio 4: linear tetrahedra of FEBio's "neo-Hookean", which is the law of the large load cases.

    problem: of livermark.problem(), or a Solid of your own arrays. Loads grow from zero to the whole at time 1. Tractions
    and weights are forces at nodes that keep their direction; follower pressures act on the moving surface. Of a load case
    with a release this is the static start. FEBio writes the displacements beside the file, for from_febio(). Raises
    InputError.
    """
    _write_job(path, _sections(problem, os.path.splitext(os.path.basename(os.fspath(path)))[0]))


def _sections(problem: Union[Problem, Solid], stem: str) -> dict[str, list[str]]:
    """Sections of a job. stem: of the file that FEBio writes."""
    arrays = _arrays(problem)
    parts = _Parts(len(arrays.points))
    _add_constraints(parts, arrays.displacement)
    _add_loads(parts, arrays)
    _add_wound(parts, problem)
    materials, elements, domains = _regions(parts, arrays)
    ball = getattr(problem, "ball", None)
    if ball is not None:
        _add_ball(parts, _checked(*ball), arrays, len(domains) + 1)
    if getattr(problem, "edge_springs", None) is not None:
        _add_edge_springs(parts, problem.edge_springs, len(arrays.points))
    if getattr(problem, "ground_springs", None) is not None:
        _add_ground_springs(parts, problem.ground_springs, len(arrays.points))
    curve = ["<interpolate>LINEAR</interpolate>", "<extend>CONSTANT</extend>",
             "<points><pt>0,0</pt><pt>1,1</pt></points>"]
    output = [*_element("plotfile", ['<var type="displacement"/>', '<var type="stress"/>'], type="febio"),
              *_element("logfile", [f'<node_data data="ux;uy;uz" delim="," node_set="nodes" '
                                    f"file={quoteattr(stem + '.displacement.csv')}/>"] +
                                ([] if ball is None else [f'<rigid_body_data data="Fx;Fy;Fz" delim="," '
                                                          f"file={quoteattr(stem + '.force.csv')}></rigid_body_data>"]))]
    nodes = _element("Nodes", _rows("node", "id", 1, arrays.points), name="nodes")
    return {"Control": _control(1 if problem.regime == "small" else 10), "Material": materials + parts.materials,
            "Mesh": nodes + parts.nodes + elements + parts.elements + parts.mesh, "MeshDomains": domains + parts.domains,
            "MeshData": parts.data, "Boundary": parts.boundary, "Loads": parts.loads, "Contact": parts.contact,
            "Rigid": parts.rigid, "Discrete": parts.spring_materials + parts.spring_sets,
            "LoadData": _element("load_controller", curve, id=1, type="loadcurve"), "Output": output}


def from_febio(path: Path) -> NDArray[numpy.float64]:
    """Displacements of the nodes (N, 3) [m] at the whole load, of the .displacement.csv that a job of to_febio() writes.

    Raises InputError if FEBio stopped before, or if it is no such file.
    """
    time, rows = 0.0, []
    with open(plain_file(path, "give the .displacement.csv of FEBio"), encoding="utf-8") as file:
        try:
            for line in file:
                if line.startswith("*Time"):
                    time, rows = float(line.split("=")[1]), []
                elif not line.startswith("*") and line.strip():
                    number, x, y, z = map(float, line.split(","))
                    rows.append([number, x, y, z])
        except (ValueError, IndexError):
            raise InputError(f"{os.fspath(path)}: this is no displacement that FEBio wrote of a job of to_febio(); give its "
                             ".displacement.csv") from None
    if abs(time - 1.0) > 1e-9 or not rows:
        raise InputError(f"{os.fspath(path)}: FEBio stopped at {time:g} of the load; see its log, and give it more steps")
    table = numpy.array(rows)
    table = table[numpy.argsort(table[:, 0], kind="stable")]
    if not numpy.isfinite(table).all():
        raise InputError(f"{os.fspath(path)}: a displacement at the whole load is not finite; see the log of FEBio")
    if not numpy.array_equal(table[:, 0], numpy.arange(1, len(table) + 1)):
        raise InputError(f"{os.fspath(path)}: its nodes are not numbered 1, 2, 3 ... each once; give the file as FEBio wrote it")
    return table[:, 1:]


def main(arguments: list) -> int:
    try:
        print(_job(_sections(SimpleNamespace(**json.load(sys.stdin)), *arguments)), end="")
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
