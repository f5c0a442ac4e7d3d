"""Time steps, predicted and observed."""
from __future__ import annotations

import math
from typing import NamedTuple

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import ReportData, attributes_of, table_of
from livermark.report.labels import name_points
from livermark.report.parts import Section, figure, missing, paragraph, subsection, table
from livermark.studies.tables import MILLISECONDS

TITLE = "Time steps, predicted and observed"
COMMAND = "livermark stability"  # makes the files


class Limit(NamedTuple):
    """A step of which both are known [s]."""
    body: str
    name: str  #: of the integrator, and whether it is damped
    is_damped: bool
    predicted: float
    observed: float


def _limits(file, body: str) -> list[Limit]:
    steps = file["critical_time_step"]
    limits = []
    for i, integrator in enumerate(attributes_of(steps)["integrators"]):
        for damping, addition in (("undamped", ""), ("damped", ", damped")):
            predicted, observed = (float(steps[f"{damping}_{kind}"][i]) for kind in ("predicted", "observed"))
            if 0.0 < predicted < math.inf and not math.isnan(observed):
                limits.append(Limit(body, integrator + addition, damping == "damped", predicted, observed))
    return limits


def _plot(limits: list[Limit], first_body: str) -> Markup:
    """Observed against predicted steps of all files: on the line they agree."""
    predicted, observed = ([MILLISECONDS * getattr(limit, kind) for limit in limits] for kind in ("predicted", "observed"))
    axes = figures.new_plot("Longest stable step", "predicted [ms]", "observed [ms]", height=340)
    figures.set_logarithmic(axes, "xy", {"x": predicted, "y": observed})
    with matplotlib.rc_context(figures.SETTINGS):
        ends = [min(predicted), max(predicted)]
        axes.plot(ends, ends, color=colours.FAINT, linestyle=(0, (2, 2)), zorder=1)
        for limit, x, y in zip(limits, predicted, observed):
            axes.plot([x], [y], linestyle="", marker="^" if limit.is_damped else "o",
                      color=colours.BLUE if limit.body == first_body else colours.VERMILION)
    name_points(axes, predicted, observed, [limit.name for limit in limits])
    return figures.finish(axes, "stable_steps")


def _caption(made: dict) -> str:
    springs = made.get("model") or made["spring_law"]
    return (f"{made['body']}, springs of {springs}, constrained as in {made['load_case']}: angular frequencies "
            f"from {made['lowest_angular_frequency']:.2f} to {made['largest_angular_frequency']:.2f} rad/s (Gershgorin's "
            f"bound: {made['largest_angular_frequency_bound']:.2f} rad/s); damped with alpha = {made['alpha']:.4f} 1/s and "
            f"beta = {made['beta']:.3e} s; the mean edge over the speed of sound is "
            f"{MILLISECONDS * made['element_time_step']:.3f} ms.")


def section(data: ReportData) -> Section | None:
    if not data.told["stability"]:
        return None
    html = paragraph(
        "The longest stable step of an integrator is predicted from the largest frequency of the springs, and observed in "
        "runs of the nonlinear springs. None: without damping, oscillations grow at every step. Any: stable at every step. "
        "Not observed: just above the limit a motion grows too slowly to be seen in a run.")
    limits, bodies, commands = [], [], []
    for told in data.told["stability"]:
        with data.open(told["file"]) as file:
            made = attributes_of(file)
            limits += _limits(file, made["body"])
        bodies.append(made["body"])
        commands.append(made["command"])
        html += subsection(made["body"], figure("table", table(table_of(told["table"])), _caption(made), [made["command"]]))
    if limits:
        html += figure("figure", _plot(limits, bodies[0]),
                       "Observed against predicted steps; on the dashed line they agree. "
                       f"Blue: {bodies[0]}; orange: other bodies. Circles: without damping; triangles: with it.", commands)
    else:
        html += missing("The steps were not observed in runs (--no-observed).")
    return Section("steps", TITLE, html)
