"""What a report is made of: values of result files, and the tables that the program makes of them.

Texts come from files that anybody may have written: characters that no page may hold become U+FFFD where they are read.
"""
from __future__ import annotations

import contextlib
import functools
import math
import pathlib
import re
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Iterator, Optional, TypeVar

import h5py
import numpy

from livermark.errors import InputError
from livermark.hdf5_files import damaged, open_hdf5
from livermark.report import order
from livermark.results import ResultFile, _attributes
from livermark.studies.tables import Column, Table, percent

_T = TypeVar("_T")
_NO_CHARACTER = re.compile("[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff\ufffe\uffff]")


class FileRefused(InputError):
    """A file of the folder that h5py refuses, though the program has read it."""

    def __init__(self, file: str, sentence: str):
        super().__init__(sentence)
        self.file = file  #: relative to the folder


@contextlib.contextmanager
def _refusals_of(file: str, path: pathlib.Path) -> Iterator[None]:
    try:
        yield
    except FileRefused:
        raise
    except InputError as error:
        raise FileRefused(file, str(error)) from error
    except (OSError, RuntimeError) as error:  # what h5py raises for damaged content
        raise FileRefused(file, str(damaged(str(path), error))) from error


def cleaned(value: Any) -> Any:
    """The same with only characters that XML may hold."""
    if isinstance(value, str):
        return _NO_CHARACTER.sub("\ufffd", value)
    if isinstance(value, dict):
        return {cleaned(key): cleaned(item) for key, item in value.items()}
    return [cleaned(item) for item in value] if isinstance(value, list) else value


def number(value: Any) -> float:
    """JSON has no NaN and infinity, which come as these words."""
    return float(value)


def table_of(layout: dict) -> Table:
    """With the sign of the page for an uncertainty."""
    return Table([Column(with_signs(column["title"]), column["is_number"]) for column in layout["columns"]],
                 [[with_signs(cell) for cell in row] for row in layout["rows"]])


def with_signs(text: str) -> str:
    """A text of the program, which prints +- where a page has a sign."""
    return text.replace("+-", "±")


@dataclass(frozen=True)
class Model:
    """One model of a result file."""
    name: str
    status: str
    message: str
    reference: str  #: that it is compared with; empty where it is not
    relative_l2: float  #: NaN where it was not compared
    max_error: float  #: [m]
    stiffness: float  #: at the tool, force over displacement over that of the reference, minus 1; NaN without one
    is_within_uncertainty: bool
    summary: str  #: what it is, in a line
    is_spring_model: bool  #: is made of springs or moves in explicit steps: finite elements are what it is measured by

    @property
    def error(self) -> float:
        """relative_l2 if it came to an end and was compared, else NaN"""
        return self.relative_l2 if self.status == "ok" else math.nan


@dataclass(frozen=True)
class Result:
    """One result file, without its fields, which open() reads."""
    path: pathlib.Path
    file: str  #: relative to the folder
    label: str  #: the body, with its Poisson's ratio where there are several
    body: str
    load_case: str
    title: str
    regions: list[str]  #: names
    has_motion: bool
    poisson_ratio: float
    assumptions: list[str]
    patch_confidence: Optional[float]  #: from 0 to 1, how clear the orientation of a liver is; None where nobody looked for it
    provenance: dict[str, Any]
    uncertainty: Optional[dict[str, Any]]  #: of the reference, as /reference has it
    models: dict[str, Model]
    counts: bool  #: in means of static errors: no motion, no multiple of a load, compared, and inside its regime
    leaves_regime: bool
    remarks: list[str]  #: why its models are not what they were meant to be, a sentence each

    @contextlib.contextmanager
    def open(self) -> Iterator[ResultFile]:
        with _refusals_of(self.file, self.path), ResultFile(self.path) as file:
            yield file

    @property
    def command(self) -> str:
        return self.provenance["command"]

    @property
    def reference(self) -> str:
        """The model that the others are compared with; empty if none was compared."""
        return next((model.reference for model in self.models.values() if model.reference), "")

    @property
    def reference_error(self) -> float:
        """What relative_l2 of the reference itself is known to be; 0 where that is not known."""
        return self.uncertainty["reference_uncertainty"] if self.uncertainty else 0.0

    @property
    def best_springs(self) -> Optional[Model]:
        """The spring model with the smallest error; None if there is none with an error."""
        springs = [model for model in self.models.values() if model.is_spring_model and math.isfinite(model.error)]
        return min(springs, key=lambda model: model.error, default=None)


