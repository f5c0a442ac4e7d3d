"""Writes the report of a folder: python3 -m livermark.report < TABLES.json > PAGE.html

`livermark report` calls it, with what it has read of the files.
"""
import json
import sys

from livermark.report import page
from livermark.report.data import ReportData


def main() -> None:
    told = json.loads(sys.stdin.buffer.read().decode("utf-8", errors="replace"))
    sys.stdout.buffer.write(page.make(ReportData(told)).encode("utf-8"))


if __name__ == "__main__":
    main()
