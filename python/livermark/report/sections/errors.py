"""How far each model is off, under each load case."""
from __future__ import annotations

import math
from typing import Optional

from markupsafe import Markup

from livermark.report.data import Column, ReportData, Result, Table, commands_of
from livermark.report.parts import Section, figure, missing, paragraph, subsection, table
from livermark.report.units import PERCENT, fixed, mean, percent

TITLE = "How far each model is off"


def _cell(result: Result, name: str) -> str:
    model = result.models.get(name)
    if model is None:
        return "-"
    if model.status != "ok":
        return model.status
    if not model.reference:
        return "ref." if name == result.reference else "not compared"
    return percent(model.relative_l2) + (" *" if model.is_within_uncertainty else "")


def _mean(cases: list[Result], name: str) -> Optional[float]:
    """Of a model that came through all load cases."""
    errors = [result.models[name].error for result in cases if name in result.models]
    return mean(errors) if len(errors) == len(cases) and all(map(math.isfinite, errors)) else None


def _table(data: ReportData, cases: list[Result]) -> Markup:
    """A row for each model, a column for each load case, and the mean of those that came through all; the smallest of
    what is no finite element is strong."""
    names = [name for name in data.models if any(name in result.models for result in cases)]
    rows, strong, means = [], set(), {}
    for r, name in enumerate(names):
        found = _mean(cases, name)
        rows.append([name, *(_cell(result, name) for result in cases), "-" if found is None else percent(found)])
        strong |= {(r, 1 + c) for c, result in enumerate(cases)
                   if result.best_springs and result.best_springs.name == name}
        if found is not None and any(result.models[name].is_spring_model for result in cases):
            means[r] = found
    if means:
        strong.add((min(means, key=means.__getitem__), len(cases) + 1))
    uncertainties = ["± " + percent(result.uncertainty["reference_uncertainty"]) if result.uncertainty else "not known"
                     for result in cases]
    rows.append(["uncertainty of the reference", *uncertainties, ""])
    columns = [Column("model"), *(Column(result.load_case, True) for result in cases), Column("mean", True)]
    return table(Table(columns, rows), strong)


def _stiffness(value: float, felt: float, sign: str = "+") -> str:
    if not math.isfinite(value):
        return "-"
    return (sign if value > 0.0 else "") + fixed(PERCENT * value, 1) + (" !" if abs(value) > felt else "")


def _tool_table(data: ReportData, cases: list[Result]) -> Optional[Markup]:
    """Stiffness at the tool, a row for each model and a column for each load case that has one; None where none has."""
    cases = [result for result in cases if any(math.isfinite(model.stiffness) for model in result.models.values())]
    if not cases:
        return None
    rows = []
    for name in data.models:
        models = [result.models.get(name) for result in cases]
        if not any(model and model.reference for model in models):
            continue
        found = [model.stiffness if model and model.status == "ok" else math.nan for model in models]
        sizes = [abs(value) for value in found if math.isfinite(value)]
        rows.append([name, *(_stiffness(value, data.smallest_felt_difference) for value in found),
                     _stiffness(mean(sizes), data.smallest_felt_difference, "") if sizes else "-"])
    known = [(result.uncertainty or {}).get("stiffness_uncertainty", math.nan) for result in cases]
    rows.append(["uncertainty of the reference",
                 *(f"± {PERCENT * value:.1f}" if math.isfinite(value) else "not known" for value in known), ""])
    columns = [Column("model"), *(Column(result.load_case, True) for result in cases), Column("mean size", True)]
    return table(Table(columns, rows))


def _remarks(cases: list[Result]) -> Markup:
    html = Markup("")
    for result in cases:
        for model in result.models.values():
            if model.status != "ok":
                html += missing(f"{result.load_case}, {model.name}: {model.status}: {model.message}")
    unsure = [result.load_case for result in cases if not result.uncertainty]
    if unsure:
        html += missing(f"The uncertainty of the reference is unknown under {', '.join(unsure)}: it was not solved on the "
                        "refined mesh.", "livermark run, without --no-uncertainty")
    return html


def section(data: ReportData) -> Section:
    if not data.results:
        return Section("errors", TITLE, missing("There are no result files of small deformations here.", "livermark run"))
    html = paragraph(
        "Relative L2 error of the displacement at rest against the reference, weighted by nodal volume. The smallest error "
        "among the springs is in bold type, and so is their smallest mean. A star marks a model that is closer to the "
        "reference than the uncertainty of the reference: such models are not ranked. A load case with motion shows its "
        "static start here.") + paragraph(
        "Tissue under a tool is a small part of the volume, so this error hardly sees it. " + data.told["tool_legend"])
    for label, cases in data.by_label():
        caption = f"{label}: error of each model under each load case [%], and uncertainty of the reference."
        content = figure("table matrix", _table(data, cases), caption, commands_of(cases))
        if at_tool := _tool_table(data, cases):
            content += figure("table matrix", at_tool,
                              f"{label}: stiffness at the tool of each model under each load case that has one [%]; positive "
                              "is too stiff.", commands_of(cases))
        html += subsection(label, content + _remarks(cases))
    return Section("errors", TITLE, html)
