"""Error against Poisson's ratio."""
from __future__ import annotations

import math

from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import ReportData, Result, commands_of
from livermark.report.parts import Section, figure, missing, paragraph, plots, table
from livermark.studies.tables import PERCENT, mean

TITLE = "Error against Poisson's ratio"
COMMAND = "livermark run --static --poisson 0.25,0.45,0.49"  # makes the files
Cases = dict[float, dict[str, Result]]  # by Poisson's ratio and load case


def _by_body(data: ReportData) -> dict[str, Cases]:
    bodies: dict[str, Cases] = {}
    for result in filter(lambda result: result.counts, data.results):
        bodies.setdefault(result.body, {}).setdefault(result.poisson_ratio, {})[result.load_case] = result
    return bodies


def _error(results: dict[str, Result], load_cases: list[str], name: str) -> float:
    """Mean over load cases; NaN if one is missing."""
    models = [results[load_case].models.get(name) for load_case in load_cases]
    return mean([model.error if model else math.nan for model in models])


def _plot(body: str, cases: Cases, load_cases: list[str], models: list[str]) -> Markup:
    ratios = sorted(cases)
    errors = {name: [PERCENT * _error(cases[ratio], load_cases, name) for ratio in ratios] for name in models}
    errors = {name: values for name, values in errors.items() if any(map(math.isfinite, values))}
    axes = figures.new_plot(body, "Poisson's ratio", "mean error at rest [%]")
    figures.set_logarithmic(axes, "y", {"y": [value for values in errors.values() for value in values]})
    # The key has the order of the right ends of the lines.
    for name, values in sorted(errors.items(), key=lambda item: -item[1][-1] if math.isfinite(item[1][-1]) else -math.inf):
        figures.draw_line(axes, ratios, values, name, colours.style_of(name, models))
    return figures.finish(axes, f"{body}-error_against_poissons_ratio")


def section(data: ReportData) -> Section | None:
    if not data.has_several_ratios:
        return None
    html = paragraph("Plain springs have a Poisson's ratio of 1/4, whatever the material says. A model that failed in one "
                     "of the load cases has no point there.")
    drawn, remarks = [], []
    for body, cases in _by_body(data).items():
        if len(cases) < 2:
            continue
        # Only the same load cases can be compared over all ratios.
        common = sorted(set.intersection(*(set(results) for results in cases.values())))
        if not common:
            html += missing(f"{body} has no load case that was run at each of its Poisson's ratios.")
            continue
        drawn.append(_plot(body, cases, common, data.models))
        remarks.append(f"{body}: {', '.join(common)}")
    if drawn:
        html += figure("figure", plots(drawn), "Mean error at rest over the load cases that were run at every ratio "
                       f"({'; '.join(remarks)}).", commands_of(data.results))
    html += figure("table", table(data.tables["means"]), "Mean error over the static load cases of each body and ratio. "
                   + data.told["reference"])
    return Section("poisson", TITLE, html)
