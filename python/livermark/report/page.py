"""The whole page."""
from __future__ import annotations

from markupsafe import Markup

from livermark.report import figures, head
from livermark.report.data import ReportData
from livermark.report.parts import TEMPLATES, environment
from livermark.report.sections import SECTIONS


def make(data: ReportData) -> str:
    """The same files give the same bytes."""
    verdicts = head.verdicts(data)
    made = [(part, part.section(data)) for part in SECTIONS]
    absent = [(part.TITLE, part.COMMAND) for part, section in made if section is None]
    template = environment.get_template("page.html.j2")
    return figures.numbered(template.render(
        style=Markup((TEMPLATES / "style.css").read_text(encoding="utf-8")), title=head.title(data), lead=head.lead(data),
        verdicts=verdicts, facts=head.facts(data), sections=[section for _, section in made if section],
        absent=absent))
