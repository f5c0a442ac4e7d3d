"""What the record of a sensitivity study says, as tables, as sentences and as JSON."""
from __future__ import annotations

import json
import math
from typing import Any

from livermark.studies.sensitivity.ranges import Parameter
from livermark.studies.sensitivity.record import INDICES, NUMBERS, Output, Sensitivity
from livermark.studies.tables import MILLIMETRES, PERCENT, Column, Table, fixed, printable, significant

CLEARLY = 3.0  #: times smaller an error is small beside an uncertainty: it adds less than 6 % to their root of squares
WORDS = {"stiffness_at_tool": "the stiffness at the tool", "tumour_displacement": "the place of the tumour"}
LEGEND = (
    "patient: standard deviation over the mean of the samples; the columns before it are what its groups do, "
    "with what they do together with others. mesh: error bar of the reference. Models: signed error; that of "
    "the place of a tumour is a length. law: Ogden's over the neo-Hookean law at the whole load of "
    "large_<load case>. measurement: noise of a measured displacement. -: unknown, or does not apply.")


def _percent(part: float) -> str:
    return fixed(PERCENT * part, 1)


def _signed_percent(part: float) -> str:
    return f"{PERCENT * part:+.1f}" if math.isfinite(part) else "-"


def _index(value: float, lower: float, upper: float) -> str:
    return f"{fixed(value, 3)} [{fixed(lower, 3)}, {fixed(upper, 3)}]"


def _range(parameter: Parameter) -> str:
    scale, unit = (MILLIMETRES, "mm") if parameter.unit == "m" else (1.0, parameter.unit)
    return (f"{scale * parameter.lower:g} to {scale * parameter.upper:g}{' ' + unit if unit else ''}"
            f"{', logarithmic' if parameter.is_logarithmic else ''}")


def output_table(found: Sensitivity) -> Table:
    """A row for each output: its value as the files have it, mean and standard deviation of the samples, between which values
    95 % of them are, and the part of the variance that the polynomial misses. Stiffness [N/m], displacements [mm]."""
    columns = [Column("output"), *(Column(title, True) for title in (
        "as the files say", "mean", "deviation", "95 % from", "to", "not explained [%]"))]
    rows = []
    for output in found.outputs:
        is_length = output.unit == "m"
        rows.append([f"{output.name} [{'mm' if is_length else output.unit}]",
                     *(fixed(MILLIMETRES * value, 3) if is_length else significant(value, 4) for value in
                       (output.nominal, output.mean, output.deviation, output.lower, output.upper)),
                     _percent(output.unexplained)])
    return Table(columns, rows)


def index_table(found: Sensitivity) -> Table:
    """A row for each parameter: its range, and of each output the first-order and the total Sobol index with intervals."""
    columns = [Column("parameter"), Column("range")]
    for output in found.outputs:
        columns += [Column(output.name + ": first", True), Column("total", True)]
    rows = [[parameter.name, _range(parameter)] for parameter in found.parameters]
    for output in found.outputs:
        for p, row in enumerate(rows):
            row.append(_index(output.first[p], output.first_lower[p], output.first_upper[p]))
            row.append(_index(output.total[p], output.total_lower[p], output.total_upper[p]))
    return Table(columns, rows)


def budget_table(found: Sensitivity) -> Table:
    """A row for each output [%]: mesh, law, measurement, the error of each model, and what the patient makes uncertain: each
    group of parameters alone, all together, and all but the most important parameter. Errors of models are signed, all else
    is a size; uncertainties of the patient are standard deviations over the mean."""
    budget, groups = found.budget, found.groups
    titles = ["mesh", *budget.models, "law, large", "measurement", *groups, "patient", "leading parameter known"]
    rows = []
    for o, output in enumerate(found.outputs):
        rest = _percent(output.relative_deviation(output.leading))
        rows.append([found.load_case, output.name, _percent(budget.mesh[o]),
                     *(_signed_percent(errors[o]) for errors in budget.models.values()), _signed_percent(budget.law[o]),
                     _percent(budget.measurement[o]),
                     *(_percent(output.relative_deviation_of_group(g)) for g in range(len(groups))),
                     _percent(output.relative_deviation()), f"{rest} ({found.parameters[output.leading].name})"])
    return Table([Column("load case"), Column("output"), *(Column(title, True) for title in titles)], rows)


