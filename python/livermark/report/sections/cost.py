"""Error against cost, at rest and in motion."""
from __future__ import annotations

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import ReportData, commands_of, number
from livermark.report.labels import name_points
from livermark.report.parts import Section, figure, paragraph, plots, table
from livermark.studies.tables import PERCENT

TITLE = "Error against cost"
COMMAND = "livermark run"  # makes the files


def _group_of(standing: dict) -> str:
    return ", ".join(filter(None, (standing["body"], standing["load_case"])))


def _name(standing: dict, group: list[dict]) -> str:
    """The model, with its integrator where a group has several of them."""
    integrators = {other["integrator"] for other in group if other["model"] == standing["model"]}
    return standing["model"] if len(integrators) == 1 else f"{standing['model']}, {standing['integrator']}"


def _plot(title: str, group: list[dict], models: list[str], error_label: str) -> Markup:
    """The points of a group, and the front as a line behind them."""
    cost = [number(standing["cost"]) for standing in group]
    error = [PERCENT * number(standing["error"]) for standing in group]
    shown = [k for k in range(len(group)) if figures.has_points([cost[k]], [error[k]]) and group[k]["is_ranked"]]
    if not shown:
        return Markup("")
    axes = figures.new_plot(title, "seconds of one core for a simulated second", error_label, height=340)
    figures.set_logarithmic(axes, "xy", {"x": [cost[k] for k in shown], "y": [error[k] for k in shown]})
    front = sorted((cost[k], error[k]) for k in shown if group[k]["is_on_front"])
    with matplotlib.rc_context(figures.SETTINGS):
        axes.plot(*zip(*front), color=colours.FAINT, linestyle=(0, (2, 2)), zorder=1)
        for k in shown:
            style = colours.style_of(group[k]["model"], models)
            axes.plot([cost[k]], [error[k]], linestyle="", marker=style.marker, color=style.colour)
    name_points(axes, [cost[k] for k in shown], [error[k] for k in shown], [_name(group[k], group) for k in shown])
    return figures.finish(axes, f"{title.replace(', ', '-')}-{error_label.rpartition(' [')[0]}_against_cost")


def _plots(standings: list[dict], models: list[str], error_label: str) -> Markup:
    groups: dict[str, list[dict]] = {}
    for standing in standings:
        groups.setdefault(_group_of(standing), []).append(standing)
    return plots([_plot(title, group, models, error_label) for title, group in groups.items()])


def section(data: ReportData) -> Section | None:
    commands = commands_of(data.results)
    standings = data.told["standings"]
    if not standings["rest"] and not standings["motion"]:
        return None
    html = paragraph("Below and to the left is better. The dashed line joins the Pareto front: no other point has a smaller "
                     "error at the same cost. A mean over some of the load cases is not drawn. Costs are of one machine, in one "
                     f"run. {data.told['reference']}")
    if standings["rest"]:
        caption = ("Mean error at rest over the static load cases of each body, against the cost of a simulated second in explicit "
                   "steps of 0.8 of the critical one; for finite elements in the steps of their motion.")
        html += figure("figure", _plots(standings["rest"], data.models, "mean error at rest [%]"), caption, commands)
        html += figure("table", table(data.tables["rest"]), "The same in numbers.")
    if standings["motion"]:
        html += figure("figure", _plots(standings["motion"], data.models, "error in motion [%]"),
                       "Error of the motion of the probes, against the cost of a simulated second.", commands)
        html += figure("table", table(data.tables["motion"]), "The same in numbers.")
    return Section("cost", TITLE, html)
