"""Every number, the files, and what was assumed."""
from __future__ import annotations

from markupsafe import Markup

from livermark.report.data import Column, ReportData, Table
from livermark.report.parts import Section, bullets, code, figure, paragraph, subsection, table

TITLE = "Every number, and where it comes from"
COMMAND = "livermark run"  # makes the files


def _files(data: ReportData) -> Table:
    columns = [Column(title) for title in ("file", "body", "load case", "commit", "created", "build")]
    return Table(columns, [[result.file, result.label, result.title, result.provenance["git_commit"][:12],
                            result.provenance["created"], result.provenance["build_type"]] for result in data.results])


def section(data: ReportData) -> Section:
    html = Markup("")
    if data.results:
        all_numbers = figure(
            "table", table(data.tables["errors"]),
            "Every model under every load case: peak displacement, errors, stiffness at the tool, the reference's own error (±), nonlinearity "
            "and times.")
        files = figure("table", table(_files(data)), "The result files.")
        html += Markup('<div class="small">\n{}{}</div>\n').format(all_numbers, files)
    assumed = list(dict.fromkeys(f"{result.body}: {assumption}" for result in [*data.results, *data.large]
                                 for assumption in sorted(result.assumptions)))
    if assumed:
        html += subsection("Assumed of bodies", bullets(assumed))
    if data.others:
        remark = paragraph("Modes, calibrations and exported problems are not part of this report.")
        html += subsection("Files that are not shown", remark + bullets(data.others))
    html += subsection("To make this report again", code(data.command))
    return Section("numbers", TITLE, html)
