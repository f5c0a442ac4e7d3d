"""Jobs of FEBio 4 and scenes of SOFA of load cases in which a tool moves, from the .scene.h5 of `livermark export`."""
from __future__ import annotations

import os
from typing import TYPE_CHECKING, NamedTuple, Union

import numpy

from livermark.convert.febio import AXES, Solid, _arrays, _element, _numbers, _Parts, _regions, _rows, _solver, _write_job
from livermark.errors import InputError
from livermark.hdf5_files import FAULTS, open_hdf5

if TYPE_CHECKING:
    from numpy.typing import NDArray

Path = Union[str, "os.PathLike[str]"]
STEPS_PER_FRAME = 4  # of the implicit steps of both programs


class ToolScene(NamedTuple):
    """A moving load case as other programs see it: K records at equal distances in time, T nodes of the tool."""
    title: str
    points: NDArray[numpy.float64]  #: (N, 3) [m]
    tetrahedra: NDArray[numpy.int64]  #: (M, 4) node numbers
    region: NDArray[numpy.int64]  #: (M) row of the materials
    young_modulus: NDArray[numpy.float64]  #: (R) [Pa]
    poisson_ratio: NDArray[numpy.float64]  #: (R)
    density: NDArray[numpy.float64]  #: (R) [kg/m^3]
    held: NDArray[numpy.int64]  #: nodes that never move
    tool_nodes: NDArray[numpy.int64]  #: (T)
    time: NDArray[numpy.float64]  #: (K) [s]
    displacement: NDArray[numpy.float64]  #: (K, T, 3) of the tool's nodes [m]
    last_record_held: int  #: after this record the tool has let go
    mass_damping: float  #: alpha [1/s]: forces -alpha m v

    @property
    def step(self) -> float:
        """Time step of a job or scene [s]."""
        return float(self.time[1] - self.time[0]) / STEPS_PER_FRAME

    def solid(self) -> Solid:
        """The body, with nothing that moves it."""
        names = [f"region_{r + 1}" for r in range(len(self.density))]
        return Solid(self.points, self.tetrahedra, self.young_modulus[self.region], self.poisson_ratio[self.region],
                     self.density[self.region], self.region, names)


def read_tool_scene(path: Path) -> ToolScene:
    """What `livermark export` writes of a load case with a moving tool. Raises InputError."""
    try:
        with open_hdf5(path) as file:
            material = [file["materials"][name][:] for name in ("young_modulus", "poisson_ratio", "density")]
            title = file.attrs["title"]  # bytes, where the text has a fixed length
            title = title.decode() if isinstance(title, bytes) else title
            return ToolScene(title, file["points"][:], file["tetrahedra"][:].astype(int),
                             file["region"][:].astype(int), *material, file["held"][:].astype(int),
                             file["tool/nodes"][:].astype(int), file["tool/time"][:], file["tool/displacement"][:],
                             int(file["tool"].attrs["last_record_held"]), float(file["tool"].attrs["mass_damping"]))
    except InputError:
        raise
    except (*FAULTS, MemoryError) as error:
        raise InputError(f"{os.fspath(path)}: this is no scene ({error}); write one with 'livermark export' of a load case "
                         "with a moving tool") from None


def _smooth_way(scene: ToolScene) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
    """Times (P) of all steps and the tool's displacements (P, T, 3) then, while it has hold of the body: cubic Hermite
    polynomials between records, with slopes of central differences. FEBio's own CUBIC SPLINE leaves its points near its end.
    """
    held = slice(0, scene.last_record_held + 1)
    time, way = scene.time[held], scene.displacement[held]
    slope, parts = numpy.gradient(way, axis=0), numpy.arange(STEPS_PER_FRAME) / STEPS_PER_FRAME
    part = parts[:, None, None, None]
    between = ((1.0 + 2.0 * part) * (1.0 - part) ** 2 * way[:-1] + part ** 2 * (3.0 - 2.0 * part) * way[1:]
               + part * (1.0 - part) * ((1.0 - part) * slope[:-1] - part * slope[1:]))  # (4, frames, T, 3)
    smooth = numpy.concatenate([numpy.swapaxes(between, 0, 1).reshape(-1, *way.shape[1:]), way[-1:]])
    return numpy.append(time[:-1, None] + parts * (STEPS_PER_FRAME * scene.step), time[-1]), smooth


