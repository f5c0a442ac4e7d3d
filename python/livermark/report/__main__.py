"""Writes the report of a folder: python3 -m livermark.report [--figures FOLDER] [--slices FILE] < TABLES.json > PAGE.html

`livermark report` calls it, with what it has read of the files. In place of a page it gets three lines, "left out", a file and a
sentence, if h5py refuses that file: then it calls again without the file. With --figures the figures are files in that folder
too, and a line "figures", a line with the name of each, without its endings, and an empty line stand before the page. With
--slices a JSON file has for some bodies a load case, and slices of their image as livermark.report.slices reads them.
"""
import argparse
import json
import pathlib
import sys

from livermark.errors import InputError
from livermark.report import figure_files, page
from livermark.report.data import FileRefused, ReportData


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="livermark.report")
    for option in ("--figures", "--slices"):
        parser.add_argument(option, type=pathlib.Path)
    options = parser.parse_args(arguments)
    slices = json.loads(options.slices.read_text(encoding="utf-8")) if options.slices else {}
    told = json.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
    try:
        with figure_files.kept_in(options.figures) as files:
            text = page.make(ReportData(told, slices))
        if files:
            text = "\n".join(["figures", *files.names, "", text])
    except FileRefused as refused:
        sentence = " ".join(str(refused).split())
        text = f"left out\n{refused.file}\n{sentence}\n"
    except InputError as error:
        sys.exit(f"{error}")
    except figure_files.NotWritten as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    sys.stdout.buffer.write(text.encode("utf-8", errors="surrogateescape"))


if __name__ == "__main__":
    main(sys.argv[1:])
