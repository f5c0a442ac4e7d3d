"""Tissue that relaxes: what a tool feels over time."""
from __future__ import annotations

import math

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, Result, model_names, number, table_of
from livermark.report.parts import Section, figure, paragraph, plots, subsection, table
from livermark.studies.tables import MILLIMETRES

TITLE = "Tissue that relaxes"
COMMAND = "livermark run --load-case hold_after_press palpation_at_1_hz"  # makes the files
MOST_CURVES = 6  # with the reference


def _distance(values: list[float], reference: list[float]) -> float:
    """Largest difference over the times; infinite where a model did not reach all of them."""
    if len(values) != len(reference):
        return math.inf
    return max((abs(value - other) for value, other in zip(values, reference)), default=math.inf)


def _nearest(curves: list[dict], reference: str) -> list[dict]:
    """The reference, and the models that are nearest to it over time."""
    of_reference = next((curve["values"] for curve in curves if curve["model"] == reference), [])
    return sorted(curves, key=lambda curve: (curve["model"] != reference, _distance(curve["values"], of_reference)))[:MOST_CURVES]


def _plot(result: Result, time: list[float], curves: list[dict], models: list[str]) -> Markup:
    unit = 1.0 if curves[0]["is_force"] else MILLIMETRES
    axes = figures.new_plot(f"{result.load_case}: {curves[0]['place']}", "time [s]",
                            "force [N]" if curves[0]["is_force"] else "displacement [mm]")
    with matplotlib.rc_context(figures.SETTINGS):
        for curve in _nearest(curves, result.reference):
            is_reference = curve["model"] == result.reference
            style = colours.style_of(curve["model"], models)
            values = [unit * value for value in curve["values"]]
            axes.plot(time[:len(values)], values, color=colours.INK if is_reference else style.colour,
                      linestyle="-" if is_reference else style.dash, linewidth=3.0 if is_reference else 1.4, label=curve["model"])
        axes.set_xlim(0.0, time[-1])
    return figures.finish(axes, f"over_time-{curves[0]['place']}")


def _case(result: Result, told: dict, models: list[str]) -> Markup:
    places = list(dict.fromkeys(curve["place"] for curve in told["curves"]))
    with figure_files.about(result.label, result.load_case):
        drawn = [_plot(result, told["time"], [curve for curve in told["curves"] if curve["place"] == place], models)
                 for place in places]
    html = figure("figure", plots(drawn), f"Response at the tool over time, of {result.reference} and of the models nearest to it.",
                  [result.command]) if drawn else Markup("")
    html += figure("table", table(table_of(told["table"])), "Every model.", [result.command])
    return subsection(f"{result.label}: {result.title}", html)


def section(data: ReportData) -> Section | None:
    results = [*data.results, *data.large]
    told = [*data.told["slow"], *data.told["large_slow"]]
    if not told:
        return None
    by_file = {result.file: result for result in results}
    html = paragraph("In these load cases tissue relaxes while it is held. " + data.told["slow_legend"].strip().capitalize() + ".")
    for entry in told:
        for curve in entry["curves"]:
            curve["values"] = [number(value) for value in curve["values"]]
        html += _case(by_file[entry["file"]], entry, model_names(results))
    return Section("relaxation", TITLE, html)
