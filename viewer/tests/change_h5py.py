"""Copies a result file with changes.
usage: python3 change_h5py.py FROM.h5 TO.h5, and on stdin a JSON object of any of
  "body": name, "scale": factor of all static displacements, "nan": [dataset, row, column], "narrow": dataset that loses its columns
"""
import json
import shutil
import sys

import h5py
import numpy as np

source, target = sys.argv[1:]
changes = json.load(sys.stdin)
shutil.copy(source, target)
with h5py.File(target, "r+") as file:
    if "body" in changes:
        file.attrs["body"] = np.bytes_(changes["body"])
    if "scale" in changes:
        for solution in file["solutions"].values():
            solution["displacement"][...] *= changes["scale"]
    if "nan" in changes:
        path, row, column = changes["nan"]
        file[path][row, column] = np.nan
    if "narrow" in changes:
        values = file[changes["narrow"]][:, 0]
        del file[changes["narrow"]]
        file[changes["narrow"]] = values
