"""What several tests share: the result files of a run of the program, and a small bar."""
import os
import pathlib

import h5py
import numpy
import pytest

BINARY = os.environ["LIVERMARK_BINARY"]
RUNS = pathlib.Path(os.environ["LIVERMARK_PYTHON_RUNS"])


@pytest.fixture
def bending():
    """The static result file of the program's run."""
    with h5py.File(RUNS / "beam" / "beam_bend.h5") as file:
        yield file


@pytest.fixture
def release():
    """The result file of a motion of the program's run."""
    with h5py.File(RUNS / "beam" / "beam_release.h5") as file:
        yield file


@pytest.fixture
def bar():
    """Points [m] and tetrahedra of a cube of 10 mm."""
    points = 0.01 * numpy.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
    tetrahedra = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
    return points, numpy.array(tetrahedra)


def arguments_of(file):
    """Arguments of livermark.springs() for the body of a result file."""
    region = file["mesh/region"][:]
    of_each = {name: file["materials"][name][:][region] for name in ("young_modulus", "poisson_ratio", "density")}
    return {"points": file["mesh/points"][:], "tetrahedra": file["mesh/tetrahedra"][:], **of_each}
