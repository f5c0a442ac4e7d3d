"""What `livermark sensitivity` asks: python3 -m livermark.studies.sensitivity plan|keep|finish|show

The program solves, and gives and gets TOML on standard input and output.

plan: ranges, samples, model and provenance, and of each [[case]] body, load_case, title, fingerprint, file, outputs and what
    acting_on() looks at. Answers with notes, and of each [[case]] the names of its parameters, points (S P) [SI] and the
    values (K O) of samples that its file has, and state, which the other parts take.
keep: state and values (K O). Writes the file with what is solved so far.
finish: state, values (S O), a table budget with reference, relative_l2 and stiffness, the error bars of the reference, and
    lists of answers, values (O) and tumour (3) by name: nominal, models, law. Writes the whole file, and answers with notes.
show: files, and format, text, markdown or json. Answers with what the program prints.
"""
from __future__ import annotations

import json
import math
import pathlib
import sys
import tomllib
from typing import Any

import numpy

from livermark.errors import InputError
from livermark.hdf5_files import open_hdf5
from livermark.studies import to_toml
from livermark.studies.sensitivity import tables
from livermark.studies.sensitivity.ranges import Parameter, acting_on, read_ranges
from livermark.studies.sensitivity.record import Budget, Output, Sensitivity, is_sensitivity, read, read_whole, write

UNITS = {"stiffness_at_tool": "N/m", "peak_displacement": "m", "tumour_displacement": "m"}
TAIL = 0.025  #: of the samples on each side of the 95 % that are given


def least_samples(num_parameters: int) -> int:
    """The fewest samples from which indices are estimated: twice the terms of a linear polynomial."""
    return 2 * (num_parameters + 1)


def kept_values(found: Sensitivity, path: pathlib.Path, num_outputs: int) -> list[list[float]]:
    """The values of a file that went the same way before, as far as it came."""
    if not is_sensitivity(path):
        return []
    before = read(path)
    if before.fingerprint != found.fingerprint or before.parameters != found.parameters or len(before.values[0]) != num_outputs:
        return []
    kept = []
    for point, earlier, values in zip(found.points, before.points, before.values):
        if point != earlier:
            break
        kept.append(values)
    return kept


def plan(asked: dict[str, Any]) -> dict[str, Any]:
    ranges, samples = read_ranges(pathlib.Path(asked["ranges"])), asked["samples"]
    acting = [acting_on(case, ranges) for case in asked["case"]]
    for parameters, _ in acting:
        if samples < least_samples(len(parameters)):
            raise InputError(f"--samples {samples}: {len(parameters)} parameters need at least {least_samples(len(parameters))}")
    from livermark.studies.sensitivity.sobol import sobol_points  # which needs OpenTURNS
    cases = []
    for case, (parameters, _) in zip(asked["case"], acting):
        unit_points = sobol_points(samples, len(parameters)).tolist()
        points = [[parameter.at(share) for parameter, share in zip(parameters, unit)] for unit in unit_points]
        found = Sensitivity(asked["provenance"], case["body"], case["load_case"], case["title"], asked["model"],
                            case["fingerprint"], parameters, points, [])
        values = kept_values(found, pathlib.Path(case["file"]), len(case["outputs"]))
        state = {**{name: getattr(found, name) for name in ("provenance", "body", "load_case", "title", "model", "fingerprint")},
                 "parameters": [vars(parameter) for parameter in parameters], "points": points, "unit_points": unit_points,
                 "file": case["file"], "outputs": case["outputs"], "displacement_noise": ranges.displacement_noise}
        cases.append({"parameters": [parameter.name for parameter in parameters], "points": numpy.ravel(points).tolist(),
                      "values": numpy.ravel(values).tolist(), "state": json.dumps(state)})
    return {"notes": [note for _, notes in acting for note in notes], "case": cases}


def _state(asked: dict[str, Any]) -> tuple[Sensitivity, dict[str, Any]]:
    state = json.loads(asked["state"])
    values = numpy.reshape(asked["values"], (-1, len(state["outputs"]))).tolist()
    return Sensitivity(*(state[name] for name in ("provenance", "body", "load_case", "title", "model", "fingerprint")),
                       parameters=[Parameter(**each) for each in state["parameters"]], points=state["points"],
                       values=values), state