def not_told_from_best(errors: dict[str, float], uncertainty: float) -> list[str]:
    """Who has the smallest error as a table prints it, and whose error differs from that by less than the uncertainty of
    the reference."""
    best = min(errors.values(), default=math.nan)
    return [name for name, error in errors.items() if percent(error) == percent(best) or error - best < uncertainty]


def _model(file: ResultFile, name: str) -> Model:
    model = file[name]
    comparison = model.comparison or {}
    return Model(name=cleaned(name), status=model.status, message=cleaned(model.attributes["message"]),
                 reference=cleaned(comparison.get("reference", "")),
                 relative_l2=comparison.get("relative_l2", math.nan), max_error=comparison.get("max_error", math.nan),
                 stiffness=comparison.get("worst_stiffness_at_tool", comparison.get("stiffness_at_tool", math.nan)),
                 is_within_uncertainty=comparison.get("within_uncertainty", 0) == 1,
                 summary=cleaned(str(model.attributes.get("summary", ""))), is_spring_model=model.moves_in_steps)


def read_result(path: pathlib.Path, told: dict) -> Result:
    """told: what report_tables() says of the file"""
    with _refusals_of(told["file"], path), ResultFile(path) as result:
        load_case = result.load_case_attributes
        models = [_model(result, name) for name in result.models]
        return Result(path=path, file=told["file"], label=told["label"], body=cleaned(result.body),
                      load_case=cleaned(load_case["name"]), title=cleaned(load_case["title"]),
                      regions=cleaned(result.region_names),
                      has_motion=result.has_motion, poisson_ratio=float(result.materials["poisson_ratio"][0]),
                      assumptions=cleaned(result.assumptions), patch_confidence=result.patch_confidence, provenance=cleaned(result.provenance),
                      uncertainty=cleaned(result.reference), models={model.name: model for model in models},
                      counts=told["counts"], leaves_regime=told["leaves_regime"], remarks=told["remarks"])


