"""Statistics of models over the bodies of a cohort, whose names end in their number.

python3 -m livermark.studies.cohort table < TOML, which `livermark cohort` and `livermark table --kind cohort` call: the columns of
errors, the titles of the regimes, the legend of the tool and the smallest_felt_difference; markdown. Prints the tables.
python3 -m livermark.studies.cohort finish FILE adds the statistics to a cohort file that has the errors; ready does nothing.
"""
from __future__ import annotations

import functools
import math
import pathlib
import shutil
import sys
import tomllib
from dataclasses import dataclass, field
from typing import Any, Iterator, NamedTuple, Optional

import numpy

from livermark.errors import InputError
from livermark.hdf5_files import library, put_attribute, put_dataset, read_attribute
from livermark.plain_files import whole_file
from livermark.studies.tables import PERCENT, Column, Table, fixed, printable

FEWEST_BODIES = 6
"""An interval is given for at least this many bodies: the smallest and the largest of n values hold the median of the
population with a probability of 1 - 2^(1 - n) (the sign test's interval), which is 94 % of five bodies and 97 % of six. The
upper end of the interval of a 95th percentile is the worst body's as long as there are fewer than 59."""
NUM_SAMPLES, SEED = 2000, 1979  # of the bootstrap
HALVES = {"training": "tuning", "unseen": "test"}  #: names in files, and words that do not suggest that models learn
REGIMES = ("small", "large")
NOWHERE = (math.nan, math.nan)


class Error(NamedTuple):
    """Error of one model on one body under one load case."""
    body: str
    regime: str
    poisson_ratio: float
    load_case: str
    model: str
    is_ok: bool  #: the model came to an end
    relative_l2: float
    stiffness: float  #: at the tool; NaN without one
    reference: str  #: empty where nothing was compared
    uncertainty: float = math.nan  #: of the reference's displacement; NaN where it is not known
    stiffness_uncertainty: float = math.nan  #: the same of its stiffness at the tool


@dataclass
class Statistics:
    """Errors of one model over the bodies of one half. The mean over load cases is taken of each body."""
    regime: str
    reference: str
    half: str
    poisson_ratio: float
    model: str
    errors: list[float]  #: mean of relative_l2 of each body that counts
    left_out: int  #: bodies where the model has not come to an end, or that lack a load case of others
    sizes: list[float] = field(default_factory=list)  #: mean absolute stiffness at the tool, of the bodies that have one
    #: bars of the reference, the mean over load cases of each body that has one under all of them
    bars: list[float] = field(default_factory=list)
    stiffness_bars: list[float] = field(default_factory=list)
    median: float = math.nan
    median_interval: tuple[float, float] = NOWHERE
    percentile_95: float = math.nan
    percentile_95_interval: tuple[float, float] = NOWHERE
    worst: float = math.nan
    stiffness_median: float = math.nan
    stiffness_median_interval: tuple[float, float] = NOWHERE
    stiffness_worst: float = math.nan
    uncertainty: float = math.nan
    stiffness_uncertainty: float = math.nan

    def __post_init__(self) -> None:
        if self.errors:
            self.median, self.percentile_95 = quantile(self.errors, 0.5), quantile(self.errors, 0.95)
            self.worst = max(self.errors)
            self.median_interval = interval(self.errors, 0.5)
            self.percentile_95_interval = interval(self.errors, 0.95)
        if self.sizes:
            self.stiffness_median, self.stiffness_worst = quantile(self.sizes, 0.5), max(self.sizes)
            self.stiffness_median_interval = interval(self.sizes, 0.5)
        if self.bars:
            self.uncertainty = quantile(self.bars, 0.5)
        if self.stiffness_bars:
            self.stiffness_uncertainty = quantile(self.stiffness_bars, 0.5)


