"""sweep_test.py local|slurm LIVERMARK: a small sweep by Snakemake. Exit status 77, a skipped test, where programs are missing.

local   all runs are there, one that cannot be done is named and stops no other, and a second call does nothing again
slurm   the same sweep as jobs of a Slurm of its own, one of them killed, gives the same numbers after a second call
"""
import csv
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from private_slurm import PrivateSlurm, missing_programs, wait_for

WORKFLOW = pathlib.Path(__file__).resolve().parents[2] / "workflow"
TIMES = {"solve_seconds", "run_seconds"}


def snakemake(folder, profile, livermark, environment=None, load_cases="[traction,palpation]"):
    command = ["snakemake", "--snakefile", WORKFLOW / "Snakefile", "--profile", WORKFLOW / "profiles" / profile,
               "--directory", folder, "--config", "output=sweep", "bodies=[]", "variants=1", "tetrahedra=2000",
               "contrasts=[5,10]", "poisson_ratios=[0.45]", f"load_cases={load_cases}", "models=[lloyd,fem_p1]",
               "run_options=--reference-on-mesh", "mem_mb=500", f"livermark={livermark}"]
    folder.mkdir(exist_ok=True)
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def finish(process, status=0):
    printed = process.communicate(timeout=500)[0]
    assert process.returncode == status, printed
    return printed


def index(folder):
    with open(folder / "sweep/index.csv", newline="") as file:
        return [{name: value for name, value in row.items() if name not in TIMES} for row in csv.DictReader(file)]


def check_local(folder, livermark):
    finish(snakemake(folder, "local", livermark, load_cases="[traction,no_such_case]"))
    rows = index(folder)
    failed = [row for row in rows if row["status"] == "failed"]
    assert {row["load_case"] for row in failed} == {"no_such_case"} and len(failed) == 2, rows
    assert all("no_such_case" in row["message"] for row in failed), failed
    done = [row for row in rows if row["load_case"] == "traction"]
    assert len(done) == 8 and all(row["status"] == "ok" for row in done), rows
    with h5py.File(folder / "sweep/dataset.h5") as file:
        names = file["index/model"].asstr()[:]
        errors = file["index/relative_l2"][:]
        assert len(names) == len(rows)
        for k, row in enumerate(rows):
            if row["model"] == "lloyd":
                linked = file["runs/liver_variant_1"][f"contrast_{float(row['contrast']):g}/poisson_0.45/traction"]
                assert errors[k] == linked["comparisons/lloyd"].attrs["relative_l2"] > 0.0
        moduli = {contrast: file[f"runs/liver_variant_1/contrast_{contrast}/poisson_0.45/traction/materials/young_modulus"][:]
                  for contrast in (5, 10)}
        for contrast, modulus in moduli.items():
            assert len(modulus) > 1 and all(abs(m / modulus[0] - contrast) < 1e-12 for m in modulus[1:]), moduli
    assert "Nothing to be done" in finish(snakemake(folder, "local", livermark, load_cases="[traction,no_such_case]"))


def check_slurm(folder, livermark):
    finish(snakemake(folder / "here", "local", livermark))
    slow = folder / "slow_livermark"  # so that there is a run to kill
    slow.write_text(f'#!/bin/sh\n[ "$1" = run ] && sleep 4\nexec {livermark} "$@"\n')
    slow.chmod(0o755)
    with PrivateSlurm(folder / "slurm") as environment:
        def running():
            return subprocess.run(["squeue", "--noheader", "--states=RUNNING", "--name=livermark.run", "--format=%i"],
                                  env=environment, capture_output=True, text=True).stdout.split()
        sweep = snakemake(folder / "there", "slurm", slow, environment)
        wait_for(lambda: running() or sweep.poll() is not None, "no run has begun", 200)
        killed = running()[0]
        time.sleep(1)
        subprocess.run(["scancel", killed], env=environment, check=True)
        finish(sweep, status=1)
        assert not (folder / "there/sweep/dataset.h5").exists(), "a dataset without the run that was killed"
        done = len(list((folder / "there/sweep").glob("runs/*/*/*/*/status.json")))
        assert done == 3, f"{done} runs are done beside the one that was killed"
        finish(snakemake(folder / "there", "slurm", slow, environment))
    here, there = index(folder / "here"), index(folder / "there")
    assert here == there, (here, there)
    print(f"job {killed} was killed and done again; {len(here)} rows are the same as without Slurm")


def main():
    kind, livermark = sys.argv[1:]
    missing = [] if shutil.which("snakemake") else ["snakemake"]
    if kind == "slurm":
        missing += missing_programs()
    if missing:
        print(f"skipped: {', '.join(missing)} missing; scripts/install-cluster-tools installs them")
        sys.exit(77)
    os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp()
    folder = pathlib.Path(tempfile.mkdtemp())
    try:
        {"local": check_local, "slurm": check_slurm}[kind](folder, livermark)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        shutil.rmtree(os.environ["XDG_CACHE_HOME"], ignore_errors=True)


main()
