"""Copies a result file with changes.
usage: python3 change_h5py.py FROM.h5 TO.h5, and on stdin a JSON object of any of
  "body": name, "scale": factor of all static displacements, "nan": [dataset, row, and column if there are any], "narrow": dataset that loses its columns,
  "delete": dataset, "set": [dataset, row or null for all, value], "shorten": [dataset, how many of its last rows it loses],
  "unname": [dataset, attribute that it loses], "attribute": [group or dataset, name, value],
  "link": [dataset that becomes a link, the file it leads to]
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
        path, *place = changes["nan"]
        file[path][tuple(place)] = np.nan
    if "narrow" in changes:
        values = file[changes["narrow"]][:, 0]
        del file[changes["narrow"]]
        file[changes["narrow"]] = values
    if "delete" in changes:
        del file[changes["delete"]]
    if "set" in changes:
        path, row, value = changes["set"]
        file[path][... if row is None else row] = value
    if "unname" in changes:
        path, name = changes["unname"]
        del file[path].attrs[name]
    if "attribute" in changes:
        path, name, value = changes["attribute"]
        file[path].attrs[name] = value
    if "link" in changes:
        path, target_file = changes["link"]
        del file[path]
        file[path] = h5py.ExternalLink(target_file, path)
    if "shorten" in changes:
        path, count = changes["shorten"]
        values = file[path][:-count]
        del file[path]
        file[path] = values
