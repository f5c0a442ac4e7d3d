"""Needles: force and target over depth."""
from __future__ import annotations

import matplotlib
import numpy
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, attributes_of, cleaned, table_of
from livermark.report.parts import Section, figure, paragraph, plots, subsection, table
from livermark.studies.tables import MILLIMETRES, fixed

TITLE = "Needles"
COMMAND = "livermark needle BODY --output FOLDER"  # makes the files
MOST_CURVES = 4  # beside the reference


def _miss(model) -> numpy.ndarray:
    """Where the target is when the tip is where it was at rest [m]."""
    return model["target"][int(attributes_of(model)["at_plan"])]


def _chosen(needle, reference: str) -> list[str]:
    """The reference, and those whose target is nearest to that of the reference."""
    others = [name for name in needle["models"] if name != reference and numpy.isfinite(_miss(needle["models"][name])).all()]
    there = _miss(needle["models"][reference])
    others.sort(key=lambda name: float(numpy.linalg.norm(_miss(needle["models"][name]) - there)))
    return [reference] + others[:MOST_CURVES]


def _plot(needle, title: str, y_label: str, values, models: list[str], shown: list[str]) -> Markup:
    """values: of a model's group, over its depth"""
    axes = figures.new_plot(title, "depth of the needle [mm]", y_label, 440, 330)
    with matplotlib.rc_context(figures.SETTINGS):
        for number, name in enumerate(shown):
            group = needle["models"][name]
            style = colours.style_of(cleaned(name), models)
            axes.plot(MILLIMETRES * group["depth"][:], values(group),
                      color=colours.INK if number == 0 else style.colour, linestyle="-" if number == 0 else style.dash,
                      linewidth=3.0 if number == 0 else 1.4, label=cleaned(name))
        axes.set_xlim(left=0.0)
    return figures.finish(axes)


def _verdict(needle, reference: str) -> Markup:
    made = attributes_of(needle)
    groups = needle["models"]
    there = _miss(groups[reference])
    apart = {name: float(numpy.linalg.norm(_miss(groups[name]) - there)) for name in groups
             if name != reference and numpy.isfinite(_miss(groups[name])).all()}
    text = (f"When the tip is where the target was, {reference} has the target {fixed(MILLIMETRES * float(numpy.linalg.norm(there)), 1)}"
            f" mm away from there")
    change = float(made["reference_miss_change"])
    if numpy.isfinite(change):
        text += f"; its last refinement changed that by {fixed(MILLIMETRES * change, 2)} mm"
    text += ". "
    if apart:
        nearest, farthest = min(apart, key=apart.get), max(apart, key=apart.get)
        text += (f"Of {len(apart)} models {cleaned(nearest)} comes nearest to that, {fixed(MILLIMETRES * apart[nearest], 2)} mm off, "
                 f"and {cleaned(farthest)} is the farthest, {fixed(MILLIMETRES * apart[farthest], 2)} mm off.")
    return paragraph(text)


def _needle(needle, command: str) -> Markup:
    made = attributes_of(needle)
    reference = made["reference"]
    models = [cleaned(name) for name in needle["models"]]
    shown = _chosen(needle, reference)
    pictures = [
        _plot(needle, f"Force, {made['name']}", "force of the hand [N]", lambda group: group["force"][:], models, shown),
        _plot(needle, f"Target, {made['name']}", "way of the target [mm]",
              lambda group: MILLIMETRES * numpy.linalg.norm(group["target"][:], axis=1), models, shown)]
    return _verdict(needle, reference) + figure(
        "figure", plots(pictures), f"Force of the hand and motion of the target over depth, in and out again: of the reference "
        f"and of the {MOST_CURVES} models whose target is nearest to it.", [command])


def _file(data: ReportData, told: dict) -> Markup:
    with data.open(told["file"]) as file, figure_files.about(attributes_of(file)["body"], "needle"):
        made = attributes_of(file)
        html = Markup("").join(_needle(file["needles"][name], made["command"])
                               for name in sorted(file["needles"], key=int))
        html += figure("table", table(table_of(told["table"])),
                       "Where the target is when the tip is where it was, and the forces of the hand.", [made["command"]])
        html += paragraph(told["note"])
    return subsection(f"{made['body']}: {made['title']}", html)


def section(data: ReportData) -> Section | None:
    if not data.told["needles"]:
        return None
    html = paragraph("A needle goes in and out again. What counts is how far the target has moved when the tip is where it "
                     "was, and the force of the hand.")
    for told in data.told["needles"]:
        html += _file(data, told)
    return Section("needles", TITLE, html)
