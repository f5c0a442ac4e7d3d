"""Errors over the bodies of a cohort: how they are distributed, and their statistics."""
from __future__ import annotations

import math
from typing import Optional

import matplotlib
from markupsafe import Markup
from matplotlib.lines import Line2D

from livermark.report import colours, figures
from livermark.report.data import ReportData, attributes_of, cleaned, with_signs
from livermark.report.parts import Section, figure, missing, paragraph, table
from livermark.studies.cohort import HALVES as IN_WORDS
from livermark.studies.cohort import Statistics, apart, errors_of_file, statistics_of
from livermark.studies.cohort import table as statistics_table
from livermark.studies.tables import PERCENT, Column, Table

TITLE = "Livers of other people"
COMMAND = "livermark cohort --bodies 1-8 --output FOLDER"  # makes the files
HALVES = {"training": colours.Style(colours.BLUE, "o"), "unseen": colours.Style(colours.VERMILION, "D")}
ROW, STRIP = 50, 15  # [pixel]


def _by_model(statistics: list[Statistics]) -> dict[str, dict[str, Statistics]]:
    """Statistics of each model and half; the smaller median on the unseen half comes first."""
    models: dict[str, dict[str, Statistics]] = {}
    for one in statistics:
        if one.errors:
            models.setdefault(cleaned(one.model), {})[one.half] = one

    def median(item):
        return next(item[1][half].median for half in ("unseen", "training") if half in item[1])
    return dict(sorted(models.items(), key=median))


def _draw_strip(axes, one: Statistics, style: colours.Style, y: float) -> None:
    low, median, high = (PERCENT * value for value in (one.median_interval[0], one.median, one.median_interval[1]))
    if not math.isnan(low):
        axes.fill_between([low, high], y - 0.11, y + 0.11, color=colours.BAND, linewidth=0, zorder=1)
    axes.plot([PERCENT * error for error in one.errors], [y] * len(one.errors), linestyle="", marker=style.marker,
              markersize=6, color=style.colour, alpha=0.75, zorder=2)
    axes.plot([median, median], [y - 0.15, y + 0.15], color=colours.INK, linewidth=2, zorder=3)


def _plot(group: list[Statistics]) -> Optional[Markup]:
    """The errors of all bodies on one logarithmic axis; names stand above their strips, for narrow screens."""
    models = _by_model(group)
    errors = [PERCENT * error for one in group for error in one.errors]
    if not figures.has_points(errors, errors):
        return None
    height = ROW * len(models) + figures.TOP + figures.BOTTOM + 20
    axes = figures.new_plot(f"Error of each body at Poisson's ratio {group[0].poisson_ratio:g}",
                            "mean relative L2 error over load cases [%]", "", 440, height)
    axes.figure.subplots_adjust(left=12 / 440)
    figures.set_logarithmic(axes, "x", {"x": errors})
    with matplotlib.rc_context(figures.SETTINGS):
        for row, (name, halves) in enumerate(models.items()):
            axes.text(0.0, -row + 0.32, name, transform=axes.get_yaxis_transform(), va="center")
            for strip, (half, style) in enumerate(HALVES.items()):
                if half in halves:
                    _draw_strip(axes, halves[half], style, -row - strip * STRIP / ROW)
        axes.set_ylim(-len(models) + 0.45, 0.75)
        axes.yaxis.set_visible(False)
        axes.spines["left"].set_visible(False)
        for half, style in HALVES.items():
            axes.add_line(Line2D([], [], linestyle="", marker=style.marker, markersize=6, color=style.colour, label=IN_WORDS[half]))
    return figures.finish(axes, f"cohort-{group[0].regime}-{group[0].poisson_ratio:g}")


def _bodies(file) -> str:
    litres = 1e3 * file["bodies/volume"][:]
    lesions = file["bodies/num_lesions"][:]
    return (f"{len(litres)} livers of {litres.min():.2f} to {litres.max():.2f} L with {lesions.min()} to {lesions.max()} "
            "lesions.")


def _cohort(data: ReportData, name: str) -> Markup:
    with data.open(name) as file:
        command = attributes_of(file)["command"]
        html = paragraph(_bodies(file)) if len(file["bodies/volume"]) else Markup("")
        cases = attributes_of(file["errors/load_case"])["names"] if "errors" in file else []
        failures = cleaned(bytes(file["failures"][:]).decode(errors="replace")).splitlines() if "failures" in file else []
        statistics = statistics_of(errors_of_file(file))
    for group in apart(statistics, "regime", "reference", "poisson_ratio"):
        regime, reference = group[0].regime, cleaned(group[0].reference)
        if plot := _plot(group):
            html += figure("figure", plot,
                           f"Deformations of the {regime} regime: a marker for each body, a stroke for the "
                           "median and a bar for its interval of 95 %, where there are bodies enough. The smallest "
                           "median comes first.", [command])
        made = statistics_table(group, data.smallest_felt_difference)
        html += figure("table", table(Table([Column(with_signs(column.title), column.is_number) for column in made.columns], cleaned(made.rows))),
                       f"Deformations of the {regime} regime: mean relative L2 error over load cases"
                       + (f", against {reference}" if reference else "") + ", in brackets the interval "
                       "of 95 % by bootstrap where there are bodies enough; tool: the same of the absolute value of the "
                       "stiffness at the tool; ±, tool ±: the reference's own error. "
                       f"Load cases: {', '.join(sorted(cases))}.", [command])
    for failure in failures:
        html += missing("Failed: " + failure)
    return html


def section(data: ReportData) -> Section | None:
    if not data.told["cohorts"]:
        return None
    html = paragraph(
        "Errors over the bodies of a cohort. Constants of models may be chosen on the tuning half; accuracy is quoted on "
        "the test half. The other sections leave these bodies out: a report of the folder of one body shows it in full.")
    for name in data.told["cohorts"]:
        html += _cohort(data, name)
    return Section("cohort", TITLE, html)
