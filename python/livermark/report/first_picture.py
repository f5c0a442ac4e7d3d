"""The picture that a report begins with: the first body under the tool, coloured by the error of the best springs, seen from where
the hand is, and what it shows in plain words."""
from __future__ import annotations

import math
from typing import NamedTuple, Optional

import numpy
from markupsafe import Markup

from livermark.report import colours, figure_files, figures, picture_sheets, surfaces
from livermark.report.data import Result
from livermark.report.parts import figure, paragraph
from livermark.report.picture_sheets import Panel, Scale
from livermark.report.reference import of_reference
from livermark.report.sections.pictures import DRAWN_PART, LEAST_DRAWN, Body
from livermark.studies.tables import MILLIMETRES, PERCENT, fixed, rounded_up
from livermark.vessels import vessels_of

WIDTH = 760  # [pixel]
TALLEST = 0.8  # of the width
TILT = 0.35  # of the camera, above the normal of the surface, so that a dent is seen
LARGEST_RING = 0.25  # of the size of the body; a larger place is no tool in a hand
RING_POINTS = 4000


class Tool(NamedTuple):
    """Where a load case presses, pulls or moves, the place at which the model is farthest off."""
    middle: numpy.ndarray  #: [m]
    radius: float  #: [m]


def farthest_case(cases: list[Result], model: str) -> Optional[Result]:
    """The load case under which a model is farthest off: under the tool where there is one, else in position."""
    with_model = [result for result in cases if result.counts and result.reference in result.models and model in result.models
                  and math.isfinite(result.models[model].error)]
    with_tool = [result for result in with_model if math.isfinite(result.models[model].stiffness)]
    if with_tool:
        return max(with_tool, key=lambda result: abs(result.models[model].stiffness))
    return max(with_model, key=lambda result: result.models[model].error, default=None)


def _tool(file, model: str) -> Optional[Tool]:
    tools, found = file.tools, file[model].at_tool
    if tools is None or found is None or len(found["stiffness"]) != len(tools["middle"]):
        return None
    size = numpy.abs(numpy.asarray(found["stiffness"], dtype=float))
    place = int(numpy.argmax(numpy.where(numpy.isfinite(size), size, -1.0)))
    middle, radius = numpy.asarray(tools["middle"][place], dtype=float), float(tools["radius"][place])
    return Tool(middle, radius) if numpy.isfinite(middle).all() and math.isfinite(radius) else None


def outward(body: Body, tool: Tool) -> numpy.ndarray:
    """Mean normal of the surface below the tool, of unit length: from there the hand comes."""
    areas = surfaces.area_vectors(body.triangles, body.points)
    distance = numpy.linalg.norm(body.points[body.triangles].mean(axis=1) - tool.middle, axis=1)
    below = distance <= max(tool.radius, float(distance.min()))
    normal = areas[below].sum(axis=0)
    if numpy.linalg.norm(normal) < 1e-6 * numpy.linalg.norm(areas[below], axis=1).sum():
        normal = areas[int(distance.argmin())]
    return normal / max(float(numpy.linalg.norm(normal)), 1e-300)


def _ring(view: surfaces.View, tool: Tool, normal: numpy.ndarray) -> numpy.ndarray:
    """Samples (H, W) of the rim of the tool."""
    across = numpy.cross(normal, view.up)
    across /= max(float(numpy.linalg.norm(across)), 1e-300)
    along = numpy.cross(across, normal)
    angle = numpy.linspace(0.0, 2.0 * math.pi, RING_POINTS)[:, None]
    rim = view.project(tool.middle + tool.radius * (numpy.cos(angle) * across + numpy.sin(angle) * along))[:, :2]
    drawn = numpy.zeros((surfaces.SAMPLES * view.height, surfaces.SAMPLES * view.width), dtype=bool)
    column, row = numpy.floor(rim).astype(int).T
    for shift_x in (-1, 0, 1):
        for shift_y in (-1, 0, 1):
            x, y = column + shift_x, len(drawn) - 1 - row + shift_y
            inside = (x >= 0) & (x < drawn.shape[1]) & (y >= 0) & (y < drawn.shape[0])
            drawn[y[inside], x[inside]] = True
    return drawn


class Picture(NamedTuple):
    drawn: numpy.ndarray
    factor: float  #: by which displacements are drawn longer
    scale: float  #: error of the last colour [m]
    has_ring: bool


