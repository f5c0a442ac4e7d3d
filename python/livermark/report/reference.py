"""What is said of the reference and of its own error: the same words and digits wherever the page says it."""
from __future__ import annotations

import math
import statistics

from livermark.report.data import ReportData, Result
from livermark.studies.tables import PERCENT, fixed

OWN_ERROR = "the reference's own error"


def of_reference(value: float) -> str:
    """An error of the reference itself in percent, with as many digits everywhere; "not known" for NaN."""
    return f"± {fixed(PERCENT * value, 2)}" if math.isfinite(value) else "not known"


def own_error(cases: list[Result]) -> float:
    """In position, the median over load cases; NaN unless it is known in each of them that compares."""
    compared = [result for result in cases if result.reference]
    known = [result.reference_error for result in compared if result.uncertainty]
    return statistics.median(known) if known and len(known) == len(compared) else math.nan


def own_error_at_tool(cases: list[Result]) -> float:
    """Of the stiffness at the tool, the median over the load cases in which it is known; NaN where in none."""
    known = [(result.uncertainty or {}).get("stiffness_uncertainty", math.nan) for result in cases]
    return statistics.median([value for value in known if math.isfinite(value)] or [math.nan])


def own_error_sentence(cases: list[Result]) -> str:
    """Empty where nothing is compared."""
    if not any(result.reference for result in cases):
        return ""
    error, at_tool = own_error(cases), own_error_at_tool(cases)
    if not math.isfinite(error):
        return "The reference's own error is not known."
    tail = f" and {of_reference(at_tool)} % under the tool" if math.isfinite(at_tool) else ""
    return f"The reference's own error is {of_reference(error)} % in position{tail}."


def lead(data: ReportData) -> str:
    """What the report is about, in a sentence that promises no more of the reference than its figures have."""
    compared = [result for result in [*data.results, *data.large] if result.reference]
    known = sum(1 for result in compared if result.uncertainty)
    text = "How far models of soft tissue are from finite elements"
    if not compared:
        return text + "."
    if known == 0:
        return text + ", whose own error is not known."
    if known < len(compared):
        return text + f", whose own error is known in {known} of {len(compared)} results."
    groups = {(result.label, result in data.large): [] for result in compared}
    for result in compared:
        groups[result.label, result in data.large].append(result)
    found = sorted(error for cases in groups.values() if math.isfinite(error := own_error([case for case in cases if case.counts])))
    if not found:
        return text + " whose own error is known."
    ends = " to ".join(dict.fromkeys(fixed(PERCENT * error, 2) for error in (found[0], found[-1])))
    return text + f" whose own error is known: ± {ends} % of how far a body moves."
