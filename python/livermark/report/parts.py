"""The pieces of HTML that sections are made of, by templates/parts.html.j2: texts are escaped there and nowhere else."""
from __future__ import annotations

import pathlib
from typing import NamedTuple

import jinja2
from markupsafe import Markup

TEMPLATES = pathlib.Path(__file__).parent / "templates"


class Section(NamedTuple):
    """A part of the report."""
    name: str  #: the target of links: letters and dashes
    title: str
    html: Markup


def shown_command(command: str) -> str:
    """A command line without the folders of the program: where somebody has built it is nobody's business."""
    before, program, after = command.partition("/livermark ")
    return program[1:] + after if program else before


environment = jinja2.Environment(loader=jinja2.FileSystemLoader(TEMPLATES), autoescape=True, trim_blocks=True,
                                 lstrip_blocks=True, undefined=jinja2.StrictUndefined)
environment.filters["shown_command"] = shown_command
environment.filters["each_once"] = lambda commands: list(dict.fromkeys(filter(None, commands)))
_macros = environment.get_template("parts.html.j2").module

bullets = _macros.bullets
choice = _macros.choice
code = _macros.code
figure = _macros.figure
missing = _macros.missing
name = _macros.name
paragraph = _macros.paragraph
share = _macros.share
subsection = _macros.subsection
table = _macros.table
terms = _macros.terms


def plots(pictures: list[Markup]) -> Markup:
    """Several pictures, side by side where there is room."""
    return Markup('<div class="plots">\n{}</div>\n').format(Markup("").join(pictures))
