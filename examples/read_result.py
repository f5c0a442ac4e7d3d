#!/usr/bin/python3
"""Prints how far each model of a result file is from the reference, and where it is furthest.

    examples/read_result.py results/runs/liver_healthy/palpation.h5
"""
import sys

import h5py
import numpy


def text(item, name):
    """Texts are UTF-8 of fixed length, which h5py gives as bytes."""
    return item.attrs[name].decode()


with h5py.File(sys.argv[1], "r") as file:
    points = file["/mesh/points"][:]
    print(f"{text(file, 'body')}, {text(file['/load_case'], 'name')}: {len(points)} nodes")
    for name, comparison in file["/comparisons"].items():
        if "error" not in comparison:
            continue  # it did not come to an end
        error = numpy.linalg.norm(comparison["error"][:], axis=1)
        if not numpy.isfinite(error).all():
            print(f"{name}: diverged")
            continue
        x, y, z = 1000.0 * points[error.argmax()]
        print(f"{name}: {100.0 * comparison.attrs['relative_l2']:.2f} % off {text(comparison, 'reference')}, "
              f"at most {1000.0 * error.max():.3f} mm at ({x:.1f}, {y:.1f}, {z:.1f}) mm")
