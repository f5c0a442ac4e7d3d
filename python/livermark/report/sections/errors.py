"""How far each model is off, under each load case."""
from __future__ import annotations

import math
from typing import Optional

from markupsafe import Markup

from livermark.report.data import Column, ReportData, Result, Table, commands_of, not_told_from_best
from livermark.report.parts import Section, figure, missing, paragraph, subsection, table
from livermark.report.reference import OWN_ERROR, of_reference
from livermark.studies.tables import PERCENT, fixed, mean, percent

TITLE = "How far each model is off"
COMMAND = "livermark run"  # makes the files


def _cell(result: Result, name: str) -> str:
    model = result.models.get(name)
    if model is None:
        return "-"
    if model.status != "ok":
        return model.status
    if not model.reference:
        return "ref." if name == result.reference else "not compared"
    if math.isnan(model.relative_l2):
        return "-"  # the reference is at rest
    return percent(model.relative_l2) + (" !" if result.leaves_regime else " *" if model.is_within_uncertainty else "")


def _errors(cases: list[Result], name: str) -> list[float]:
    """Of the load cases that count, those of a model that came through all in which it took part; else none."""
    errors = [result.models[name].error for result in cases if name in result.models and name != result.reference]
    return errors if all(map(math.isfinite, errors)) else []


def _table(data: ReportData, cases: list[Result]) -> Markup:
    """A row for each model, a column for each load case, and the mean over those that count; of what is no finite
    element, what is smallest within the reference's own error is strong."""
    names = [name for name in data.models if any(name in result.models for result in cases)]
    counted = [result for result in cases if result.counts]
    rows, strong, means = [], set(), {}
    for name in names:
        errors = _errors(counted, name)
        cell = percent(mean(errors)) if errors else "-"
        if errors and len(errors) < len(counted):
            cell += f" ({len(errors)} of {len(counted)})"
        elif errors and any(result.models[name].is_spring_model for result in counted):
            means[name] = mean(errors)
        rows.append([name, *(_cell(result, name) for result in cases), cell])
    for c, result in enumerate(cases):
        springs = {model.name: model.error for model in result.models.values()
                   if model.is_spring_model and math.isfinite(model.error) and not result.leaves_regime}
        strong |= {(names.index(name), 1 + c) for name in not_told_from_best(springs, result.reference_error)}
    uncertainty = mean([result.reference_error for result in counted]) if counted else 0.0
    strong |= {(names.index(name), len(cases) + 1) for name in not_told_from_best(means, uncertainty)}
    own = [of_reference(result.reference_error if result.uncertainty else math.nan) for result in cases]
    rows.append([OWN_ERROR, *own, ""])
    columns = [Column("model"), *(Column(result.load_case, True) for result in cases), Column("mean", True)]
    return table(Table(columns, rows), strong)


def _stiffness(value: float, felt: float, sign: str = "+") -> str:
    if not math.isfinite(value):
        return "-"
    return (sign if value > 0.0 else "") + fixed(PERCENT * value, 1) + (" !" if abs(value) > felt else "")


def _sizes(counted: list[Result], name: str) -> list[float]:
    """Of the load cases that count, absolute values of a model that came through all where it took part; else none."""
    models = [result.models[name] for result in counted if name in result.models and name != result.reference]
    if any(model.status != "ok" for model in models):
        return []
    return [abs(model.stiffness) for model in models if math.isfinite(model.stiffness)]


def _tool_table(data: ReportData, cases: list[Result]) -> Optional[Markup]:
    """Stiffness at the tool, a row for each model, a column for each load case that has one, and the mean size over those
    that count; None where none has."""
    cases = [result for result in cases if any(math.isfinite(model.stiffness) for model in result.models.values())]
    if not cases:
        return None
    counted = [result for result in cases if result.counts]
    rows = []
    for name in data.models:
        models = [result.models.get(name) for result in cases]
        if not any(model and model.reference for model in models):
            continue
        found = [model.stiffness if model and model.status == "ok" else math.nan for model in models]
        sizes = _sizes(counted, name)
        cell = _stiffness(mean(sizes), data.smallest_felt_difference, "") if sizes else "-"
        if sizes and len(sizes) < len(counted):
            cell += f" ({len(sizes)} of {len(counted)})"
        rows.append([name, *(_stiffness(value, data.smallest_felt_difference) for value in found), cell])
    known = [(result.uncertainty or {}).get("stiffness_uncertainty", math.nan) for result in cases]
    rows.append([OWN_ERROR, *map(of_reference, known), ""])
    columns = [Column("model"), *(Column(result.load_case, True) for result in cases), Column("mean size", True)]
    return table(Table(columns, rows))


def _remarks(cases: list[Result]) -> Markup:
    html = Markup("")
    for result in cases:
        for remark in result.remarks:
            html += missing(remark)
        for model in result.models.values():
            if model.status != "ok":
                html += missing(f"{result.load_case}, {model.name}: {model.status}: {model.message}")
    unsure = [result.load_case for result in cases if not result.uncertainty]
    if unsure:
        html += missing(f"The reference's own error is not known under {', '.join(unsure)}: it was not solved on "
                        "the refined mesh.", "livermark run, without --reference-on-mesh")
    return html


def section(data: ReportData) -> Section | None:
    if not data.results:
        return None
    html = paragraph(
        f"Error in position at rest. {data.told['reference']} The "
        "smallest error among the springs is in bold type, and so are all that differ from it by less than the "
        "reference's own error; the same goes for means. A star marks a model that is closer to the reference "
        "than that. A load case with motion shows its static start here, which no mean counts. A mean over "
        "some of the load cases has their number behind it, and is not ranked. An exclamation mark behind an error "
        "stands where a load leaves its regime.") + paragraph(
        "Tissue under a tool is a small part of the volume, so it hardly changes this error. " + data.told["tool_legend"])
    for label, cases in data.by_label():
        caption = f"{label}: error of each model under each load case [%], and the reference's own."
        content = figure("table matrix", _table(data, cases), caption, commands_of(cases))
        if at_tool := _tool_table(data, cases):
            content += figure("table matrix", at_tool,
                              f"{label}: stiffness at the tool of each model under each load case that has one [%]; "
                              "positive is too stiff.", commands_of(cases))
        html += subsection(label, content + _remarks(cases))
    return Section("errors", TITLE, html)
