"""merge.py FOLDER: one dataset of all runs in FOLDER/runs.

FOLDER/dataset.h5 has the columns of a table in /index, a row for each model of each run and one for each run that failed,
and links to the result files in /runs. FOLDER/index.csv is the same table. With pandas:

    import h5py, pandas
    with h5py.File("dataset.h5") as file:
        index = pandas.DataFrame({name: column.asstr()[:] if column.dtype.kind == "O" else column[:]
                                  for name, column in file["index"].items()})
"""
import csv
import json
import os
import pathlib
import sys

import h5py

TEXTS = ["body", "load_case", "model", "status", "message", "file"]
NUMBERS = ["contrast", "poisson_ratio", "relative_l2", "reaction_error", "stiffness_at_tool", "uncertainty", "solve_seconds",
           "run_seconds"]


def rows_of(folder, status_file):
    """The rows of one run. Numbers that a run does not have are NaN."""
    body, contrast, poisson, load_case = status_file.parent.relative_to(folder / "runs").parts
    status = json.loads(status_file.read_text())
    common = {name: float("nan") for name in NUMBERS} | {
        "body": body, "contrast": float(contrast.removeprefix("contrast_")),
        "poisson_ratio": float(poisson.removeprefix("poisson_")), "load_case": load_case, "model": "",
        "status": status["status"], "message": status["message"], "file": "", "run_seconds": status["seconds"]}
    if not status["files"]:
        yield common
    for name in status["files"]:
        path = status_file.parent / name
        try:
            yield from list(rows_of_file(folder, path, common))
        except (OSError, RuntimeError, KeyError) as error:  # of h5py on a damaged file, which leaves the others as they are
            yield common | {"status": "unreadable", "message": f"{path}: cannot be read ({error}); make it again"}


def rows_of_file(folder, path, common):
    with h5py.File(path) as file:
        uncertainty = file["reference"].attrs.get("reference_uncertainty", float("nan")) if "reference" in file else float("nan")
        for model, solution in file["solutions"].items():
            row = common | {"model": model, "file": os.path.relpath(path, folder), "uncertainty": uncertainty,
                            "status": text(solution.attrs["status"]), "message": text(solution.attrs["message"]),
                            "solve_seconds": solution.attrs["solve_seconds"]}
            if model in file.get("comparisons", {}):
                comparison = file["comparisons"][model].attrs
                row |= {"relative_l2": comparison["relative_l2"], "reaction_error": comparison["reaction_error"],
                        "stiffness_at_tool": comparison.get("stiffness_at_tool", float("nan"))}
            yield row


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def main():
    folder = pathlib.Path(sys.argv[1])
    rows = [row for status in sorted(folder.glob("runs/*/*/*/*/status.json")) for row in rows_of(folder, status)]
    partial = folder / "dataset.h5.partial"
    with h5py.File(partial, "w") as file:
        for name in TEXTS:
            file.create_dataset(f"index/{name}", data=[row[name] for row in rows], dtype=h5py.string_dtype())
        for name in NUMBERS:
            file.create_dataset(f"index/{name}", data=[row[name] for row in rows], dtype="f8")
        for path in sorted({row["file"] for row in rows if row["file"]}):
            link = "/".join(pathlib.Path(path).parts[:-3])
            file[link] = h5py.ExternalLink(path, "/")
    partial.replace(folder / "dataset.h5")
    with open(folder / "index.csv", "w", newline="") as out:
        writer = csv.DictWriter(out, fieldnames=TEXTS + NUMBERS)
        writer.writeheader()
        writer.writerows(rows)
    failed = [row for row in rows if row["status"] != "ok"]
    print(f"{len(rows)} rows in {folder / 'dataset.h5'}, {len(failed)} of them failed")
    for row in failed:
        print("failed:", row["body"], f"contrast {row['contrast']:g}", f"Poisson's ratio {row['poisson_ratio']:g}",
              row["load_case"], row["model"], row["message"])


main()
