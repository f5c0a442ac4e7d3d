"""Error against refinement: bodies whose names differ in digits only, and the reference on its meshes."""
from __future__ import annotations

import math
import re
from typing import Optional

import numpy
from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import Column, ReportData, Result, Table, commands_of
from livermark.report.parts import Section, figure, plots, table
from livermark.studies.tables import MILLIMETRES, PERCENT, percent
from livermark.volumes import tetrahedron_volumes

TITLE = "Error against refinement"
COMMAND = "livermark run, without --reference-on-mesh"  # makes the files


def element_size(result: Result) -> float:
    """Edge of a cube of the mean volume of a tetrahedron [m]."""
    with result.open() as file:
        volumes = tetrahedron_volumes(file.points, file.tetrahedra)
    return float(volumes.mean() ** (1.0 / 3.0))


def _families(data: ReportData) -> dict[str, list[Result]]:
    """Results of one load case and ratio on bodies whose names differ in digits only, where there are several."""
    families: dict[str, dict[str, Result]] = {}
    for result in data.results:
        title = f"{re.sub('[0-9]', '', result.body)}, {result.load_case}"
        if data.has_several_ratios:
            title += f", nu {result.poisson_ratio:g}"
        families.setdefault(title, {})[result.body] = result
    return {title: list(family.values()) for title, family in families.items() if len(family) > 1}


def _plot(title: str, family: list[Result], models: list[str]) -> Markup:
    by_size = sorted({element_size(result): result for result in family}.items())
    sizes = [MILLIMETRES * size for size, _ in by_size]
    errors = {name: [PERCENT * result.models[name].error if name in result.models else math.nan for _, result in by_size]
              for name in models}
    errors = {name: values for name, values in errors.items() if figures.has_points(sizes, values)}
    if len(by_size) < 2 or not errors:
        return Markup("")
    axes = figures.new_plot(title, "size of an element [mm]", "error at rest [%]")
    figures.set_logarithmic(axes, "xy", {"x": sizes, "y": [value for values in errors.values() for value in values]})
    for name, values in errors.items():
        figures.draw_line(axes, sizes, values, name, colours.style_of(name, models))
    return figures.finish(axes, f"{title.replace(', ', '-')}-error_against_refinement")


def _reference(data: ReportData) -> Optional[Markup]:
    """What refinement changed in the reference, for each result that knows it."""
    rows = [[result.label, result.load_case, result.uncertainty["model"],
             percent(result.uncertainty["refinement_difference"]), percent(result.uncertainty["reference_uncertainty"])]
            for result in data.results if result.uncertainty]
    if not rows:
        return None
    columns = [Column("body"), Column("load case"), Column("reference"), Column("change by refinement [%]", True),
               Column("own error [%]", True)]
    return figure("table", table(Table(columns, rows)), "The change of the reference when each tetrahedron is cut into "
                  "eight, and the estimate of the error that remains.", commands_of(data.results))


def section(data: ReportData) -> Section | None:
    drawn = [plot for title, family in _families(data).items() if (plot := _plot(title, family, data.models))]
    html = Markup("")
    if drawn:
        html += figure("figure", plots(drawn), "Error against the edge of a cube of the mean volume of a tetrahedron, of "
                      "bodies whose names differ in digits only.", commands_of(data.results))
    if of_reference := _reference(data):
        html += of_reference
    return Section("refinement", TITLE, html) if html else None
