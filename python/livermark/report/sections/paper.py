"""The seed paper beside this: its Table 1, and its Figures 5 and 6."""
from __future__ import annotations

import math
from typing import NamedTuple

import matplotlib
import numpy
from markupsafe import Markup
from matplotlib.ticker import FixedLocator

from livermark.report import colours, figures
from livermark.report.data import Column, ReportData, Table, attributes_of, cleaned, table_of
from livermark.report.parts import Section, bullets, figure, plots, subsection, table

TITLE = "The seed paper beside this"
COMMAND = "livermark histories"  # makes the files
#: What leaves this on either side ends there with a cross, as on the paper's axes.
LARGEST = 1.6
#: Of the lengths of the step, from the longest.
LINES = ((colours.VERMILION, (0, (1, 1.5))), (colours.ORANGE, (0, (4, 1.5, 1, 1.5))), (colours.BLUE, (0, (4, 2))),
         (colours.GREYS[0], "-"), (colours.GREEN, "-"))


class Step(NamedTuple):
    time_step: float  #: [s]
    diverged_at: float  #: [s]; NaN if it did not
    time: numpy.ndarray
    displacement: numpy.ndarray


class Motion(NamedTuple):
    subject: str
    name: str
    title: str
    critical_time_step: float
    steps: list[Step]


def _motions(file, subject: str) -> list[Motion]:
    """Of what is let go, and not of what is pushed: that is the same upside down."""
    motions = []
    for name, group in file["histories"].items():
        made = attributes_of(group)
        steps = [Step(float(group[n].attrs["time_step"]), float(group[n].attrs["diverged_at"]), group[n]["time"][:],
                      group[n]["displacement"][:]) for n in sorted(group, key=int)]
        motions.append(Motion(subject, cleaned(name), made["title"], made["critical_time_step"], steps))
    return [motion for motion in motions if not motion.name.endswith("_step_force")]


def _table_1(papers: list[dict]) -> Markup:
    html = Markup("")
    for paper in papers:
        caption = f"Table 1 of the paper beside {paper['body']}: each printed number in every unit that it could have."
        html += figure("table", table(table_of(paper["table"])), caption, [paper["command"]])
        html += bullets([objection + "." for objection in paper["objections"]])
    return html


def _draw_step(axes, step: Step, colour: str, dash, duration: float) -> None:
    """The line up to where it leaves the panel, and a cross where it does or diverges."""
    verdict = "stable" if math.isnan(step.diverged_at) else "diverges"
    with numpy.errstate(invalid="ignore", over="ignore"):
        relative = step.displacement / step.displacement[0]
    shown = numpy.clip(numpy.where(numpy.isnan(relative), LARGEST, relative), -LARGEST, LARGEST)
    outside = numpy.flatnonzero(shown != relative)
    end = outside[0] + 1 if len(outside) else len(shown)
    axes.plot(step.time[:end], shown[:end], color=colour, linestyle=dash, label=f"h = {step.time_step:.3g} s: {verdict}")
    if len(outside) or verdict == "diverges":
        axes.plot([min(step.time[end - 1], duration)], [shown[end - 1]], linestyle="", marker="x", markeredgewidth=2,
                  markersize=9, color=colour, clip_on=False)


def _plot(motion: Motion) -> Markup:
    duration = max(step.time[-1] for step in motion.steps)
    axes = figures.new_plot(motion.title, "t [s], square root scale; steps up to "
                            f"{motion.critical_time_step:.4g} s are stable", "u / u(0)", height=260)
    with matplotlib.rc_context(figures.SETTINGS):
        axes.set_xscale("function", functions=(lambda t: numpy.sqrt(numpy.maximum(t, 0.0)), numpy.square))
        for number, step in enumerate(motion.steps):
            _draw_step(axes, step, *LINES[number % len(LINES)], duration)
        axes.set_xlim(0.0, duration)
        axes.set_ylim(-LARGEST, LARGEST)
        axes.xaxis.set_major_locator(FixedLocator([0.0, *(part * duration for part in (0.05, 0.2, 0.5, 1.0))]))
        axes.xaxis.set_major_formatter(lambda time, _: f"{time:.3g}")
    return figures.finish(axes)


def _share(motions: list[Motion], time_step: float) -> str:
    """How many motions were stable in steps of some length, as "3 of 6"; "-" if none took such a step."""
    steps = [(motion, step) for motion in motions for step in motion.steps if abs(step.time_step / time_step - 1.0) < 1e-9]
    stable = sum(math.isnan(step.diverged_at) and step.time_step <= motion.critical_time_step for motion, step in steps)
    return f"{stable} of {len(steps)}" if steps else "-"


def _verdicts(motions: list[Motion]) -> Markup:
    points = [motion for motion in motions if motion.subject == "one_degree_of_freedom"]
    without = [motion for motion in points if "without_tumour" in motion.name]
    groups = (without, [motion for motion in points if motion not in without],
              [motion for motion in motions if motion not in points])
    claims = ((0.005, "stable, without and with tumours"), (0.05, "-"), (0.5, "-"), (1.0, "stable for neither"))
    rows = [[f"h = {step:g} s", claim, *(_share(group, step) for group in groups)] for step, claim in claims]
    columns = [Column("step"), Column("the paper says"), Column("one degree of freedom, without tumours", True),
               Column("with tumours", True), Column("whole bodies", True)]
    return figure("table", table(Table(columns, rows)),
                  "How many motions are stable in the steps of Figures 5 and 6, beside what the paper says of them. Those "
                  "of one degree of freedom differ in what the units of Table 1 are read as.")


def _figures_5_and_6(data: ReportData) -> Markup:
    motions, commands = [], []
    for name in data.told["histories"]:
        with data.open(name) as file:
            made = attributes_of(file)
            motions += _motions(file, made["subject"])
            commands.append(made["command"])
    drawn = plots([_plot(motion) for motion in motions if motion.steps])
    return _verdicts(motions) + figure(
        "figure", drawn, "What Figures 5 and 6 of the paper show: its model of one degree of freedom in four time steps, "
        "once for each reading of its units, and whole bodies, whose probe is drawn relative to where it started. A cross is "
        "where a motion leaves the panel or diverges.", commands) + figure(
        "table", table(data.tables["histories"]), "The same in words.")


def section(data: ReportData) -> Section | None:
    if not data.told["histories"]:  # nobody asks how the report of a patient compares with a paper
        return None
    html = Markup(
        "<p><cite>Integrating biomechanical parameters in modeling of liver with and without tumor in virtual "
        'environment</cite>, Jurnal Teknologi 75, <a href="https://doi.org/10.11113/jt.v75.5068">10.11113/jt.v75.5068</a>, '
        "puts a mass-spring model on two livers, which are not those that are here.</p>\n")
    if data.told["paper"]:
        html += subsection("Table 1", _table_1(data.told["paper"]))
    html += subsection("Figures 5 and 6", _figures_5_and_6(data))
    return Section("paper", TITLE, html)