def _tool(scene: ToolScene) -> tuple[list[str], list[str], list[str]]:
    """A set, three conditions and three curves for each node of the tool: each goes its own way."""
    times, smooth = _smooth_way(scene)
    sets, conditions, curves = [], [], []
    number = 0
    for t, node in enumerate(scene.tool_nodes.tolist()):
        name = f"tool_{t + 1}"
        sets.append(f'<NodeSet name="{name}">{node + 1}</NodeSet>')
        for axis, way in zip(AXES, smooth[:, t].T.tolist()):
            number += 1
            points = [f"<pt>{time!r},{value!r}</pt>" for time, value in zip(times.tolist(), way)]
            curves += _element("load_controller", ["<interpolate>LINEAR</interpolate>", "<extend>CONSTANT</extend>",
                                                   *_element("points", points)], id=number, type="loadcurve")
            conditions += _element("bc", [f"<dof>{axis}</dof>", f'<value lc="{number}">1</value>'],
                                   name=f"{name}_{axis}", type="prescribed displacement", node_set=name)
    return sets, conditions, curves


def _dynamic_step(number: int, name: str, num_steps: int, step_size: float, conditions: list[str], records: int) -> list[str]:
    """A step that is halved where Newton's method fails, and ends at each point of the curve `records` all the same."""
    stepper = ["<max_retries>10</max_retries>", "<aggressiveness>1</aggressiveness>", "<opt_iter>25</opt_iter>",
               f"<dtmin>{step_size / 64.0!r}</dtmin>", f'<dtmax lc="{records}">0</dtmax>']
    control = ["<analysis>DYNAMIC</analysis>", f"<time_steps>{num_steps}</time_steps>",
               f"<step_size>{step_size!r}</step_size>", *_solver(), *_element("time_stepper", stepper, type="default")]
    boundary = _element("Boundary", conditions) if conditions else []
    return _element("step", _element("Control", control) + boundary, id=number, name=name)


def tool_scene_to_febio(scene: ToolScene, path: Path) -> None:
    """Writes a dynamic job of FEBio 4: linear tetrahedra of FEBio's "neo-Hookean", the law of the reference, and its body
    load "mass damping".

    The first step has conditions that take each node of the tool along its records, smoothly; the second has none,
    because the tool has let go. Time steps are a quarter of a frame, or less where Newton's method needs it. FEBio writes the
    displacements of all nodes and the reactions of the tool's beside the file, at each of them. Raises InputError.
    """
    sets, conditions, curves = _tool(scene)
    materials, elements, domains = _regions(_Parts(), _arrays(scene.solid()))
    num_frames, records = len(scene.time) - 1, len(AXES) * len(scene.tool_nodes) + 1
    longest = [f"<pt>{time!r},{scene.step!r}</pt>" for time in scene.time.tolist()]
    curves += _element("load_controller", ["<interpolate>LINEAR</interpolate>", "<extend>CONSTANT</extend>",
                                           *_element("points", longest)], id=records, type="loadcurve")
    steps = _dynamic_step(1, "held", STEPS_PER_FRAME * scene.last_record_held, scene.step, conditions, records)
    if scene.last_record_held < num_frames:
        steps += _dynamic_step(2, "let_go", STEPS_PER_FRAME * (num_frames - scene.last_record_held), scene.step, [], records)
    fixed = _element("bc", [f"<{axis}_dof>1</{axis}_dof>" for axis in AXES],
                     name="held", type="zero displacement", node_set="held")
    damping = _element("body_load", [f"<C>{scene.mass_damping!r}</C>"], name="damping", type="mass damping")
    stem = os.path.splitext(os.path.basename(os.fspath(path)))[0]
    log = [f'<node_data data="{data}" delim="," node_set="{nodes}" file="{stem}.{what}.csv"/>'
           for data, nodes, what in (("ux;uy;uz", "nodes", "displacement"), ("Rx;Ry;Rz", "tool", "force"))]
    _write_job(path, {
        "Material": materials,
        "Mesh": [*_element("Nodes", _rows("node", "id", 1, scene.points), name="nodes"), *elements,
                 f'<NodeSet name="held">{_numbers(scene.held + 1)}</NodeSet>',
                 f'<NodeSet name="tool">{_numbers(scene.tool_nodes + 1)}</NodeSet>', *sets],
        "MeshDomains": domains, "Boundary": fixed, "Loads": damping, "Step": steps, "LoadData": curves,
        "Output": _element("plotfile", ['<var type="displacement"/>', '<var type="stress"/>'], type="febio")
                  + _element("logfile", log)})


