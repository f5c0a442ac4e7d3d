"""Writes the report of a folder: python3 -m livermark.report < TABLES.json > PAGE.html

`livermark report` calls it, with what it has read of the files. In place of a page it gets three lines, "left out", a file and a
sentence, if h5py refuses that file: then it calls again without the file.
"""
import json
import sys

from livermark.errors import InputError
from livermark.report import page
from livermark.report.data import FileRefused, ReportData


def main() -> None:
    told = json.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
    try:
        text = page.make(ReportData(told))
    except FileRefused as refused:
        sentence = " ".join(str(refused).split())
        text = f"left out\n{refused.file}\n{sentence}\n"
    except InputError as error:
        sys.exit(f"{error}")
    sys.stdout.buffer.write(text.encode("utf-8", errors="surrogateescape"))


if __name__ == "__main__":
    main()
