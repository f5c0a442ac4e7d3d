#!/usr/bin/env python3
"""A small engine that Livermark judges: extended position-based dynamics of neo-Hookean tetrahedra (Macklin and Mueller 2021,
Motion, Interaction and Games) in NumPy.

usage: xpbd_engine.py SCENE MOTION [SUBSTEPS]     SCENE of `livermark export BODY press_and_slide`, MOTION for `livermark score`
"""
import sys
import time

import h5py
import numpy

scene_file, motion_file, substeps = sys.argv[1], sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 10
with h5py.File(scene_file) as scene:
    rest, tetrahedra, region, held = (scene[name][:] for name in ("points", "tetrahedra", "region", "held"))
    density, young, nu = (scene[f"materials/{name}"][:][region] for name in ("density", "young_modulus", "poisson_ratio"))
    tool, way, times = (scene[f"tool/{name}"][:] for name in ("nodes", "displacement", "time"))
    last_held, damping = int(scene["tool"].attrs["last_record_held"]), float(scene["tool"].attrs["mass_damping"])

edges = numpy.moveaxis(rest[tetrahedra[:, 1:]] - rest[tetrahedra[:, :1]], 1, 2)  # (M, 3, 3), an edge in each column
volume, to_rest = numpy.linalg.det(edges) / 6.0, numpy.linalg.inv(edges)
mu, lame = young / (2.0 + 2.0 * nu), young * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
mass = numpy.bincount(tetrahedra.ravel(), numpy.repeat(0.25 * density * volume, 4), len(rest))

# Tetrahedra of one colour share no node, so they are solved together.
colour, used = numpy.zeros(len(tetrahedra), int), [0] * len(rest)
for t, corners in enumerate(tetrahedra):
    taken = used[corners[0]] | used[corners[1]] | used[corners[2]] | used[corners[3]]
    colour[t] = (~taken & (taken + 1)).bit_length() - 1
    for node in corners:
        used[node] |= 1 << int(colour[t])
batches = [numpy.flatnonzero(colour == c) for c in range(colour.max() + 1)]


def constraints(x, batch):
    """Values (B, 2) and slopes (B, 2, 4, 3) of |F| and det F - 1 - mu / lambda."""
    f = numpy.moveaxis(x[tetrahedra[batch, 1:]] - x[tetrahedra[batch, :1]], 1, 2) @ to_rest[batch]
    size = numpy.sqrt((f * f).sum(axis=(1, 2)))
    cofactors = numpy.stack([numpy.cross(f[:, :, 1], f[:, :, 2]), numpy.cross(f[:, :, 2], f[:, :, 0]),
                             numpy.cross(f[:, :, 0], f[:, :, 1])], axis=2)
    values = numpy.stack([size, (f[:, :, 0] * cofactors[:, :, 0]).sum(axis=1) - 1.0 - mu[batch] / lame[batch]], axis=1)
    by_f = numpy.stack([f / size[:, None, None], cofactors], axis=1)  # (B, 2, 3, 3)
    slopes = numpy.swapaxes(by_f @ numpy.swapaxes(to_rest[batch], 1, 2)[:, None], 2, 3)
    return values, numpy.concatenate([-slopes.sum(axis=2, keepdims=True), slopes], axis=2)


def force_on_tool(x):
    """Of the elastic energy, half of stiffness times value squared [N]."""
    near = numpy.flatnonzero(numpy.isin(tetrahedra, tool).any(axis=1))
    values, slopes = constraints(x, near)
    pull = numpy.stack([mu[near], lame[near]], axis=1) * volume[near, None] * values
    return -(pull[:, :, None, None] * slopes).sum(axis=1)[numpy.isin(tetrahedra[near], tool)].sum(axis=0)


x, v = rest.copy(), numpy.zeros_like(rest)
motion, forces, begin = [x - rest], [force_on_tool(x)], time.process_time()
for k in range(1, len(times)):
    h = (times[k] - times[k - 1]) / substeps
    weight = 1.0 / mass
    weight[held] = 0.0
    if k <= last_held:
        weight[tool] = 0.0
    for s in range(1, substeps + 1):
        before = x.copy()
        v *= numpy.exp(-damping * h)
        x = x + h * numpy.where(weight[:, None] > 0.0, v, 0.0)
        if k <= last_held:
            x[tool] = rest[tool] + way[k - 1] + s / substeps * (way[k] - way[k - 1])
        for batch in batches:
            values, slopes = constraints(x, batch)
            weighted = weight[tetrahedra[batch]][:, None, :, None] * slopes
            matrix = numpy.einsum("bikc,bjkc->bij", weighted, slopes)
            compliance = 1.0 / (numpy.stack([mu[batch], lame[batch]], axis=1) * volume[batch, None] * h * h)
            matrix[:, [0, 1], [0, 1]] += compliance
            multiplier = numpy.linalg.solve(matrix, -values[:, :, None])
            x[tetrahedra[batch]] += (multiplier[:, :, :, None] * weighted).sum(axis=1)
        v = (x - before) / h
    motion.append(x - rest)
    forces.append(force_on_tool(x))
with h5py.File(motion_file, "w", libver="latest") as file:
    file["displacement"] = numpy.array(motion, "f4")
    file["force"] = numpy.array(forces)
    file.attrs["seconds_per_frame"] = (time.process_time() - begin) / (len(times) - 1)
