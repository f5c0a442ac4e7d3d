"""Ranges of what is not known of a patient: a file such as results/parameter_ranges.toml, and which of them act."""
from __future__ import annotations

import difflib
import math
import pathlib
import re
import tomllib
from dataclasses import dataclass
from typing import Any, NamedTuple, Optional

from livermark.errors import InputError


class Known(NamedTuple):
    """A parameter that ranges may be given of. Its values are between the ends, and may reach the upper one or not."""
    unit: str
    group: str
    above: float
    below: float
    may_reach_end: bool = False


KNOWN = {"young_modulus": Known("Pa", "parameters", 0.0, math.inf), "poisson_ratio": Known("", "parameters", -1.0, 0.5),
         "tumour_contrast": Known("", "parameters", 0.0, math.inf), "shear_left": Known("", "parameters", 0.0, 1.0, True),
         "capsule_stiffness": Known("N/m", "parameters", 0.0, math.inf), "density": Known("kg/m^3", "parameters", 0.0, math.inf),
         "map_contrast": Known("", "parameters", 0.0, math.inf), "map_slope": Known("", "parameters", -math.inf, math.inf),
         "held_share": Known("", "support", 0.0, 1.0, True), "support_stiffness": Known("Pa/m", "support", 0.0, math.inf),
         "tool_offset": Known("m", "tool", -math.inf, math.inf)}
OTHERS = "others_from"  #: key of a file that has the ranges which are not in this one
OBSTACLES = {  # what the program says of a problem, and why a parameter does not act without it
    "tumour_contrast": ("has_tumour", "the body has no stiffer region"),
    "map_contrast": ("has_map", "the body has no map of stiffness"),
    "map_slope": ("has_map", "the body has no map of stiffness"),
    "density": ("has_acceleration",
                "without an acceleration density has no effect on a body at rest: its index is exactly 0"),
    "held_share": ("is_held", "no facet is constrained in all directions"),
    "support_stiffness": ("is_held", "no facet is constrained in all directions"),
    "tool_offset": ("has_movable_tool", "the load case does not have exactly one round tool to move")}


@dataclass(frozen=True)
class Parameter:
    """What is not known of a patient, and how far it reaches."""
    name: str
    unit: str  #: SI, or nothing
    group: str  #: "parameters", "support" or "tool"
    lower: float  #: SI
    upper: float  #: above lower
    is_logarithmic: bool  #: its logarithm is uniform between the ends, not the value
    source: str  #: of the range

    def at(self, share: float) -> float:
        """The value below which a share of all patients lies, in [0, 1]."""
        if self.is_logarithmic:
            return self.lower * math.pow(self.upper / self.lower, share)
        return self.lower + share * (self.upper - self.lower)


@dataclass(frozen=True)
class Ranges:
    parameters: list[Parameter]  #: tool_offset as tool_offset_1 and tool_offset_2
    displacement_noise: Optional[float]  #: of a measured displacement [m]


class _File:
    """A TOML file, for refusals that name the line."""

    def __init__(self, path: pathlib.Path):
        self.path = path
        try:
            self.text = path.read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            reason = getattr(error, "strerror", None) or "it is not text in UTF-8"
            raise InputError(f"{path}: cannot be read ({reason}); check the path") from error
        try:
            self.content: dict[str, Any] = tomllib.loads(self.text)
        except (tomllib.TOMLDecodeError, RecursionError) as error:
            raise InputError(f"{path}: this is not TOML: {error}; correct it") from error

    def place(self, table: str = "", key: str = "") -> str:
        """file:line of a table, or of a key in it."""
        start = re.search(rf"^[ \t]*\[?[ \t]*{re.escape(table)}\b", self.text, re.MULTILINE) if table else None
        of_key = re.compile(rf"^[ \t]*\[?{re.escape(key)}\b", re.MULTILINE) if key else None
        found = (of_key.search(self.text, start.end() if start else 0) if of_key else None) or start
        return f"{self.path}:{self.text.count(chr(10), 0, found.start()) + 1 if found else 1}"

    def refuse_unknown(self, table: str, content: dict[str, Any], known: list[str]) -> None:
        for key in content:
            if key not in known:
                near = difflib.get_close_matches(key, known, 1)
                remedy = f"did you mean '{near[0]}'?" if near else f"known are: {', '.join(known)}"
                raise InputError(f"{self.place(table, key)}: unknown key '{key}'; {remedy}")

    def table(self, name: str, known: list[str]) -> dict[str, Any]:
        content = self.content[name]
        if not isinstance(content, dict):
            raise InputError(f"{self.place(name)}: '{name}' has to be a table")
        self.refuse_unknown(name, content, known)
        return content

    def value(self, table: str, key: str) -> Any:
        if key not in self.content[table]:
            raise InputError(f"{self.place(table)}: '{key}' is missing; add it")
        return self.content[table][key]

    def number(self, table: str, key: str) -> float:
        value = self.value(table, key)
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise InputError(f"{self.place(table, key)}: '{key}' has to be a finite number")
        return float(value)

    def string(self, table: str, key: str) -> str:
        value = self.value(table, key)
        if not isinstance(value, str):
            raise InputError(f"{self.place(table, key)}: '{key}' has to be a string in quotes")
        return value


