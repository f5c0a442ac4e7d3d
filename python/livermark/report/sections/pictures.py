"""What it looks like: the reference, the nearest of the springs and the simplest ones, and their errors."""
from __future__ import annotations

import collections
import math
from dataclasses import dataclass
from typing import Optional

import numpy
from markupsafe import Markup

from livermark.report import colours, figure_files, figures, picture_sheets, surfaces
from livermark.report.data import Model, ReportData, Result
from livermark.report.picture_sheets import Panel, Scale
from livermark.report.parts import Section, choice, figure, missing, name, paragraph
from livermark.studies.tables import MILLIMETRES, PERCENT, rounded_up
from livermark.vessels import Vessels, vessels_of

TITLE = "What it looks like"
COMMAND = "livermark run"  # makes the files
WIDTH = 460  # [pixel]
DRAWN_PART = 0.08  # of the size of the body that its largest displacement is drawn as
LEAST_DRAWN = 1e-9  # of the size of the body that has to move for a picture of it
BEYOND = 1.02  # how far beyond the end of a scale one has to be to be mentioned
SIMPLEST = "lloyd"


def _largest(field: numpy.ndarray) -> float:
    return float(numpy.linalg.norm(field, axis=1).max())


@dataclass(frozen=True)
class Field:
    """What one model found."""
    model: Model
    displacement: numpy.ndarray  #: (N, 3) [m]
    error: Optional[numpy.ndarray]


@dataclass(frozen=True)
class Body:
    """The surface of a result file."""
    points: numpy.ndarray
    triangles: numpy.ndarray
    tetrahedra: numpy.ndarray
    vessels: Optional[Vessels]

    @property
    def size(self) -> float:
        return float(numpy.linalg.norm(numpy.ptp(self.points, axis=0)))

    def can_draw(self, field: Optional[numpy.ndarray]) -> bool:
        """Whether it has lengths that can be drawn: a file may hold anything, whatever it says of itself."""
        if field is None:
            return False
        with numpy.errstate(over="ignore", invalid="ignore"):
            return bool(numpy.all(numpy.linalg.norm(field, axis=1) < 100.0 * self.size))


def _fields_to_show(file, result: Result, body: Body) -> list[Field]:
    """The nearest of the springs and Lloyd's, or whoever is there."""
    def field_of(model: Optional[Model]) -> list[Field]:
        if model is None or not math.isfinite(model.error):
            return []
        field = Field(model, file[model.name].displacement, file[model.name].error)
        return [field] if body.can_draw(field.displacement) and body.can_draw(field.error) else []

    wanted = {model.name: model for model in (result.best_springs, result.models.get(SIMPLEST)) if model}
    shown = [field for model in wanted.values() for field in field_of(model)]
    others = (field for model in result.models.values() for field in field_of(model))
    return shown or list(others)[:1]


@dataclass(frozen=True)
class Scene:
    """Everything that the pictures of one result have in common."""
    body: Body
    view: surfaces.View
    at_rest: numpy.ndarray  #: outline
    what: str  #: body and load case

    def panel(self, points, field, colour_map, scale: float, title: str, detail: str, vessels: Optional[Vessels] = None) -> Panel:
        part = numpy.clip(numpy.linalg.norm(field, axis=1) / scale, 0.0, 1.0)
        corners = colour_map(part)[self.body.triangles][..., :3]
        drawn = surfaces.draw_surface(self.body.triangles, points, corners, self.view, self.at_rest, vessels)
        return Panel(drawn, title, detail)

    def element(self, panel: Panel, of: str, scale: float) -> Markup:
        words = f"{self.what}: {of} from 0 to {MILLIMETRES * scale:.3g} mm"
        return Markup("<div>{}{}<span>{}</span></div>\n").format(surfaces.image(panel.drawn, words), name(panel.title), panel.detail)


