#!/usr/bin/env python3
"""Solves a load case with CalculiX, and scores what it finds.

    examples/score_calculix.py liver_healthy large_traction out

writes out/liver_healthy/large_traction.{inp,dat,csv} and prints the table of `livermark score`. The job that
`livermark export` writes of a large load case says NLGEOM, and has neo-Hookean linear tetrahedra (C3D4). Needs ccx on the
PATH (Debian: calculix-ccx), and the program livermark there or in the environment variable LIVERMARK.
"""
import os
import pathlib
import subprocess
import sys

LIVERMARK = os.environ.get("LIVERMARK", "livermark")


def read_nodes(job):
    """Coordinates of each node of an .inp, by number, as they are written there."""
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
    for line in dat.read_text().splitlines():
        words = line.split()
        if line.lstrip().startswith("displacements"):
            blocks.append({})
        elif len(words) == 4 and blocks:
            blocks[-1][int(words[0])] = words[1:]
    if not blocks:
        sys.exit(f"{dat} has no displacements: CalculiX did not come to the whole load; see its log")
    return blocks[-1]


def main(body, load_case, folder):
    subprocess.run([LIVERMARK, "export", body, load_case, "-o", folder], check=True, stdout=subprocess.DEVNULL)
    job = next(pathlib.Path(folder).glob(f"*/{load_case}.inp"))
    with open(job.with_suffix(".log"), "w") as log:
        subprocess.run(["ccx", job.stem], cwd=job.parent, check=True, stdout=log)
    nodes, displacements = read_nodes(job), read_displacements(job.with_suffix(".dat"))
    solution = job.with_suffix(".csv")
    with open(solution, "w") as csv:
        print("x,y,z,ux,uy,uz", file=csv)
        for number, x in nodes.items():
            print(",".join([*x, *displacements[number]]), file=csv)
    subprocess.run([LIVERMARK, "score", body, load_case, solution, "--name", "calculix", "--model", "fem_p1_neo_hookean",
                    "--reference-on-mesh", "--markdown", "--output", folder], check=True)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit("usage: score_calculix.py BODY LOAD_CASE FOLDER")
    main(*sys.argv[1:])
