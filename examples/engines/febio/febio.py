#!/usr/bin/env python3
"""Runs the job of FEBio 4 that `livermark export` writes of a problem or a scene, for `livermark score`.

    febio.py out/beam/beam_bend.problem.h5 solution.csv                       after livermark export ... --format febio
    febio.py out/liver_healthy/press_and_slide.scene.h5 motion.h5

--contact facet keeps the facets of a body out of a ball that touches, --contact node its nodes alone. The adapter calls
`febio4 -i` on the .feb beside the problem or scene, and reads what FEBio writes as text: blocks of "*Step", "*Time" and "*Data"
lines, then a line "node,ux,uy,uz" for each node. Needs febio4 on the PATH.
"""
import pathlib
import re
import sys
import tempfile

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import files  # noqa: E402


KNOWS = ["mesh/modulus_factor", "load_case/foundation", "capsule", "vessels"]  # which the job has


def read_blocks(path):
    """Times (B) and values (B, N, 3) of a text file of FEBio, in the order of the numbers of its nodes or rigid bodies."""
    times, blocks = [], []
    try:
        for line in path.read_text().splitlines() if path.exists() else []:
            if line.startswith("*Time"):
                times.append(float(line.split("=")[1]))
                blocks.append([])
            elif line.strip() and not line.startswith("*"):
                blocks[-1].append([float(word) for word in line.split(",")])
        tables = [sorted(block) for block in blocks]
        values = numpy.array(tables)
        return numpy.array(times), values[:, :, 1:4].copy()
    except (ValueError, IndexError):
        files.stop(f"FEBio wrote no table into {path.name}; run febio4 -i on the .feb and see its log")


def displacement_at_rest(times, values):
    """Of the whole load, which is that of time 1, shape (N, 3)."""
    if not len(times) or abs(times[-1] - 1.0) > 1e-9:
        files.stop(f"FEBio stopped at {times[-1] if len(times) else 0.0:g} of the load; run febio4 -i on the .feb and see its log")
    return values[-1]


def displacement_of_records(record_times, times, values):
    """At each record, shape (K, N, 3): FEBio takes several steps in a frame, and begins after the first record, at rest."""
    chosen = []
    for time in record_times[1:]:
        nearest = int(numpy.argmin(abs(times - time))) if len(times) else 0
        if not len(times) or abs(times[nearest] - time) > 1e-6:
            files.stop(f"FEBio stopped before {time:.3f} s; run febio4 -i on the .feb and see its log")
        chosen.append(values[nearest])
    return numpy.array([numpy.zeros_like(chosen[0]), *chosen])


def main():
    source, output, settings = files.command_line({"contact": "facet"})
    if settings["contact"] not in ("facet", "node"):
        files.stop("--contact is facet or node")
    ball = None if files.is_scene(source) else files.read_ball(source)
    febio = files.program("febio4", "build FEBio 4 as README.md says")
    job = files.stem_of(source).with_suffix(".feb").resolve()
    if not job.is_file():
        files.stop(f"{job} does not exist; write it with livermark export --format febio")
    with tempfile.TemporaryDirectory() as folder:
        contact = f"sliding-{settings['contact']}-on-facet"
        (pathlib.Path(folder) / job.name).write_text(job.read_text().replace("sliding-facet-on-facet", contact))
        ran = files.run([febio, "-i", job.name], folder)
        times, values = read_blocks(pathlib.Path(folder) / f"{job.stem}.displacement.csv")
        pushed = read_blocks(pathlib.Path(folder) / f"{job.stem}.force.csv")[1] if ball else None
    version = re.search(r"[Vv]ersion\s+(\d[\w.]*)", ran.printed)
    numbers = {"setup_seconds": 0.0, "solve_seconds": ran.seconds, "memory_bytes": ran.memory}
    if files.is_scene(source):
        scene = files.read_scene(source)
        displacement = displacement_of_records(scene.time, times, values)
        frame = numbers["seconds_per_frame"] = ran.seconds / (len(scene.time) - 1)
        files.write_motion(output, displacement, files.neo_hookean_forces_on_tool(scene, displacement), frame)
    else:
        files.write_solution(output, files.read_problem(source, KNOWS).points, displacement_at_rest(times, values))
        numbers["seconds_per_frame"] = None
        if ball:
            numbers["force"] = float(numpy.linalg.norm(pushed[-1, 0]))
    if not ball:
        del settings["contact"]
    files.report("febio", version[1] if version else "unknown", settings, **numbers)


main()
