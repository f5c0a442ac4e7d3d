"""What stands above the sections: the result in short, and where it comes from."""
from __future__ import annotations

import math

from markupsafe import Markup

from livermark.report.data import Column, ReportData, Result, Table
from livermark.report.parts import figure, table
from livermark.report.units import PERCENT, fixed, mean, percent


def _mean_of_all(values: list[float], num_cases: int) -> str:
    """A mean that is one over all load cases, or "-"."""
    return percent(mean(values)) if values and len(values) >= num_cases else "-"


def _row(label: str, cases: list[Result]) -> list[str]:
    springs: dict[str, list[float]] = {}
    stiffness: dict[str, list[float]] = {}
    baseline = []
    for result in cases:
        for model in result.models.values():
            if math.isfinite(model.error):
                if model.is_spring_model:
                    springs.setdefault(model.name, []).append(model.error)
                    if math.isfinite(model.stiffness):
                        stiffness.setdefault(model.name, []).append(abs(model.stiffness))
                elif model.name == "fem_p1":
                    baseline.append(model.error)
    uncertainties = [result.uncertainty["reference_uncertainty"] for result in cases if result.uncertainty]
    of_all = {name: mean(errors) for name, errors in sorted(springs.items()) if len(errors) == len(cases)}
    best = min(of_all, key=of_all.__getitem__, default=None)
    return [label, str(len(cases)), best or "none solved every load case", percent(of_all[best]) if best else "-",
            fixed(PERCENT * mean(stiffness[best]), 1) if best in stiffness else "-",
            _mean_of_all(baseline, len(cases)), _mean_of_all(uncertainties, len(cases))]


def findings(data: ReportData) -> Markup:
    """A row for each body: the springs that are best in the mean, of those that came through every load case."""
    if not data.results:
        return Markup("")
    columns = [Column("body"), Column("load cases", True), Column("nearest springs"), Column("mean error [%]", True),
               Column("at the tool [%]", True),
               Column("of linear finite elements [%]", True), Column("uncertainty of the reference [%]", True)]
    rows = [_row(label, cases) for label, cases in data.by_label()]
    return figure("table", table(Table(columns, rows)), "In short: means over the load cases of each body.")


def facts(data: ReportData) -> list[tuple[str, str]]:
    told = data.told
    found = [("Files", f"{len(data.results) + len(data.large)} of runs, {len(told['cohorts'])} of cohorts, "
              f"{len(told['arenas'])} of arenas, {len(told['stability'])} of stability, {len(told['histories'])} of histories, "
              f"{len(told['timings'])} of timings")]
    found += [("Left out", fault) for fault in data.faults]
    if data.results:
        made = max(data.results, key=lambda result: result.provenance["created"]).provenance
        found += [("Newest run", f"{made['created']}, livermark {made['software_version']}, commit {made['git_commit']}"),
                  ("Machine", f"{made['cpu']}, {made['threads']} threads, {made['compiler']}, {made['build_type']}")]
    return found
