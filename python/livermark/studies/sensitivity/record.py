"""Sensitivity files: what results/schema.md has under "Sensitivity files"."""
from __future__ import annotations

import math
import pathlib
from dataclasses import dataclass, field
from typing import Any

import numpy

from livermark.errors import InputError
from livermark.hdf5_files import (FAULTS, SCHEMA_VERSION, damaged, new_hdf5, open_hdf5, put_attribute, put_dataset,
                                  read_attribute)
from livermark.studies.sensitivity.ranges import Parameter

MAKER = "livermark sensitivity"
INDICES = ("first", "first_lower", "first_upper", "total", "total_lower", "total_upper")
NUMBERS = ("nominal", "mean", "deviation", "lower", "upper", "unexplained")
PROVENANCE = ("software_version", "git_commit", "created", "command", "cpu", "compiler", "build_type", "threads")


@dataclass
class Output:
    """How one output depends on the parameters: Sobol indices, and intervals that hold 95 % of what points drawn again with
    replacement give. P parameters, G groups of them."""
    name: str
    unit: str
    nominal: float = math.nan  #: of the reference, with body and load case as their files have them
    mean: float = math.nan  #: of the samples
    deviation: float = math.nan  #: standard deviation of the samples
    lower: float = math.nan  #: 95 % of the samples are between this and upper
    upper: float = math.nan
    unexplained: float = math.nan  #: part of the variance that the polynomial misses
    first: list[float] = field(default_factory=list)  #: (P) V(E(y | x_p)) / V(y)
    first_lower: list[float] = field(default_factory=list)
    first_upper: list[float] = field(default_factory=list)
    total: list[float] = field(default_factory=list)  #: (P) 1 - V(E(y | all but x_p)) / V(y)
    total_lower: list[float] = field(default_factory=list)
    total_upper: list[float] = field(default_factory=list)
    group_total: list[float] = field(default_factory=list)  #: (G) total of all parameters of a group together

    def relative_deviation(self, known: int = -1) -> float:
        """Standard deviation over the mean while one parameter, or none where it is negative, is known."""
        rest = 1.0 if known < 0 else max(0.0, 1.0 - self.first[known])
        return self.deviation / (abs(self.mean) or math.nan) * math.sqrt(rest)

    def relative_deviation_of_group(self, group: int) -> float:
        """The same of a group alone, with what it does together with others."""
        return self.deviation / (abs(self.mean) or math.nan) * math.sqrt(self.group_total[group])

    @property
    def leading(self) -> int:
        """The parameter that most of the variance is due to, alone."""
        return int(numpy.argmax(self.first))


@dataclass
class Budget:
    """Relative uncertainty of the outputs from everything but the patient (ASME V&V 20); NaN where nothing is known or
    nothing applies. O outputs."""
    reference: str = ""  #: that models are compared with
    mesh: list[float] = field(default_factory=list)  #: (O) error bar of the reference
    law: list[float] = field(default_factory=list)  #: (O) Ogden's over the neo-Hookean law under the large load case, minus 1
    measurement: list[float] = field(default_factory=list)  #: (O) noise of a measured displacement
    models: dict[str, list[float]] = field(default_factory=dict)  #: (O) error of each model


@dataclass
class Sensitivity:
    """The content of one file: S samples, P parameters, O outputs, G groups."""
    provenance: dict[str, Any]
    body: str
    load_case: str
    title: str
    model: str  #: that solved the samples
    fingerprint: str  #: of body, load case and model: samples of others are not continued
    parameters: list[Parameter]  #: (P)
    points: list[list[float]]  #: (S, P) SI; in the file as many as are solved
    values: list[list[float]]  #: (S, O) SI; NaN where there is no solution
    outputs: list[Output] = field(default_factory=list)  #: (O); none while samples are being solved
    budget: Budget = field(default_factory=Budget)

    @property
    def name(self) -> str:
        return f"{self.body} / {self.load_case}"

    @property
    def groups(self) -> list[str]:
        """(G) of the parameters, in their order."""
        return list(dict.fromkeys(parameter.group for parameter in self.parameters))


def write(path: pathlib.Path, found: Sensitivity) -> None:
    """Puts a whole file in the place of an earlier one. Raises InputError if it cannot be written."""
    num_outputs = len(found.values[0]) if found.values else 0
    with new_hdf5(path, found.provenance) as file:
        root = file.create_group("sensitivity")
        for name in ("body", "load_case", "title", "model", "fingerprint", "groups"):
            put_attribute(root, name, getattr(found, name))
        group = root.create_group("parameters")
        for name, member in (("names", "name"), ("unit_names", "unit"), ("groups", "group"), ("sources", "source")):
            put_attribute(group, name, [getattr(parameter, member) for parameter in found.parameters])
        for name in ("lower", "upper", "is_logarithmic"):
            put_dataset(group, name, [getattr(parameter, name) for parameter in found.parameters])
        group = root.create_group("samples")
        put_attribute(group, "num_outputs", num_outputs)
        solved = numpy.array(found.points[:len(found.values)], dtype=float).reshape(-1, len(found.parameters))
        put_dataset(group, "points", solved)
        put_dataset(group, "values", numpy.array(found.values, dtype=float).reshape(-1, num_outputs))
        if not found.outputs:
            return
        group = root.create_group("outputs")
        for name, member in (("names", "name"), ("unit_names", "unit")):
            put_attribute(group, name, [getattr(output, member) for output in found.outputs])
        for name in (*NUMBERS, *INDICES, "group_total"):
            put_dataset(group, name, numpy.array([getattr(output, name) for output in found.outputs], dtype=float))
        group, budget = root.create_group("budget"), found.budget
        put_attribute(group, "reference", budget.reference)
        put_attribute(group, "models", list(budget.models))
        for name in ("mesh", "law", "measurement"):
            put_dataset(group, name, numpy.array(getattr(budget, name), dtype=float))
        put_dataset(group, "error", numpy.array(list(budget.models.values()), dtype=float).reshape(-1, len(found.outputs)))