def quantiles(rows: Any, part: float) -> Any:
    """Of each row, linear interpolation between sorted values (type 7 of Hyndman, Fan 1996, The American Statistician 50(4))."""
    rows = numpy.sort(rows, axis=-1)
    place = part * (rows.shape[-1] - 1)
    below = int(place)
    above = min(below + 1, rows.shape[-1] - 1)
    return rows[..., below] + (place - below) * (rows[..., above] - rows[..., below])


def quantile(values: Any, part: float) -> float:
    return float(quantiles(numpy.array(values, dtype=float), part))


@functools.lru_cache(maxsize=4)
def random_numbers(seed: int, count: int) -> Any:
    """The first numbers of the 64-bit Mersenne Twister, std::mt19937_64, which numpy does not have.
    (T. Nishimura 2000, Tables of 64-bit Mersenne Twisters, ACM Trans. Model. Comput. Simul. 10)"""
    words = [seed]
    for i in range(1, 312):
        words.append((6364136223846793005 * (words[-1] ^ (words[-1] >> 62)) + i) % 2**64)
    state, drawn, u64 = numpy.array(words, dtype=numpy.uint64), [], numpy.uint64

    def twisted(high: Any, low: Any, far: Any) -> Any:
        mixed = (high & u64(0xFFFFFFFF80000000)) | (low & u64(0x7FFFFFFF))
        return far ^ (mixed >> u64(1)) ^ numpy.where(mixed & u64(1), u64(0xB5026F5AA96619E9), u64(0))
    for _ in range(-(-count // 312)):
        first = twisted(state[:156], state[1:157], state[156:])
        state = numpy.concatenate([first, twisted(state[156:], numpy.append(state[157:], first[0]), first)])
        x = state ^ ((state >> u64(29)) & u64(0x5555555555555555))
        x = x ^ ((x << u64(17)) & u64(0x71D67FFFEDA60000))
        x = x ^ ((x << u64(37)) & u64(0xFFF7EEE000000000))
        drawn.append(x ^ (x >> u64(43)))
    return numpy.concatenate(drawn)[:count]


def bootstrap_interval(values: list[float], part: float) -> tuple[float, float]:
    """Percentile bootstrap of a quantile (Efron 1979, Annals of Statistics 7(1)): 2.5 to 97.5 % of the quantiles of 2000 samples
    with replacement. The seed is fixed, so the same values give the same interval."""
    uniform = 2.0**-53 * (random_numbers(SEED, NUM_SAMPLES * len(values)) >> numpy.uint64(11)).astype(float)
    chosen = (len(values) * uniform).astype(int).reshape(NUM_SAMPLES, -1)
    found = quantiles(numpy.array(values, dtype=float)[chosen], part)
    return quantile(found, 0.025), quantile(found, 0.975)


def interval(values: list[float], part: float) -> tuple[float, float]:
    """NaN of fewer than FEWEST_BODIES."""
    return bootstrap_interval(values, part) if len(values) >= FEWEST_BODIES else NOWHERE


def half_of(body: str) -> Optional[str]:
    """"training" if the name of a body ends in an odd number, "unseen" if in an even one; None if it ends in none. Constants of
    models may be chosen on the training half, and accuracy is quoted on the unseen one."""
    last = body[-1:]
    return None if last not in tuple("0123456789") else "training" if int(last) % 2 == 1 else "unseen"


def statistics_of(errors: list[Error]) -> list[Statistics]:
    """In the order of regime, reference, half, Poisson's ratio and model. What has not come to an end where nothing was compared
    counts beside the first reference of its regime and ratio. Where a body, load case and model are there twice, the last
    counts."""
    first_reference: dict[Any, str] = {}
    for error in errors:
        if error.reference:
            first_reference.setdefault((error.regime, error.poisson_ratio), error.reference)
    groups: dict[Any, dict[str, dict[str, Error]]] = {}
    load_cases: dict[Any, set[str]] = {}
    for error in errors:
        half = half_of(error.body)
        if half is None:
            continue
        reference = error.reference or first_reference.get((error.regime, error.poisson_ratio), "")
        load_cases.setdefault((error.regime, error.poisson_ratio, reference), set()).add(error.load_case)
        group = (REGIMES.index(error.regime), reference, half, error.poisson_ratio, error.model)
        groups.setdefault(group, {}).setdefault(error.body, {})[error.load_case] = error
    found = []
    for group in sorted(groups):
        regime, reference, half, ratio, model = REGIMES[group[0]], *group[1:]
        num_load_cases = len(load_cases[regime, ratio, reference])
        means, sizes, bars, stiffness_bars = [], [], [], []
        for _, of_body in sorted(groups[group].items()):
            cases = [case for _, case in sorted(of_body.items())]
            total = sum(case.relative_l2 if case.is_ok else math.nan for case in cases)
            if len(cases) == num_load_cases and math.isfinite(total):
                means.append(total / num_load_cases)
                bar = sum(case.uncertainty for case in cases) / num_load_cases
                if not math.isnan(bar):
                    bars.append(bar)
                felt = [case for case in cases if not math.isnan(case.stiffness)]
                if felt:
                    sizes.append(sum(abs(case.stiffness) for case in felt) / len(felt))
                    bar = sum(case.stiffness_uncertainty for case in felt) / len(felt)
                    if not math.isnan(bar):
                        stiffness_bars.append(bar)
        found.append(Statistics(regime, reference, half, ratio, model, means, len(groups[group]) - len(means), sizes, bars,
                                stiffness_bars))
    return found


def apart(found: list[Statistics], *names: str) -> Iterator[list[Statistics]]:
    """Those that have the same of the attributes stand together."""
    groups: dict[Any, list[Statistics]] = {}
    for each in found:
        groups.setdefault(tuple(getattr(each, name) for name in names), []).append(each)
    return iter(groups.values())


def table(found: list[Statistics], smallest_felt_difference: float) -> Table:
    """A row per half, Poisson's ratio and model [%], of one regime and reference, with the bars of that."""
    def size(value: float) -> str:
        return fixed(PERCENT * value, 1) + (" !" if value > smallest_felt_difference else "")

    def beside(cell: str, ends: tuple[float, float], decimals: int) -> str:
        low, high = (fixed(PERCENT * end, decimals) for end in ends)
        return cell if math.isnan(ends[0]) else f"{cell} ({low} to {high})"
    rows = []
    for each in found:
        row = [HALVES[each.half], f"{each.poisson_ratio:g}", each.model, str(len(each.errors)), str(each.left_out)]
        rows.append(row + (["-"] * 7 if not each.errors else [
            beside(fixed(PERCENT * each.median, 2), each.median_interval, 2),
            beside(fixed(PERCENT * each.percentile_95, 2), each.percentile_95_interval, 2), fixed(PERCENT * each.worst, 2),
            fixed(PERCENT * each.uncertainty, 2),
            beside(size(each.stiffness_median), each.stiffness_median_interval, 1), size(each.stiffness_worst),
            fixed(PERCENT * each.stiffness_uncertainty, 1)]))
    return Table([Column("half"), Column("nu", True), Column("model"), *(Column(title, True) for title in (
        "bodies", "left out", "median [%]", "95th percentile [%]", "worst [%]", "+- [%]", "tool [%]", "worst tool [%]",
        "tool +- [%]"))], rows)


def shown(found: list[Statistics], asked: dict[str, Any]) -> list[str]:
    """The tables of each regime and reference, below its title and above a legend."""
    if not found:
        raise InputError("there is no cohort here; give static results on bodies whose names end in their number, such as those "
                         "of `livermark mesh liver --variant 7 -o liver_variant_7.msh`")
    texts = []
    for group in apart(found, "regime", "reference"):
        made, reference = table(group, asked["smallest_felt_difference"]), printable(group[0].reference)
        texts += [asked["titles"][group[0].regime] + "\n",
                  (made.markdown() if asked["markdown"] else made.text()) +
                  f"\nover bodies, of the mean relative L2 error{' against ' + reference if reference else ''} over load cases; in "
                  f"brackets the interval of 95 % by bootstrap, of {FEWEST_BODIES} bodies or more; tuning: odd numbers, on which "
                  "constants may be chosen, test: even ones; +-, tool +-: the reference's own uncertainty, in the mean over load "
                  "cases, the median over bodies\n" + asked["tool_legend"]]
    return texts


def errors_of_file(file: Any) -> list[Error]:
    """The errors of an open cohort file."""
    group = file["errors"]

    def words(name: str) -> list[str]:
        names = read_attribute(group[name], "names")
        return [names[index] for index in group[name][:]]
    num_errors = len(group["body"])
    columns = {name: words(name) for name in ("body", "load_case", "model", "regime", "status")}
    columns["reference"] = words("reference") if "reference" in group else [""] * num_errors  # files of earlier versions have none
    numbers = {name: group[name][:].tolist() for name in ("poisson_ratio", "relative_l2")}
    for name, dataset in (("stiffness", "stiffness_at_tool"), ("uncertainty", "reference_uncertainty"),
                          ("stiffness_uncertainty", "stiffness_uncertainty")):
        numbers[name] = group[dataset][:].tolist() if dataset in group else [math.nan] * num_errors
    return [Error(columns["body"][e], columns["regime"][e], numbers["poisson_ratio"][e], columns["load_case"][e],
                  columns["model"][e], columns["status"][e] == "ok", numbers["relative_l2"][e], numbers["stiffness"][e],
                  columns["reference"][e], numbers["uncertainty"][e], numbers["stiffness_uncertainty"][e])
            for e in range(num_errors)]


def put_statistics(file: Any, found: list[Statistics]) -> None:
    """The group /statistics of results/schema.md."""
    group = file.create_group("statistics")

    def put_words(name: str, known: tuple[str, ...] = ()) -> None:
        words = [getattr(each, name) for each in found]
        names = list(dict.fromkeys([*known, *words]))
        put_dataset(group, name, numpy.array([names.index(word) for word in words], dtype=numpy.int32))
        put_attribute(group[name], "names", names)

    def put_numbers(name: str, values: list[float]) -> None:
        put_dataset(group, name, numpy.array(values, dtype=float))
    put_words("half", tuple(HALVES))
    put_words("regime", REGIMES)
    put_words("model")
    put_words("reference")
    put_numbers("poisson_ratio", [each.poisson_ratio for each in found])
    for name, counts in (("bodies", [len(each.errors) for each in found]), ("left_out", [each.left_out for each in found])):
        put_dataset(group, name, numpy.array(counts, dtype=numpy.int32))
    for name in ("median", "percentile_95", "worst", "stiffness_median", "stiffness_worst", "uncertainty",
                 "stiffness_uncertainty"):
        put_numbers(name, [getattr(each, name) for each in found])
        if name.endswith(("median", "percentile_95")):
            for end, place in (("low", 0), ("high", 1)):
                put_numbers(f"{name}_{end}", [getattr(each, name + "_interval")[place] for each in found])


def finish(path: pathlib.Path) -> None:
    """Adds the statistics to a file that the program has just written, which stays as it was if that fails."""
    try:
        with whole_file(path) as part:
            shutil.copyfile(path, part)
            with library().File(part, "r+", libver=("v110", "v110")) as file:
                if "statistics" in file:
                    del file["statistics"]
                put_statistics(file, statistics_of(errors_of_file(file)))
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error}); choose another place") from error


def main(arguments: list[str]) -> int:
    if arguments[0] == "ready":  # all libraries are here
        library()
        return 0
    try:
        if arguments[0] == "finish":
            finish(pathlib.Path(arguments[1]))
            return 0
        asked = tomllib.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
        errors = [Error(*row) for row in zip(*(asked["errors"][name] for name in Error._fields))]
        text = "\n".join(shown(statistics_of(errors), asked))
    except InputError as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        return 2
    sys.stdout.buffer.write(text.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
