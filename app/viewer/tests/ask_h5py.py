"""Says what h5py reads of a result file, an answer of JSON for each line that asks.
usage: python3 ask_h5py.py FILE.h5, and on stdin  {"path": dataset, "row": index or null}  or  {"path": ..., "attribute": name}
"""
import json
import sys

import h5py

with h5py.File(sys.argv[1], "r") as file:
    for line in sys.stdin:
        question = json.loads(line)
        item = file[question["path"]]
        if "attribute" in question:
            answer = item.attrs[question["attribute"]]
        else:
            answer = item[()] if question["row"] is None else item[question["row"]]
        if answer.dtype.kind == "S":
            answer = answer.astype(str)
        print(json.dumps(answer.tolist()), flush=True)