def _size_beside(error: float, uncertainty: float) -> str:
    if CLEARLY * error <= uncertainty:
        return "small"
    return "large" if error >= CLEARLY * uncertainty else "of the same size"


def largest_error(found: Sensitivity, o: int, model: str) -> float:
    """|model| + mesh + |law| of an output: the largest error of a model for tissue of either law, as a part of the output.

    The error of a model has a sign, so it is no uncertainty and is added (ASME V&V 20). The error bar of the mesh and the
    difference of the laws may have either sign, so the largest error is their sum with it. What is not known is left out."""
    budget = found.budget
    return sum(abs(part) for part in (budget.models[model][o], budget.mesh[o], budget.law[o]) if math.isfinite(part))


def _added(found: Sensitivity, o: int, model: str) -> str:
    names = [name for name, part in (("the error bar of the mesh", found.budget.mesh[o]), ("another law", found.budget.law[o]))
             if math.isfinite(part)]
    return (f" With {' and '.join(names)} it is off by {PERCENT * largest_error(found, o, model):.1f} % at most."
            if names else "")


def verdict(found: Sensitivity, o: int) -> str:
    """Whether the error of the first compared model is large or small beside not knowing the patient, and what it is at most
    with those of mesh and law."""
    output: Output = found.outputs[o]
    patient, rest = output.relative_deviation(), output.relative_deviation(output.leading)
    model, errors = next(iter(found.budget.models.items()))
    sentence = (f"{found.name}: not knowing the patient makes {PERCENT * patient:.1f} % of "
                f"{WORDS.get(output.name, 'the peak displacement')} uncertain, and {PERCENT * rest:.1f} % if "
                f"{found.parameters[output.leading].name} were known; {model} ")
    error = abs(errors[o])
    if not math.isfinite(error):
        return sentence + "has no answer to compare."
    first, second = _size_beside(error, patient), _size_beside(error, rest)
    judged = f"{first} beside both" if first == second else f"{first} beside the first and {second} beside the second"
    return sentence + f"is off by {PERCENT * error:.1f} %, which is {judged}.{_added(found, o, model)}"


def shown(found: Sensitivity, in_markdown: bool) -> str:
    text = f"{found.name}: {printable(found.title)}\n\n"
    for title, table in ((f"{len(found.values)} patients, solved by {found.model}", output_table(found)),
                         ("Sobol indices, first order and total, with intervals of 95 %", index_table(found)),
                         (f"Error budget [%], models against {found.budget.reference}", budget_table(found))):
        text += f"{title}:\n" + ("\n" + table.markdown() if in_markdown else table.text()) + "\n"
    return text + "".join(printable(verdict(found, o)) + "\n" for o in range(len(found.outputs))) + "\n"


def _as_json(found: Sensitivity) -> dict[str, Any]:
    def by_output(values: list[float]) -> dict[str, float]:
        return {output.name: value for output, value in zip(found.outputs, values) if math.isfinite(value)}
    budget = found.budget
    return {"body": found.body, "load_case": found.load_case, "model": found.model, "samples": len(found.values),
            "parameters": [{"name": each.name, "unit": each.unit, "group": each.group, "lower": each.lower, "upper": each.upper,
                            "logarithmic": each.is_logarithmic, "source": each.source} for each in found.parameters],
            "groups": found.groups,
            "outputs": [{name: getattr(output, name) for name in ("name", "unit", *NUMBERS, *INDICES, "group_total")}
                        for output in found.outputs],
            "budget": {"reference": budget.reference, "mesh": by_output(budget.mesh), "law": by_output(budget.law),
                       "measurement": by_output(budget.measurement),
                       "models": [{"name": name, "error": by_output(errors)} for name, errors in budget.models.items()]},
            "verdicts": [verdict(found, o) for o in range(len(found.outputs))]}


def to_json(all_found: list[Sensitivity]) -> str:
    """SI units; what is not a number is left out."""
    return json.dumps({"load_cases": [_as_json(found) for found in all_found]}, indent=4, sort_keys=True,
                      separators=(",", " : "), ensure_ascii=False)
