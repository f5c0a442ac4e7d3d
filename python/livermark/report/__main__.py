"""Writes the report of a folder: python3 -m livermark.report TABLES.json PAGE.html

`livermark report` calls it, with what it has read of the files.
"""
import pathlib
import sys

from livermark.report import page
from livermark.report.data import ReportData


def main(tables: str, output: str) -> None:
    html = page.make(ReportData.read(pathlib.Path(tables)))
    pathlib.Path(output).write_text(html, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