def _draw(result: Result, model: str) -> Optional[Picture]:
    """None where a file has nothing that can be drawn."""
    with result.open() as file:
        body = Body(file.points, file.boundary_triangles, file.tetrahedra, vessels_of(file.vessels))
        displacement, error, tool = file[model].displacement, file[model].error, _tool(file, model)
        judged = file[result.reference].displacement
    if not all(body.can_draw(field) for field in (displacement, error, judged)):
        return None
    longest, scale = (float(numpy.linalg.norm(field, axis=1).max()) for field in (displacement, error))
    moves = min(longest, float(numpy.linalg.norm(judged, axis=1).max()))
    if moves < LEAST_DRAWN * body.size or scale <= 0.0:
        return None
    factor = max(1.0, 1.0 / rounded_up(longest / (DRAWN_PART * body.size)))
    moved = body.points + factor * displacement
    if tool is None:
        view = surfaces.find_view(body.triangles, body.points, displacement, [body.points, moved], WIDTH)
    else:
        view = surfaces.fitted(surfaces.looking_from(outward(body, tool), TILT), [body.points, moved], WIDTH, TALLEST)
    lines = surfaces.outline_of(body.triangles, body.points, view)
    has_ring = tool is not None and tool.radius < LARGEST_RING * body.size
    if has_ring:
        nearest = int(numpy.linalg.norm(body.points - tool.middle, axis=1).argmin())
        lines = lines | _ring(view, Tool(tool.middle + factor * displacement[nearest], tool.radius), outward(body, tool))
    part = numpy.clip(numpy.linalg.norm(error, axis=1) / scale, 0.0, 1.0)
    drawn = surfaces.draw_surface(body.triangles, moved, colours.ERROR(part)[body.triangles][..., :3], view, lines)
    return Picture(drawn, factor, scale, has_ring)


def sentence(result: Result, model: str, felt: float) -> str:
    """Which model, how far off in position and under the tool, whether a hand feels it, and who judges."""
    found = result.models[model]
    text = (f"With {model}, the best springs here, points of {result.label} end {fixed(PERCENT * found.error, 1)} % of their way from "
            "where they should be (the error in position)")
    if math.isfinite(found.stiffness):
        size = fixed(PERCENT * abs(found.stiffness), 1)
        way = "stiff" if found.stiffness > 0.0 else "soft"
        text += (f", and the tool meets a body that is {size} % too {way} (the error under the tool). A hand feels a difference from "
                 f"{PERCENT * felt:.0f} % on, so it {'feels' if abs(found.stiffness) > felt else 'does not feel'} that")
    text += f". The judge is {result.reference}: finite elements"
    own = result.uncertainty
    if not own:
        return text + " whose own error is not known here."
    at_tool = own.get("stiffness_uncertainty", math.nan)
    tail = (f" and {of_reference(at_tool)} % under the tool" if math.isfinite(found.stiffness) and math.isfinite(at_tool) else "")
    return text + f" whose own error is {of_reference(own['reference_uncertainty'])} % in position{tail} here."


def section(cases: list[Result], model: str, felt: float) -> Markup:
    """Nothing where no load case can be drawn."""
    result = farthest_case(cases, model)
    picture = _draw(result, model) if result else None
    if result is None or picture is None:
        return Markup("")
    by = "under the tool" if math.isfinite(result.models[model].stiffness) else "in position"
    length = f"{picture.factor:g} times as long on" if picture.factor > 1.0 else "as long as it is on"
    ring = ", the ring the tool" if picture.has_ring else ""
    caption = (f"{result.label}: {result.title}. It is the load case under which {model} is farthest off {by}. Colour: how far each "
               f"point is from where {result.reference} has it. Motion is drawn {length} the surface; the line is the outline at rest"
               f"{ring}. {'The camera looks at the tool.' if picture.has_ring else ''}")
    scale = Scale(colours.ERROR, MILLIMETRES * picture.scale, f"error of {model} [mm]")
    panel = Panel(picture.drawn, f"error of {model}", f"{result.label}, {result.load_case}")
    figure_files.keep(lambda: picture_sheets.sheet([[panel]], [scale]), figures.SETTINGS,
                      f"{result.label}-{result.load_case}-error_from_the_hand")
    words = f"{result.label} under {result.load_case}: error of {model} from 0 to {MILLIMETRES * picture.scale:.3g} mm"
    drawn = Markup('<div class="first">{}<div class="bar">{}</div></div>\n').format(surfaces.image(picture.drawn, words),
                                                                                 picture_sheets.gradient(scale))
    return Markup('<div class="verdict">{}</div>\n').format(paragraph(sentence(result, model, felt))) + figure(
        "figure", drawn, caption.strip(), [result.command])
