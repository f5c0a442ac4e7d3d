"""What a step takes, from the benchmarks."""
from __future__ import annotations

from typing import Any

import h5py

from livermark.report.data import Column, ReportData, Table, attributes_of, cleaned
from livermark.report.parts import Section, figure, missing, paragraph, share, table
from livermark.studies.tables import PERCENT

TITLE = "What a step takes"
COMMAND = "build/release/benchmarks/step_benchmark --hdf5=FILE"  # makes the files
COLUMNS = [Column("benchmark"), Column("median [us]", True), Column("shortest [us]", True), Column("repetitions", True),
           Column("clock"), Column("springs", True), Column("per spring [ns]", True), Column("of the limit [%]", True),
           Column("simulated s/s", True)]


def _benchmarks(file) -> list[tuple[str, int, dict[str, Any]]]:
    """Name, number of repetitions and attributes of each."""
    found = []

    def look(group, name):
        if "seconds" in group:
            found.append((cleaned(name), len(group["seconds"]), attributes_of(group)))
        else:
            for child, below in group.items():
                if isinstance(below, h5py.Group):
                    look(below, f"{name}/{child}" if name else child)
    look(file["timings"], "")
    return found


def _microseconds(seconds: float) -> str:
    """Never with an exponent, so that the column can be read down."""
    value = 1e6 * seconds
    return f"{value:.{2 if value < 10.0 else 1 if value < 1000.0 else 0}f}"


def _counter(counters: dict, name: str, unit: float) -> str:
    return f"{unit * counters[name]:.3g}" if name in counters else "-"


def _row(name: str, repetitions: int, counters: dict) -> list[str]:
    return [name, _microseconds(counters["seconds_median"]), _microseconds(counters["seconds_min"]), str(repetitions),
            counters["clock"], f"{counters['springs']:.0f}" if "springs" in counters else "-",
            _counter(counters, "time_per_spring", 1e9), _counter(counters, "of_limit", PERCENT),
            _counter(counters, "real_time_factor", 1.0)]


def _table(file):
    benchmarks = _benchmarks(file)
    rows = Table(COLUMNS, [_row(*benchmark) for benchmark in benchmarks])
    if not any("of_limit" in counters for _, _, counters in benchmarks):
        return table(rows) + missing("No benchmark in this file is compared with the limit of the machine.")
    bars = [share(min(max(counters["of_limit"], 0.0), 1.0)) if "of_limit" in counters else ""
            for _, _, counters in benchmarks]
    return table(rows, (), ("of the limit", bars))


def section(data: ReportData) -> Section | None:
    if not data.told["timings"]:
        return None
    html = paragraph(
        "The limit is the least time that one evaluation of all spring forces can take on one core of this machine in "
        "single precision: gathering both ends of each spring, reading the data of a step, and its operations, each measured "
        "in the same process. 100 % is the limit of one core; several threads can be faster.")
    for name in data.told["timings"]:
        with data.open(name) as file:
            made = attributes_of(file)
            caption = f"Timings of {made['cpu']} ({made['build_type']}, {made['created']}, commit {made['git_commit']})."
            html += figure("table", _table(file), caption, [made["command"]])
    return Section("timings", TITLE, html)