def _pictures(result: Result, body: Body, reference: Field, fields: list[Field]) -> Markup:
    peak = _largest(reference.displacement)
    # By the largest of all: springs that buckle would fill the picture otherwise.
    longest = max([peak, *(_largest(field.displacement) for field in fields)])
    worst = max(_largest(field.error) for field in fields)
    factor = max(1.0, 1.0 / rounded_up(longest / (DRAWN_PART * body.size)))
    shapes = [body.points + factor * field.displacement for field in (reference, *fields)]
    view = surfaces.find_view(body.triangles, body.points, reference.displacement, [body.points, *shapes], WIDTH)
    scene = Scene(body, view, surfaces.outline_of(body.triangles, body.points, view),
                  f"{result.body} under {result.load_case}")
    # Errors beyond the displacement itself would leave no colours to the other model.
    error_scale = min(worst, peak) if worst > 0.0 else peak
    vessels = body.vessels and body.vessels.moved(body.points, body.tetrahedra, factor * reference.displacement)
    moved = [scene.panel(shapes[0], reference.displacement, colours.DISPLACEMENT, peak, reference.model.name,
                         f"reference, up to {MILLIMETRES * peak:.3f} mm", vessels)]
    moved += [scene.panel(shape, field.displacement, colours.DISPLACEMENT, peak, field.model.name,
                          f"up to {MILLIMETRES * _largest(field.displacement):.3f} mm") for field, shape in zip(fields, shapes[1:])]
    wrong = [scene.panel(shape, field.error, colours.ERROR, error_scale, "error of " + field.model.name,
                         f"{PERCENT * field.model.relative_l2:.2f} %, up to {MILLIMETRES * field.model.max_error:.3f} mm")
             for field, shape in zip(fields, shapes[1:])]
    scales = [Scale(colours.DISPLACEMENT, MILLIMETRES * peak, "displacement [mm]"),
              Scale(colours.ERROR, MILLIMETRES * error_scale, "error [mm]")]
    figure_files.keep(lambda: picture_sheets.sheet([moved, [None, *wrong]], scales), figures.SETTINGS,
                      f"{result.label}-{result.load_case}-picture")
    html = Markup("").join(scene.element(panel, "displacement of " + panel.title, peak) for panel in moved)
    if len(fields) == 1:
        html += Markup("<div></div>\n")  # so that errors stand below displacements
    html += Markup('<div class="legend">{}{}</div>\n').format(*map(picture_sheets.gradient, scales))
    html += Markup("").join(scene.element(panel, panel.title, error_scale) for panel in wrong)
    start = " (the static start)" if result.has_motion else ""
    length = f"{factor:g} times as long on" if factor > 1.0 else "as long as they are on"
    through = " Blue: vessels that are lines, seen through the surface, as wide as they are." if vessels else ""
    beyond = " Values beyond a scale have its last colour." if max(worst, longest) > BEYOND * peak else ""
    return figure("figure", Markup('<div class="pictures">\n{}</div>\n').format(html),
                  f"{scene.what}: {result.title}{start}. Displacements drawn {length} the surface; the line is the outline "
                  f"at rest.{through}{beyond}", [result.command])


def _drawn(result: Result) -> Markup:
    """The pictures of a load case, or why there are none."""
    nothing = missing("No model was compared with a reference here, so there is nothing to show.")
    if result.reference not in result.models:
        return nothing
    with result.open() as file:
        body = Body(file.points, file.boundary_triangles, file.tetrahedra, vessels_of(file.vessels))
        fields = _fields_to_show(file, result, body)
        reference = Field(result.models[result.reference], file[result.reference].displacement, None)
    if not fields:
        return nothing
    if not body.can_draw(reference.displacement) or _largest(reference.displacement) < LEAST_DRAWN * body.size:
        return missing("The reference does not move, or has diverged.")
    return _pictures(result, body, reference, fields)


def _shown_ratios(data: ReportData) -> dict[str, float]:
    """For each body the Poisson's ratio that most of its results have; of several such ratios the largest."""
    counts: dict[str, collections.Counter] = {}
    for result in data.results:
        counts.setdefault(result.body, collections.Counter())[result.poisson_ratio] += 1
    return {body: max(ratios, key=lambda ratio, of=ratios: (of[ratio], ratio)) for body, ratios in counts.items()}


def section(data: ReportData) -> Section | None:
    if not data.results:
        return None
    ratios = _shown_ratios(data)
    html = paragraph(
        "Each load case: the reference, the most accurate springs, and Lloyd's springs, which are the simplest; below them "
        "the distance of each from the reference. All displacements of a load case have one scale of colours, and so have "
        "all errors, in other colours.")
    html += paragraph("Shown: " + ", ".join(f"{body} at Poisson's ratio {ratio:g}" for body, ratio in ratios.items()) + ".")
    for result in data.results:
        if result.poisson_ratio == ratios[result.body]:
            html += choice("pictures", f"{result.body}, {result.load_case}", _drawn(result))
    return Section("pictures", TITLE, html)
