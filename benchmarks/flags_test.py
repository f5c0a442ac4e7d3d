#!/usr/bin/env python3
"""Holds that a benchmark program takes the flags of Google Benchmark, as its users and compare.py give them.

usage: flags_test.py PROGRAM FOLDER    FOLDER is for files and exists
"""

import json
import subprocess
import sys
from pathlib import Path

PROGRAM, FOLDER = sys.argv[1], Path(sys.argv[2])
BRIEF = ["--benchmark_filter=^limit/arithmetic$", "--benchmark_min_time=0.001"]
CONTEXT = ("livermark", "git_commit", "cpu", "compiler", "build_type")


def run(*flags, status=0):
    done = subprocess.run([PROGRAM, *flags], capture_output=True, text=True)
    assert done.returncode == status, (flags, done.returncode, done.stderr)
    return done


def test_json_is_all_of_standard_output():
    report = json.loads(run("--benchmark_format=json", *BRIEF).stdout)
    assert [row["name"] for row in report["benchmarks"]] == ["limit/arithmetic"], report
    assert report["benchmarks"][0]["flop_per_second"] > 0
    assert all(report["context"][key] for key in CONTEXT), report["context"]


def test_out_has_what_repetitions_say():
    file = FOLDER / "flags_test.json"
    file.unlink(missing_ok=True)
    run(f"--benchmark_out={file}", "--benchmark_out_format=json", "--benchmark_repetitions=3", *BRIEF)
    rows = json.loads(file.read_text())["benchmarks"]
    assert [row["run_type"] for row in rows].count("iteration") == 3, rows
    assert "median" in [row.get("aggregate_name") for row in rows], rows


def test_aggregates_alone_in_json():
    flags = ["--benchmark_format=json", "--benchmark_repetitions=3", "--benchmark_report_aggregates_only=true"]
    rows = json.loads(run(*flags, *BRIEF).stdout)["benchmarks"]
    assert {row["run_type"] for row in rows} == {"aggregate"}, rows


def test_csv_and_console():
    assert run("--benchmark_format=csv", *BRIEF).stdout.startswith("name,iterations,real_time,cpu_time"), "csv"
    assert "\nlimit/arithmetic " in run("--benchmark_format=console", *BRIEF).stdout
    assert "\x1b[" in run("--benchmark_color=true", *BRIEF).stdout
    assert "\x1b[" not in run(*BRIEF).stdout  # no terminal


def test_list():
    listed = run("--benchmark_list_tests", BRIEF[0]).stdout
    assert listed == "limit/arithmetic\n", listed


def test_help_names_the_flags_of_both():
    said = run("--help").stdout
    assert "--benchmark_format" in said and "--hdf5" in said, said


def test_what_is_not_known_is_refused_in_a_sentence():
    for flags, part in (
        (["--benchmark_fitler=x"], "'--benchmark_fitler=x' is no flag"),
        (["extra"], "'extra' is no flag"),
        (["--benchmark_repetitions=many"], "'--benchmark_repetitions=many' is no flag, or has a value"),
        (["--benchmark_format=xml"], "has a value that it does not take"),
        (["--benchmark_time_unit=days"], "has a value that it does not take"),
        (["--benchmark_filter=nothing_of_the_kind"], "no benchmark matches"),
        (["--hdf5=/nowhere/times.h5"], "name a file in a folder that exists"),
        ([f"--hdf5={FOLDER}/flags_test.h5", "--benchmark_list_tests", BRIEF[0]], "--hdf5 keeps single times"),
    ):
        done = run(*flags, status=2)
        assert part in done.stderr and part not in done.stdout, (flags, done.stderr)
        assert "benchmark [--" not in done.stdout, done.stdout


for name, test in list(globals().items()):
    if name.startswith("test_"):
        test()
        print(f"{name}: passed")