SCENE = '''"""A moving load case of Livermark in SOFA: runSofa -l SofaPython3 {name}

{title}.
SI units. For SOFA with SofaPython3 in which NeoHookean takes mu and lambda, as its sources of August 2026 do: see
docs/studies/peers.md. The suite's tests do not run SOFA.
"""

TIME_STEP = {time_step!r}  # [s]
POINTS = {points!r}  # [m]
NODE_MASS = {node_mass!r}  # [kg]
# mu [Pa], lambda [Pa] and the tetrahedra of each region
REGIONS = {regions!r}
HELD = {held!r}  # nodes that never move
TOOL = {tool!r}  # nodes that the tool moves until it lets go
TIMES = {times!r}  # [s], a step early: SOFA takes nodes to where they are due when a step begins
WAY = {way!r}  # displacement of each of the tool's nodes a step after these times [m]


def createScene(root):
    root.dt = TIME_STEP
    root.gravity = [0.0, 0.0, 0.0]
    root.addObject("RequiredPlugin", pluginName=[
        "Sofa.Component.Constraint.Projective", "Sofa.Component.LinearSolver.Iterative", "Sofa.Component.Mass",
        "Sofa.Component.ODESolver.Backward", "Sofa.Component.SolidMechanics.FEM.HyperElastic",
        "Sofa.Component.StateContainer", "Sofa.Component.Topology.Container.Dynamic"])
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("livermark")
    body.addObject("EulerImplicitSolver", rayleighMass={mass_damping!r}, rayleighStiffness=0.0)
    # The threshold is for p^T A p in kg (m/s)^2, not for a ratio: 1e-10 ends iterations that have hardly begun.
    body.addObject("CGLinearSolver", iterations=200, tolerance=1e-10, threshold=1e-30)
    body.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=POINTS,
                   tetrahedra=sum((region[2] for region in REGIONS), []))
    body.addObject("MechanicalObject", name="nodes", template="Vec3d", position=POINTS, showObject=True)
    body.addObject("DiagonalMass", name="mass", topology="@tetrahedra", vertexMass=NODE_MASS)
    body.addObject("FixedProjectiveConstraint", indices=HELD)
    for node, way in zip(TOOL, WAY):  # behind the last of its times a node is free
        body.addObject("LinearMovementProjectiveConstraint", template="Vec3d", indices=[node], keyTimes=TIMES,
                       movements=way, relativeMovements=True)
    for number, (mu, lame_lambda, tetrahedra) in enumerate(REGIONS, 1):
        region = body.addChild("region_" + str(number))
        region.addObject("TetrahedronSetTopologyContainer", name="tetrahedra", position=POINTS, tetrahedra=tetrahedra)
        region.addObject("TetrahedronHyperelasticityFEMForceField", name="elements", topology="@tetrahedra",
                         materialName="NeoHookean", ParameterSet=[mu, lame_lambda])
'''


def _node_masses(scene: ToolScene) -> NDArray[numpy.float64]:
    """A quarter of each tetrahedron's mass for each of its corners, shape (N) [kg]."""
    corners = scene.points[scene.tetrahedra]
    volume = numpy.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    mass = numpy.zeros(len(scene.points))
    numpy.add.at(mass, scene.tetrahedra, (0.25 * scene.density[scene.region] * volume)[:, None])
    return mass


def tool_scene_to_sofa(scene: ToolScene, path: Path) -> None:
    """Writes a scene of SofaPython3: neo-Hookean linear tetrahedra, a force field for each region, backward Euler with
    conjugate gradients, and Rayleigh damping of the mass. A factor in place of conjugate gradients would hold the tool's nodes
    for ever, because their constraint is in the matrix at all times.

    Each node of the tool has a LinearMovementProjectiveConstraint, which holds it until the last of its times. Time steps
    are a quarter of a frame.
    """
    held = slice(0, scene.last_record_held + 1)
    mu = 0.5 * scene.young_modulus / (1.0 + scene.poisson_ratio)
    lame_lambda = 2.0 * mu * scene.poisson_ratio / (1.0 - 2.0 * scene.poisson_ratio)
    regions = [[float(mu[r]), float(lame_lambda[r]), scene.tetrahedra[scene.region == r].tolist()] for r in range(len(mu))]
    with open(path, "w", encoding="utf-8") as file:
        file.write(SCENE.format(
            name=os.path.basename(os.fspath(path)), title=scene.title.replace("\\", "/").replace('"', "'"),
            time_step=scene.step, points=scene.points.tolist(), node_mass=_node_masses(scene).tolist(), regions=regions,
            held=scene.held.tolist(), tool=scene.tool_nodes.tolist(), times=(scene.time[held] - scene.step).tolist(),
            way=scene.displacement[held].transpose(1, 0, 2).tolist(), mass_damping=scene.mass_damping))