def _parameter(file: _File, name: str, known: Known) -> Parameter:
    content = file.table(name, ["from", "to", "scale", "source"])
    lower, upper, source = file.number(name, "from"), file.number(name, "to"), file.string(name, "source")
    scale = file.string(name, "scale") if "scale" in content else "linear"
    if scale not in ("linear", "logarithmic"):
        raise InputError(f"{file.place(name, 'scale')}: the scale '{scale}' is not known; write \"linear\" or \"logarithmic\"")
    if not lower < upper:
        raise InputError(f"{file.place(name)}: {name} goes from {lower:g} to {upper:g}; the second has to be larger")
    if not lower > known.above or not (upper < known.below or (known.may_reach_end and upper <= known.below)):
        raise InputError(f"{file.place(name)}: {name} from {lower:g} to {upper:g} cannot be; it lies above {known.above:g} and "
                         f"{'not above' if known.may_reach_end else 'below'} {known.below:g}")
    if scale == "logarithmic" and not lower > 0.0:
        raise InputError(f"{file.place(name)}: {name} from {lower:g} has no logarithm; begin above 0, or leave the scale out")
    return Parameter(name, known.unit, known.group, lower, upper, scale == "logarithmic", source)


def _table_of(name: str) -> str:
    """The table that has the range of a parameter."""
    return name.removesuffix("_1").removesuffix("_2")


def _others(file: _File) -> Ranges:
    """The ranges of the file that another one takes its other ranges from; none where it names none."""
    if OTHERS not in file.content:
        return Ranges([], None)
    name = file.content[OTHERS]
    if not isinstance(name, str):
        raise InputError(f"{file.place('', OTHERS)}: '{OTHERS}' has to be a string in quotes")
    others = _File(file.path.parent / name)
    if OTHERS in others.content:
        raise InputError(f"{others.place('', OTHERS)}: {file.path} takes ranges from this file, so it cannot have '{OTHERS}' "
                         "itself; name the file with all ranges in both")
    return _ranges(others)


def read_ranges(path: pathlib.Path) -> Ranges:
    """Tables of KNOWN, each with from, to, source and maybe scale = "logarithmic", and [measurement] with displacement and
    source. others_from, a path beside this file, names a file with the ranges that this one leaves out; what neither has does
    not vary. Raises InputError for unknown keys, a range that is empty or that the parameter cannot have, a missing source, a
    file without a range, or others_from in both files."""
    return _ranges(_File(path))


def _ranges(file: _File) -> Ranges:
    file.refuse_unknown("", file.content, [OTHERS, "measurement", *KNOWN])
    others = _others(file)
    parameters = []
    for name, known in KNOWN.items():
        if name in file.content:
            parameter = _parameter(file, name, known)
            names = [name] if name != "tool_offset" else [name + "_1", name + "_2"]
            parameters += [Parameter(**{**vars(parameter), "name": each}) for each in names]
        else:
            parameters += [parameter for parameter in others.parameters if _table_of(parameter.name) == name]
    if not parameters:
        raise InputError(f"{file.path}: there is no range; add a table such as [young_modulus] with from, to and source")
    noise = others.displacement_noise
    if "measurement" in file.content:
        file.table("measurement", ["displacement", "source"])
        file.string("measurement", "source")
        noise = file.number("measurement", "displacement")
        if not noise > 0.0:
            raise InputError(f"{file.place('measurement', 'displacement')}: 'displacement' has to be positive")
    return Ranges(parameters, noise)


def acting_on(problem: dict[str, Any], ranges: Ranges) -> tuple[list[Parameter], list[str]]:
    """The parameters that act on a problem, and a sentence for each that does not.

    problem: body, load_case, and whether it has_tumour, has_map, has_acceleration, is_held, has_movable_tool.
    """
    acting, notes, name = [], [], f"{problem['body']} / {problem['load_case']}"
    for parameter in ranges.parameters:
        known = _table_of(parameter.name)
        fact, why = OBSTACLES.get(known, ("", ""))
        if not fact or problem[fact]:
            acting.append(parameter)
        elif parameter.name != "tool_offset_2":  # which is said once
            notes.append(f"{name}: {known} is not varied, because {why}")
    if not acting:
        raise InputError(f"{name}: no parameter that has a range acts here; give a range of young_modulus")
    return acting, notes
