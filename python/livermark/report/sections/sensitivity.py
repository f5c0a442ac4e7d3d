"""What an answer is worth: errors of mesh, models and law beside not knowing the patient."""
from __future__ import annotations

import math

import matplotlib
import numpy
from markupsafe import Markup

from livermark.report import colours, figures
from livermark.report.data import ReportData, attributes_of, table_of, texts_of
from livermark.report.parts import Section, bullets, figure, paragraph, plots, subsection, table
from livermark.report.units import PERCENT, fixed

TITLE = "What an answer is worth"
COMMAND = "livermark sensitivity BODY --output FOLDER"  # makes the files


def _spread(outputs) -> numpy.ndarray:
    """(O) standard deviation over mean of each output over the patients"""
    return outputs["deviation"][:] / numpy.abs(outputs["mean"][:])


def _shown(name: str) -> str:
    return name.replace("_", " ")


def _verdict(sensitivity) -> Markup:
    """Of each output whether models or the patient make it more uncertain, and what to measure first."""
    outputs, budget = sensitivity["outputs"], sensitivity["budget"]
    parameters, models = texts_of(sensitivity["parameters"], "names"), texts_of(budget, "models")
    sentences = []
    for o, name in enumerate(texts_of(outputs, "names")):
        spread, first = float(_spread(outputs)[o]), outputs["first"][o]
        leading = int(numpy.argmax(first))
        left = spread * math.sqrt(max(0.0, 1.0 - first[leading]))
        errors = {model: abs(float(error)) for model, error in zip(models, budget["error"][:, o]) if math.isfinite(error)}
        larger = [model for model, error in errors.items() if error > spread]
        text = (f"The patient makes the {_shown(name)} uncertain by {fixed(PERCENT * spread, 1)} %; if the {_shown(parameters[leading])}"
                f" were known, {fixed(PERCENT * left, 1)} % would be left. ")
        if larger:
            text += f"Off by more than that: {', '.join(larger)}."
        elif errors:
            worst = max(errors, key=errors.get)
            text += f"No model is off by more than that; the worst is {worst}, with {fixed(PERCENT * errors[worst], 1)} %."
        sentences.append(text)
    return bullets(sentences)


def _rows(sensitivity, o: int) -> list[tuple[str, float, str]]:
    """Name, size and colour of what makes an output uncertain, without what is not known or does not apply."""
    outputs, budget = sensitivity["outputs"], sensitivity["budget"]
    spread = float(_spread(outputs)[o])
    rows = [("mesh", float(budget["mesh"][o]), colours.GREYS[2])]
    rows += [(model, abs(float(error)), colours.BLUE) for model, error in zip(texts_of(budget, "models"), budget["error"][:, o])]
    rows += [("law", abs(float(budget["law"][o])), colours.GREYS[2]),
             ("measurement", float(budget["measurement"][o]), colours.GREYS[2])]
    rows += [(f"patient: {group}", spread * math.sqrt(total), colours.ORANGE)
             for group, total in zip(attributes_of(sensitivity)["groups"], outputs["group_total"][o])]
    rows.append(("patient", spread, colours.VERMILION))
    return [row for row in rows if math.isfinite(row[1])]


def _budget_plot(sensitivity, o: int, name: str) -> Markup:
    rows = _rows(sensitivity, o)[::-1]
    axes = figures.new_rows(_shown(name), "uncertain by [%]", [row[0] for row in rows], 460, 22)
    with matplotlib.rc_context(figures.SETTINGS):
        axes.barh(range(len(rows)), [PERCENT * row[1] for row in rows], height=0.66, color=[row[2] for row in rows])
        axes.set_xlim(left=0.0)
        axes.grid(False, axis="y")
    return figures.finish(axes)


def _file(data: ReportData, told: dict) -> Markup:
    with data.open(told["file"]) as file:
        command, sensitivity = attributes_of(file)["command"], file["sensitivity"]
        made = attributes_of(sensitivity)
        names = texts_of(sensitivity["outputs"], "names")
        html = _verdict(sensitivity)
        html += figure("figure", plots([_budget_plot(sensitivity, o, name) for o, name in enumerate(names)]),
                       "What makes each answer uncertain: the mesh of the reference, errors of models (blue), law and measurement, and "
                       f"the patient (red; orange: each group of parameters alone). {len(sensitivity['samples/values'])} patients, "
                       f"solved by {made['model']}.", [command])
        html += figure("table", table(table_of(told["outputs"])), "Each answer over the patients.", [command])
        html += figure("table", table(table_of(told["indices"])),
                       "Sobol indices with intervals of 95 %: the part of the variance that would go if a parameter were known "
                       "(first), and that would stay if all others were (total).", [command])
        html += figure("table", table(table_of(told["budget"])),
                       "The error budget [%]. Errors of models are signed, all else is a size.", [command])
    return subsection(f"{made['body']}: {made['title']}", html)


def section(data: ReportData) -> Section | None:
    if not data.told["sensitivities"]:
        return None
    html = paragraph("Nobody knows a patient's stiffness, support and the place of the tool exactly. That makes an answer "
                     "uncertain, whatever model gives it, and stands here beside the errors of models.")
    for told in data.told["sensitivities"]:
        html += _file(data, told)
    return Section("sensitivity", TITLE, html)
