"""What stands above the sections: the result in short, and where it comes from."""
from __future__ import annotations

import math

from markupsafe import Markup

from livermark.report.data import Column, ReportData, Result, Table, not_told_from_best
from livermark.report.parts import figure, table
from livermark.report.units import PERCENT, fixed, mean, percent


def _mean_of_all(values: list[float], num_cases: int) -> str:
    """A mean that is one over all load cases, or "-"."""
    return percent(mean(values)) if values and len(values) >= num_cases else "-"


def _row(label: str, cases: list[Result]) -> list[str]:
    springs: dict[str, list[float]] = {}
    stiffness: dict[str, list[float]] = {}
    baseline = []
    cases = [result for result in cases if result.counts]
    for result in cases:
        for model in result.models.values():
            if math.isfinite(model.error):
                if model.is_spring_model:
                    springs.setdefault(model.name, []).append(model.error)
                    if math.isfinite(model.stiffness):
                        stiffness.setdefault(model.name, []).append(abs(model.stiffness))
                elif model.name == "fem_p1":
                    baseline.append(model.error)
    uncertainties = [result.reference_error for result in cases if result.uncertainty]
    of_all = {name: mean(errors) for name, errors in sorted(springs.items()) if len(errors) == len(cases)}
    best = not_told_from_best(of_all, mean([result.reference_error for result in cases])) if of_all else []
    best.sort(key=of_all.__getitem__)
    return [label, str(len(cases)), ", ".join(best) or "none solved every load case",
            ", ".join(percent(of_all[name]) for name in best) or "-",
            ", ".join(fixed(PERCENT * mean(stiffness[name]), 1) if name in stiffness else "-" for name in best) or "-",
            _mean_of_all(baseline, len(cases)), _mean_of_all(uncertainties, len(cases))]


def findings(data: ReportData) -> Markup:
    """A row for each body: the springs that are best in the mean, of those that came through every load case that
    counts; several where they differ by less than the uncertainty of the reference."""
    if not data.results:
        return Markup("")
    columns = [Column("body"), Column("load cases", True), Column("nearest springs"), Column("mean error [%]", True),
               Column("at the tool [%]", True),
               Column("of linear finite elements [%]", True), Column("uncertainty of the reference [%]", True)]
    rows = [_row(label, cases) for label, cases in data.by_label()]
    return figure("table", table(Table(columns, rows)), "In short: means over the static load cases of each body. "
                  + data.told["reference"])


def lead(data: ReportData) -> str:
    """What the report is about, in a sentence."""
    if data.has_no_results:
        return "Deformable models beside measurements of real bodies, needles in bodies, and what is not known of a patient."
    return ("The errors of mass-spring models against a finite element reference, their cost, and their longest stable time "
            "steps.")


def facts(data: ReportData) -> list[tuple[str, str]]:
    told = data.told
    found = [("Files", f"{len(data.results) + len(data.large)} of runs, {len(told['cohorts'])} of cohorts, "
              f"{len(told['arenas'])} of arenas, {len(told['stability'])} of stability, {len(told['histories'])} of histories, "
              f"{len(told['timings'])} of timings, {len(told['experiments'])} of experiments, {len(told['needles'])} of needles, "
              f"{len(told['sensitivities'])} of sensitivities")]
    found += [("Left out", fault) for fault in data.faults]
    if data.results:
        made = max(data.results, key=lambda result: result.provenance["created"]).provenance
        found += [("Newest run", f"{made['created']}, livermark {made['software_version']}, commit {made['git_commit']}"),
                  ("Machine", f"{made['cpu']}, {made['threads']} threads, {made['compiler']}, {made['build_type']}")]
    return found
