"""The whole page."""
from __future__ import annotations

from markupsafe import Markup

from livermark.report import figures, head
from livermark.report.data import ReportData
from livermark.report.parts import TEMPLATES, environment
from livermark.report.sections import SECTIONS, experiments, needles, numbers, sensitivity


def make(data: ReportData) -> str:
    """The same files give the same bytes."""
    parts = (experiments, needles, sensitivity, numbers) if data.has_no_results else SECTIONS
    sections = [section for part in parts if (section := part.section(data))]
    template = environment.get_template("page.html.j2")
    return figures.numbered(template.render(
        style=Markup((TEMPLATES / "style.css").read_text(encoding="utf-8")), findings=head.findings(data),
        facts=head.facts(data), lead=head.lead(data), sections=sections))