def scaled_forces(group) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Forces of the runs beside a measured one, multiplied so that they are right at the first way, (runs, J) [N]; and their mean
    absolute relative error at the others, (runs), which is NaN where a path ends early.
    """
    measured, force = group["force"][:], group["runs/force"][:]
    scaled = force / force[:, :1] * measured[0]
    return scaled, numpy.abs(scaled / measured - 1.0)[:, 1:].mean(axis=1)


def attributes_of(group) -> dict[str, Any]:
    """Attributes of a group of h5py, texts as such."""
    return cleaned(_attributes(group))


def texts_of(group, name: str) -> list[str]:
    """An attribute that is a list of texts."""
    return list(attributes_of(group)[name])


class ReportData:
    """All that sections are made of. Files that the program has found to be damaged are not among them."""

    def __init__(self, told: dict, slices: Optional[dict] = None):
        told = cleaned(told)
        self.slices: dict[str, dict] = cleaned(slices or {})  #: by body: a load case, and slices as slices.planes_of() reads them
        self.folder = pathlib.Path(told["folder"])
        self.command: str = told["command"]
        self.faults: list[str] = told["faults"]  #: a sentence for each file that is left out
        self.others: list[str] = told["others"]  #: files of other kinds
        self._regions: dict[str, list[str]] = {}  # of each body and label
        results, large = ([self._result(entry) for entry in told[kind]] for kind in ("results", "large"))
        self.results = self.in_order(results, lambda result: result.label)  #: of small deformations
        self.large = self.in_order(large, lambda result: result.label)  #: never beside the others
        self.smallest_felt_difference = number(told["smallest_felt_difference"])  #: of stiffness at the tool
        self.told = self._in_order_of_bodies(told)  #: the rest, as livermark::studies::report_tables() says
        self.tables = {name: self._table_in_order(table_of(layout)) for name, layout in told["tables"].items()}

    def in_order(self, items: Iterable[_T], body_of: Callable[[_T], str]) -> list[_T]:
        """The same in the order of bodies, which every section has. body_of: the body or the label of an item."""
        return sorted(items, key=lambda item: order.place(body_of(item), self._regions.get(body_of(item), ())))

    def _in_order_of_bodies(self, told: dict) -> dict:
        told = dict(told)
        for kind, key in (("brief", "body"), ("large_brief", "body"), ("large_bodies", "label"), ("slow", "label"),
                          ("large_slow", "label")):
            told[kind] = self.in_order(told[kind], lambda item, key=key: item[key])
        for kind in ("arenas", "experiments", "needles", "stability"):
            told[kind] = self.in_order(told[kind], lambda item: self._body_of(item["file"]))
        told["sensitivities"] = self.in_order(told["sensitivities"], self._body_of)
        told["standings"] = {kind: self.in_order(standings, lambda standing: standing["body"])
                             for kind, standings in told["standings"].items()}
        return told | {name: with_signs(text) for name, text in told.items() if name.endswith(("reference", "legend"))}

    def _body_of(self, file: str) -> str:
        with self.open(file) as opened:
            return str(attributes_of(opened).get("body", ""))

    def _table_in_order(self, made: Table) -> Table:
        """Rows by the body in their first cell, or columns by the one in their titles."""
        titles = [column.title for column in made.columns]
        if titles[:1] == ["body"]:
            return Table(made.columns, self.in_order(made.rows, lambda row: row[0]))
        labels = sorted(self._regions, key=len)
        of_column = [next((label for label in reversed(labels) if title.startswith((f"{label} [", f"{label}: "))), None)
                     for title in titles]
        first = [c for c, label in enumerate(of_column) if label is None]
        columns = first + self.in_order((c for c, label in enumerate(of_column) if label is not None),
                                        lambda c: of_column[c] or "")
        return Table([made.columns[c] for c in columns], [[row[c] for c in columns] for row in made.rows])

    @property
    def has_no_results(self) -> bool:
        """Whether there is nothing but experiments, needles and sensitivities: the other parts would all be empty."""
        kinds = ("results", "large", "cohorts", "arenas", "stability", "timings")
        return not any(self.told[kind] for kind in kinds)

    def _result(self, entry: dict) -> Result:
        result = read_result(self.folder / entry["file"], entry)
        self._regions[result.label] = self._regions[result.body] = result.regions
        return result

    @contextlib.contextmanager
    def open(self, file: str) -> Iterator[h5py.File]:
        """A file that is no result file; file is relative to the folder."""
        with _refusals_of(file, self.folder / file), open_hdf5(self.folder / file) as opened:
            yield opened

    @functools.cached_property
    def models(self) -> list[str]:
        """Names of the models of small deformations, each once, in the order in which they appear."""
        return model_names(self.results)

    @property
    def has_several_ratios(self) -> bool:
        return any(result.label != result.body for result in self.results)

    def by_label(self) -> Iterator[tuple[str, list[Result]]]:
        """The results of each body, a load case each."""
        for label in dict.fromkeys(result.label for result in self.results):
            yield label, [result for result in self.results if result.label == label]


def model_names(results: list[Result]) -> list[str]:
    return list(dict.fromkeys(name for result in results for name in result.models))


def commands_of(results: list[Result]) -> list[str]:
    return [result.command for result in results]
