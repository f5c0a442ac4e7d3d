"""What an answer is worth: errors of mesh, models and law beside not knowing the patient."""
from __future__ import annotations

import math

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, cleaned
from livermark.report.parts import Section, bullets, figure, paragraph, plots, subsection, table
from livermark.studies.sensitivity.record import Sensitivity, read_whole
from livermark.studies.sensitivity.tables import budget_table, index_table, output_table
from livermark.studies.tables import PERCENT, Column, Table, fixed

TITLE = "What an answer is worth"
COMMAND = "livermark sensitivity BODY --output FOLDER"  # makes the files


def _shown(name: str) -> str:
    return name.replace("_", " ")


def _verdict(found: Sensitivity) -> Markup:
    """Of each output whether models or the patient make it more uncertain, and what to measure first."""
    sentences = []
    for o, output in enumerate(found.outputs):
        spread, left = output.relative_deviation(), output.relative_deviation(output.leading)
        errors = {model: abs(error[o]) for model, error in found.budget.models.items() if math.isfinite(error[o])}
        larger = [cleaned(model) for model, error in errors.items() if error > spread]
        text = (f"The patient makes the {_shown(cleaned(output.name))} uncertain by {fixed(PERCENT * spread, 1)} %; if the "
                f"{_shown(cleaned(found.parameters[output.leading].name))} were known, {fixed(PERCENT * left, 1)} % would be left. ")
        if larger:
            text += f"Off by more than that: {', '.join(larger)}."
        elif errors:
            worst = max(errors, key=errors.get)
            text += (f"No model is off by more than that; the worst is {cleaned(worst)}, with "
                     f"{fixed(PERCENT * errors[worst], 1)} %.")
        sentences.append(text)
    return bullets(sentences)


def _rows(found: Sensitivity, o: int) -> list[tuple[str, float, str]]:
    """Name, size and colour of what makes an output uncertain, without what is not known or does not apply."""
    output, budget = found.outputs[o], found.budget
    rows = [("mesh", budget.mesh[o], colours.GREYS[2])]
    rows += [(cleaned(model), abs(error[o]), colours.BLUE) for model, error in budget.models.items()]
    rows += [("law", abs(budget.law[o]), colours.GREYS[2]), ("measurement", budget.measurement[o], colours.GREYS[2])]
    rows += [(f"patient: {cleaned(group)}", output.relative_deviation_of_group(g), colours.ORANGE)
             for g, group in enumerate(found.groups)]
    rows.append(("patient", output.relative_deviation(), colours.VERMILION))
    return [row for row in rows if math.isfinite(row[1])]


def _budget_plot(found: Sensitivity, o: int) -> Markup:
    rows = _rows(found, o)[::-1]
    axes = figures.new_rows(_shown(cleaned(found.outputs[o].name)), "uncertain by [%]", [row[0] for row in rows], 460, 22)
    with matplotlib.rc_context(figures.SETTINGS):
        axes.barh(range(len(rows)), [PERCENT * row[1] for row in rows], height=0.66, color=[row[2] for row in rows])
        axes.set_xlim(left=0.0)
        axes.grid(False, axis="y")
    return figures.finish(axes)


def _cleaned_table(made: Table) -> Markup:
    return table(Table([Column(cleaned(column.title), column.is_number) for column in made.columns], cleaned(made.rows)))


def _file(data: ReportData, name: str) -> Markup:
    with data.open(name) as file:
        found = read_whole(data.folder / name, file)
    command = cleaned(found.provenance["command"])
    html = _verdict(found)
    with figure_files.about(cleaned(found.body), "sensitivity"):
        drawn = [_budget_plot(found, o) for o in range(len(found.outputs))]
    html += figure("figure", plots(drawn),
                   "What makes each answer uncertain: the mesh of the reference, errors of models (blue), law and measurement, and "
                   f"the patient (red; orange: each group of parameters alone). {len(found.values)} patients, "
                   f"solved by {cleaned(found.model)}.", [command])
    html += figure("table", _cleaned_table(output_table(found)), "Each answer over the patients.", [command])
    html += figure("table", _cleaned_table(index_table(found)),
                   "Sobol indices with intervals of 95 %: the part of the variance that would go if a parameter were known "
                   "(first), and that would stay if all others were (total).", [command])
    html += figure("table", _cleaned_table(budget_table(found)),
                   "The error budget [%]. Errors of models are signed, all else is a size.", [command])
    return subsection(cleaned(f"{found.body}: {found.title}"), html)


def section(data: ReportData) -> Section | None:
    if not data.told["sensitivities"]:
        return None
    html = paragraph("Nobody knows a patient's stiffness, support and the place of the tool exactly. That makes an answer "
                     "uncertain, whatever model gives it, and stands here beside the errors of models.")
    for name in data.told["sensitivities"]:
        html += _file(data, name)
    return Section("sensitivity", TITLE, html)
