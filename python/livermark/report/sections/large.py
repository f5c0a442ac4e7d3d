"""Deformations of surgical size: tables, and the force of each model along the way of what moves."""
from __future__ import annotations

import itertools

from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import ReportData, Result, commands_of, model_names, table_of
from livermark.report.parts import Section, figure, paragraph, plots, subsection, table
from livermark.studies.tables import MILLIMETRES

TITLE = "Deformations of surgical size"
COMMAND = "livermark run --regime large"  # makes the files


def _reference_band(axes, result: Result, name: str, depth: list[float], force: list[float]) -> None:
    """How uncertain the force of the reference is, where that is known."""
    if result.uncertainty and name == result.reference:
        part = result.uncertainty["reaction_uncertainty"]
        axes.fill_between(depth, [(1.0 - part) * value for value in force], [(1.0 + part) * value for value in force],
                          color=colours.BAND, linewidth=0, zorder=1)


def _plot(result: Result, place: str, curves: list[dict], models: list[str]) -> Markup:
    axes = figures.new_plot(f"{result.load_case}: {place}", "way [mm]", "force [N]")
    # The key has the order of the right ends of the lines.
    for curve in sorted(curves, key=lambda curve: curve["force"][-1:], reverse=True):
        depth = [0.0, *(MILLIMETRES * way for way in curve["way"])]
        force = [0.0, *curve["force"]]
        figures.draw_line(axes, depth, force, curve["model"], colours.style_of(curve["model"], models))
        if place != "load":  # where the force is given, what is uncertain is the way
            _reference_band(axes, result, curve["model"], depth, force)
    axes.set_xlim(left=0.0)
    return figures.finish(axes, f"{result.label}-{result.load_case}-force-{place}")


def _forces(results: list[Result], told: dict, models: list[str]) -> Markup:
    by_case = {result.load_case: result for result in results}
    drawn = [_plot(by_case[load_case], place, list(curves), models) for (load_case, place), curves in
             itertools.groupby(told["forces"], lambda curve: (curve["load_case"], curve["place"]))]
    if not drawn:
        return Markup("")
    return figure("figure", plots(drawn),
                  f"{told['label']}: force of each model on what moves, against its way; under a load, the way of what is loaded in "
                  "each model. The grey band around the line of the reference is its own error, where that is known; it may be "
                  "narrower than the line.",
                  commands_of(results))


def section(data: ReportData) -> Section | None:
    if not data.large:
        return None
    html = paragraph(data.told["large_legend"]) + paragraph(data.told["large_reference"]) + figure(
        "table matrix", table(data.tables["summary"]),
        "Relative L2 error of the displacement at the whole load [%], against hyperelastic elements.",
        commands_of(data.large))
    models = model_names(data.large)
    for told in data.told["large_bodies"]:
        results = [result for result in data.large if result.label == told["label"]]
        numbers = figure("table", table(table_of(told["table"])),
                         f"{told['label']}: every model under every large load case.", commands_of(results))
        html += subsection(told["label"], numbers + _forces(results, told, models))
    return Section("large", TITLE, html)
