#!/usr/bin/env python3
"""Solves a problem of `livermark export` with CalculiX, for `livermark score`.

    calculix.py out/liver_healthy/large_traction.problem.h5 solution.csv

It runs the .inp beside the problem: linear tetrahedra (C3D4), or those with ten nodes (C3D10) of `livermark export --quadratic`.
A large load case has NLGEOM and neo-Hookean tissue there. Needs ccx on the PATH (Debian: calculix-ccx).
"""
import pathlib
import re
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import files  # noqa: E402


def read_nodes(job):
    """Coordinates of each node of an .inp, by number."""
    nodes, is_node = {}, False
    for line in job.read_text().splitlines():
        if line.startswith("*"):
            is_node = line.startswith("*NODE,")
        elif is_node:
            number, *x = line.split(", ")
            nodes[int(number)] = x
    return nodes


def read_displacements(dat):
    """Displacement of each node, by number. The last block of a .dat is that of the whole load."""
    blocks = []
    for line in dat.read_text().splitlines() if dat.exists() else []:
        words = line.split()
        if line.lstrip().startswith("displacements"):
            blocks.append({})
        elif len(words) == 4 and blocks:
            blocks[-1][int(words[0])] = words[1:]
    return blocks[-1] if blocks else files.stop("CalculiX did not come to the whole load; run ccx on the .inp and see its log")


def main():
    problem, solution, settings = files.command_line({})
    if files.is_scene(problem):
        files.stop("the job of a moving tool is not exported for CalculiX; choose a load case at rest")
    files.refuse_ball(problem, files.read_ball(problem))
    ccx = files.program("ccx", "install the Debian package calculix-ccx")
    job = files.stem_of(problem).with_suffix(".inp").resolve()
    if not job.is_file():
        files.stop(f"{job} does not exist; write it with livermark export --format calculix")
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "job.inp").symlink_to(job)
        ran = files.run([ccx, "job"], folder)
        nodes, displacements = read_nodes(job), read_displacements(pathlib.Path(folder) / "job.dat")
    numbers = list(displacements)
    files.write_solution(solution, numpy.array([nodes[i] for i in numbers], float),
                         numpy.array([displacements[i] for i in numbers], float))
    version, seconds = re.search(r"Version (\S+?),?\s", ran.printed), re.search(r"Total CalculiX Time:\s*(\S+)", ran.printed)
    elements = "C3D10" if "TYPE=C3D10" in job.read_text() else "C3D4"
    files.report("calculix", version[1] if version else "unknown", {**settings, "elements": elements}, seconds_per_frame=None,
                 setup_seconds=0.0, solve_seconds=float(seconds[1]) if seconds else ran.seconds, memory_bytes=ran.memory)


main()
