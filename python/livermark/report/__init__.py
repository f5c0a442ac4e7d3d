"""The HTML report of a folder of result files, which `livermark report` makes. See docs/report.md."""