def _array(group: Any, name: str, *shape: int) -> Any:
    values = group[name][:]
    if values.shape != shape:
        raise ValueError(f"{group.name}/{name} has the shape {values.shape} instead of {shape}")
    return values


def _parameters(group: Any) -> list[Parameter]:
    texts = [read_attribute(group, name) for name in ("names", "unit_names", "groups", "sources")]
    count = len(texts[0])
    lower, upper, logarithmic = (_array(group, name, count).tolist() for name in ("lower", "upper", "is_logarithmic"))
    if count == 0 or any(len(entries) != count for entries in texts):
        raise ValueError(f"{group.name} does not have all of its parameters")
    return [Parameter(name, unit, of, low, high, bool(is_logarithmic), source) for name, unit, of, source, low, high, is_logarithmic
            in zip(*texts, lower, upper, logarithmic)]


def _outputs(group: Any, num_outputs: int, num_parameters: int, num_groups: int) -> list[Output]:
    names, units = read_attribute(group, "names"), read_attribute(group, "unit_names")
    if len(names) != num_outputs or len(units) != num_outputs:
        raise ValueError(f"{group.name} has {len(names)} outputs, and the samples have {num_outputs}")
    shapes = {**dict.fromkeys(NUMBERS, ()), **dict.fromkeys(INDICES, (num_parameters,)), "group_total": (num_groups,)}
    columns = {name: _array(group, name, num_outputs, *shape).tolist() for name, shape in shapes.items()}
    return [Output(name, unit, **{key: column[o] for key, column in columns.items()})
            for o, (name, unit) in enumerate(zip(names, units))]


def of_open_file(file: Any) -> Sensitivity:
    """The content of an open file. Raises what h5py raises for damaged content, and ValueError for what does not fit."""
    if read_attribute(file, "schema_version") != SCHEMA_VERSION:
        raise ValueError(f"schema_version is {read_attribute(file, 'schema_version')}, and {SCHEMA_VERSION} is read here")
    root = file["sensitivity"]
    parameters = _parameters(root["parameters"])
    samples = root["samples"]
    num_outputs = int(read_attribute(samples, "num_outputs"))
    points = samples["points"][:]
    if num_outputs < 1 or points.ndim != 2 or len(points) == 0 or points.shape[1] != len(parameters):
        raise ValueError("/sensitivity/samples are none, or have other parameters")
    texts = {name: read_attribute(root, name) for name in ("body", "load_case", "title", "model", "fingerprint")}
    found = Sensitivity({name: read_attribute(file, name) for name in PROVENANCE}, **texts, parameters=parameters,
                        points=points.tolist(), values=_array(samples, "values", len(points), num_outputs).tolist())
    if found.groups != read_attribute(root, "groups"):
        raise ValueError("/sensitivity: the groups are not those of the parameters")
    if "outputs" in root:
        found.outputs = _outputs(root["outputs"], num_outputs, len(parameters), len(found.groups))
        group = root["budget"]
        models = read_attribute(group, "models")
        errors = _array(group, "error", len(models), num_outputs).tolist()
        found.budget = Budget(read_attribute(group, "reference"),
                              *(_array(group, name, num_outputs).tolist() for name in ("mesh", "law", "measurement")),
                              models=dict(zip(models, errors)))
    return found


def read(path: pathlib.Path) -> Sensitivity:
    """What write() wrote. Raises InputError that names the file, and says what is wrong and what to do."""
    with open_hdf5(path, MAKER) as file:
        try:
            return of_open_file(file)
        except FAULTS as error:
            raise damaged(str(path), error, MAKER) from error


def is_sensitivity(path: pathlib.Path) -> bool:
    """Whether there is such a file. Raises InputError for what is no HDF5 file."""
    if not path.exists():
        return False
    with open_hdf5(path, MAKER) as file:
        return "sensitivity" in file


def read_whole(path: pathlib.Path, opened: Any) -> Sensitivity:
    """The content of an open file whose samples are all solved. Raises InputError for another one."""
    try:
        found = of_open_file(opened)
    except FAULTS as error:
        raise damaged(str(path), error, MAKER) from error
    if not found.outputs:
        raise InputError(f"{path}: not all of its patients are solved; `{found.provenance['command']}` goes on where it was")
    return found