def keep(asked: dict[str, Any]) -> dict[str, Any]:
    found, state = _state(asked)
    write(pathlib.Path(state["file"]), found)
    return {}


def add_indices(found: Sensitivity, names: list[str], unit_points: list[list[float]]) -> list[str]:
    """Statistics and indices of the samples that have a solution. Returns sentences that a user should know."""
    from livermark.studies.sensitivity.sobol import sobol_indices
    values = numpy.array(found.values)
    solved = numpy.isfinite(values).all(axis=1)
    points, notes = numpy.array(unit_points)[:len(values)][solved], []
    if not solved.all():
        notes.append(f"{found.name}: {(~solved).sum()} of {len(values)} samples have no solution by {found.model} and are left out")
    if solved.sum() < least_samples(len(found.parameters)):
        raise InputError(f"{found.name}: {found.model} finds a solution to {solved.sum()} samples only, which are too few for "
                         "indices; choose another model")
    groups = [[p for p, parameter in enumerate(found.parameters) if parameter.group == group] for group in found.groups]
    for name, column in zip(names, values[solved].T):
        column = numpy.ascontiguousarray(column)
        lower, upper = numpy.quantile(column, (TAIL, 1.0 - TAIL))
        found.outputs.append(Output(name, UNITS[name], mean=float(column.mean()), deviation=float(column.std(ddof=1)),
                                    lower=float(lower), upper=float(upper), **sobol_indices(points, column, groups)))
    return notes


def relative_differences(names: list[str], answer: dict[str, Any], reference: dict[str, Any]) -> list[float]:
    """Of answers, relative to others: signed, but for the place of a tumour the length of the difference."""
    differences = []
    with numpy.errstate(divide="ignore", invalid="ignore"):
        for o, name in enumerate(names):
            if name == "tumour_displacement":
                difference = numpy.subtract(answer["tumour"], reference["tumour"])
                differences.append(float(numpy.linalg.norm(difference) / numpy.linalg.norm(reference["tumour"])))
            else:
                differences.append(float(numpy.float64(answer["values"][o]) / reference["values"][o] - 1.0))
    return differences


def add_budget(found: Sensitivity, names: list[str], given: dict[str, Any], noise: float | None) -> None:
    nominal = given["nominal"]
    for output, value in zip(found.outputs, nominal["values"]):
        output.nominal = value
    budget = Budget(given["reference"])
    for name, value in zip(names, nominal["values"]):
        is_stiffness = name == "stiffness_at_tool"
        budget.mesh.append(given["stiffness"] if is_stiffness else given["relative_l2"])
        budget.measurement.append(math.nan if is_stiffness or noise is None else noise / (value or math.nan))
    law = given["law"]  # of the reference, and the other one
    budget.law = relative_differences(names, law[1], law[0]) if law else [math.nan] * len(names)
    for model in given["models"]:
        budget.models[model["name"]] = relative_differences(names, model, nominal)
    found.budget = budget


def finish(asked: dict[str, Any]) -> dict[str, Any]:
    found, state = _state(asked)
    notes = add_indices(found, state["outputs"], state["unit_points"])
    add_budget(found, state["outputs"], asked["budget"], state["displacement_noise"])
    write(pathlib.Path(state["file"]), found)
    return {"notes": notes}


def show(asked: dict[str, Any]) -> str:
    found = []
    for name in asked["files"]:
        with open_hdf5(name) as file:
            found.append(read_whole(pathlib.Path(name), file))
    if asked["format"] == "json":
        return tables.to_json(found) + "\n"
    return "".join(tables.shown(each, asked["format"] == "markdown") for each in found) + tables.LEGEND + "\n"


def main(part: str) -> int:
    asked = tomllib.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
    try:
        answer = {"plan": plan, "keep": keep, "finish": finish, "show": show}[part](asked)
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return 2
    sys.stdout.buffer.write((answer if isinstance(answer, str) else to_toml(answer, "case")).encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
