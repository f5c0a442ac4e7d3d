"""The terms of a report, each defined once, before the first part that uses it."""
from __future__ import annotations

from typing import NamedTuple

from markupsafe import Markup

from livermark.report.data import ReportData
from livermark.report.parts import name, terms
from livermark.studies.tables import PERCENT


class Term(NamedTuple):
    words: str
    definition: str


def _terms(data: ReportData) -> list[Term]:
    felt = f"{PERCENT * data.smallest_felt_difference:.0f} %"
    found = [
        Term("Mesh, region", "The body cut into tetrahedra. A region is a part of it that is one material."),
        Term("Load case", "What holds the body, and what presses, pulls or moves it."),
        Term("Model", "A way to compute how the body moves. Finite elements (fem_...) divide its energy over the tetrahedra; fem_p1, linear "
             "tetrahedra, is what most programs take."),
        Term("Springs", "Masses on the nodes of the mesh, and forces between them. Plain springs pull along their own edges. Coupled springs "
             "(nodal_...) act by the mean strain of the tetrahedra around a node."),
        Term("Reference", "The judge: finite elements, on finer meshes where a file has them. What refinement would still change is its own error, "
             "which stands behind ±."),
        Term("Error in position (L2)", "The distance between model and reference, as a share of how far the reference moves: root mean squares "
             "over the volume of the body."),
        Term("Tool", "The place that a load case presses, pulls or moves. Its stiffness is its force divided by its displacement."),
        Term("Error under the tool", "The stiffness of the model over that of the reference, minus 1. Positive is too stiff. "
             f"A hand feels a difference from {felt} on.")]
    if data.results:
        found.append(Term("Small loads", "Loads that move the body so little that linear elasticity is right."))
    if data.large:
        found.append(Term("Loads of surgical size", "Loads that move the body by millimetres to centimetres, judged by elements that know "
                          "large deformations."))
    return found


def summaries(data: ReportData) -> list[tuple[str, str]]:
    """Each model and what its files say of it, in the order in which they appear."""
    said: dict[str, str] = {}
    for result in [*data.results, *data.large]:
        for model in result.models.values():
            said.setdefault(model.name, model.summary)
    return [(name, summary) for name, summary in said.items() if summary]


def section(data: ReportData) -> Markup:
    """The list, which is open, and that of the models, which is folded."""
    if not data.results and not data.large:
        return Markup("")
    html = terms([(term.words, term.definition) for term in _terms(data)])
    models = summaries(data)
    if models:
        html += Markup("<details>\n<summary>The {} models of this report</summary>\n{}</details>\n").format(
            len(models), terms([(name(model) , summary) for model, summary in models]))
    return html
