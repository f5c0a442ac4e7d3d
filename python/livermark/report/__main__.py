"""Writes the report of a folder: python3 -m livermark.report [--figures FOLDER] < TABLES.json > PAGE.html

`livermark report` calls it, with what it has read of the files. In place of a page it gets three lines, "left out", a file and a
sentence, if h5py refuses that file: then it calls again without the file. With --figures the figures are files in that folder
too, and a line "figures", a line with the name of each, without its endings, and an empty line stand before the page.
"""
import json
import pathlib
import sys

from livermark.errors import InputError
from livermark.report import figure_files, page
from livermark.report.data import FileRefused, ReportData


def main(arguments: list[str]) -> None:
    folder = pathlib.Path(arguments[1]) if arguments[:1] == ["--figures"] else None
    told = json.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
    try:
        with figure_files.kept_in(folder) as files:
            text = page.make(ReportData(told))
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
