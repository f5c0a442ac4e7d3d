"""The first page of a report: a picture, the terms, what each body is, which models to trust there, and what it was made from."""
from __future__ import annotations

import math
from typing import NamedTuple, Optional

import matplotlib
import numpy
from markupsafe import Markup

from livermark.report import colours, figures, first_picture, patient, reference, surfaces, words
from livermark.report.data import ReportData, Result, cleaned, commands_of, number
from livermark.report.parts import bullets, figure, paragraph, plots, subsection
from livermark.report.reference import OWN_ERROR, of_reference, own_error, own_error_sentence
from livermark.studies.tables import MILLIMETRES, PERCENT, fixed
from livermark.vessels import vessels_of
from livermark.volumes import tetrahedron_volumes

MOST_NAMED = 3  # models of a kind that a sentence names
MOST_PANELS = 4  # bodies whose numbers are drawn
BASELINES = ("fem_p1", "fem_p1_neo_hookean")  # linear tetrahedra: what most programs take


class Numbers(NamedTuple):
    """The two numbers of a model on a body, medians over load cases; NaN where there is none."""
    model: str
    error: float
    stiffness: float  #: at the tool, its size
    is_spring_model: bool
    cells: list[str]  #: both as `livermark table --kind brief` prints them


def _numbers(rows: list[dict]) -> dict[str, list[Numbers]]:
    """By body."""
    bodies: dict[str, list[Numbers]] = {}
    for row in rows:
        bodies.setdefault(row["body"], []).append(
            Numbers(row["model"], number(row["error"]), number(row["stiffness"]), row["is_spring_model"], row["cells"]))
    return bodies


def best_springs(rows: list[Numbers]) -> list[Numbers]:
    """Those whose larger number is smallest first, so that both are good; as `livermark run` ends. Without a tool by position."""
    springs = [row for row in rows if row.is_spring_model and math.isfinite(row.error)]
    with_tool = [row for row in springs if math.isfinite(row.stiffness)]
    return sorted(with_tool or springs, key=lambda row: max(row.error, row.stiffness) if with_tool else row.error)


def _best_springs(rows: list[Numbers], felt: float) -> list[str]:
    best = best_springs(rows)[:MOST_NAMED]
    if best and math.isfinite(best[0].stiffness):
        names = ", ".join(f"{row.model} ({fixed(PERCENT * row.stiffness, 1)} and {fixed(PERCENT * row.error, 1)} %)" for row in best)
        return [f"The most accurate springs, by the larger error of that under the tool and that in position, are {names}. "
                f"A hand feels {PERCENT * felt:.0f} %."]
    names = ", ".join(f"{row.model} {fixed(PERCENT * row.error, 1)} %" for row in best)
    return [f"In position the most accurate springs are {names}."] if best else []


def _always_felt_right(cases: list[Result], felt: float) -> Optional[tuple[list[str], int]]:
    """The springs whose stiffness a hand cannot tell from the reference's under any load case, and of how many; None where no
    load case has a tool."""
    sizes: dict[str, list[float]] = {}
    for result in cases:
        for model in result.models.values():
            if result.counts and model.is_spring_model:
                sizes.setdefault(model.name, []).append(abs(model.stiffness) if model.status == "ok" else math.inf)
    sizes = {name: [size for size in of_model if not math.isnan(size)] for name, of_model in sizes.items()}
    sizes = {name: of_model for name, of_model in sizes.items() if of_model}
    good = sorted((max(of_model), name) for name, of_model in sizes.items() if max(of_model) <= felt)
    return ([name for _, name in good], len(sizes)) if sizes else None


def _sentences(rows: list[Numbers], cases: list[Result], felt: float) -> list[str]:
    sentences = _best_springs(rows, felt)
    if found := _always_felt_right(cases, felt):
        good, count = found
        sentences.append(f"Under every load case a hand could not tell {', '.join(good)} from the reference." if good else
                         f"A hand could tell each of the {count} spring models from the reference under some load case.")
    for row in rows:
        if row.model in BASELINES and math.isfinite(row.error):
            at_tool = f", and {fixed(PERCENT * row.stiffness, 1)} % under the tool" if math.isfinite(row.stiffness) else ""
            sentences.append(f"Linear tetrahedra ({row.model}) are {fixed(PERCENT * row.error, 1)} % off in position{at_tool}.")
    sentences.append(own_error_sentence(cases))
    failed = sorted({model.name for result in cases for model in result.models.values() if model.status != "ok"})
    if failed:
        sentences.append(f"Without a solution under some load case: {', '.join(failed)}.")
    return list(filter(None, sentences))


def _regions(result: Result) -> str:
    """What a body is, in a sentence."""
    with result.open() as file:
        points, corners, region = file.points, file.tetrahedra, file.region
        young, ratio = file.materials["young_modulus"], file.materials["poisson_ratio"]
        names = cleaned(file.region_names)
    volume = numpy.bincount(region, tetrahedron_volumes(points, corners), len(names))
    largest = int(volume.argmax())
    text = (f"{fixed(1e3 * volume.sum(), 2)} L in {len(corners):,} tetrahedra, mostly {names[largest]} with a Young's modulus of "
            f"{fixed(1e-3 * young[largest], 1)} kPa and a Poisson's ratio of {ratio[largest]:g}")
    others = [r for r in range(len(names)) if r != largest]
    if others:
        ends = (fixed(1e-3 * end, 1) for end in (young[others].min(), young[others].max()))
        text += (f"; {len(others)} other region{'s' if len(others) > 1 else ''} of {fixed(1e6 * volume[others].sum(), 1)} mL with "
                 + " to ".join(dict.fromkeys(ends)) + " kPa")
    return text + "."


def _parts(cases: list[Result]) -> list[str]:
    """What a body has besides its regions, and what it stands on, a sentence each."""
    with cases[0].open() as file:
        capsule, vessels, factor = file.capsule, vessels_of(file.vessels), file.modulus_factor
        region, young = file.region, file.materials["young_modulus"]
    sentences = []
    if capsule:
        sentences.append(f"Capsule: a membrane covers the surface, with a stiffness of {capsule['young_modulus'] * capsule['thickness']:.3g} "
                         "N/m, its Young's modulus times its thickness.")
    if vessels:
        ends = " to ".join(dict.fromkeys(f"{MILLIMETRES * end:.2g}" for end in (vessels.radius.min(), vessels.radius.max())))
        sentences.append(f"Vessels: tubes along {len(vessels.segments):,} straight segments, which are thinner than the tetrahedra and move "
                         f"with the tissue, {vessels.lengths.sum():.3g} m and {fixed(1e6 * vessels.volume, 1)} mL together, with radii of "
                         f"{ends} mm.")
    if factor is not None:
        moduli = 1e-3 * young[region] * factor
        sentences.append(f"Map of stiffness: each tetrahedron has a modulus of its own, from {fixed(moduli.min(), 1)} to "
                         f"{fixed(moduli.max(), 1)} kPa.")
    bedded = [text for result in cases if (text := _foundation(result))]
    if bedded:
        sentences.append("Foundations: elastic springs below parts of the surface stand for what lies around the body, "
                         f"{'; '.join(bedded)}.")
    return sentences


def _foundation(result: Result) -> str:
    """How stiff springs below facets are, and on which area; empty without."""
    with result.open() as file:
        foundation, points, triangles = file.foundation, file.points, file.boundary_triangles
    if not foundation:
        return ""
    area = numpy.linalg.norm(surfaces.area_vectors(triangles[foundation["facet"]], points), axis=1).sum()
    ends = " to ".join(dict.fromkeys(f"{end:.3g}" for end in (foundation["stiffness"].min(), foundation["stiffness"].max())))
    normal = foundation["normal_only"] != 0
    along = ", along the normal alone" if normal.all() else ", in parts along the normal alone" if normal.any() else ""
    return f"under {result.load_case} {ends} N/m^3 on {fixed(1e4 * area, 1)} cm^2{along}"


def _panel(title: str, kind: str, rows: list[Numbers], own_error: float, felt: float) -> Markup:
    """Both numbers of each model, the nearest in position first, and the reference's own error in position."""
    rows = [row for row in rows if math.isfinite(row.error)]
    rows.sort(key=lambda row: row.error, reverse=True)
    axes = figures.new_rows(title, "error, median over load cases [%]", [row.model for row in rows], 470, 19)
    values = [PERCENT * value for row in rows for value in row[1:3]]
    figures.set_logarithmic(axes, "x", {"x": [*values, PERCENT * felt, PERCENT * own_error]})
    with matplotlib.rc_context(figures.SETTINGS):
        if own_error > 0.0:
            axes.axvspan(axes.get_xlim()[0], PERCENT * own_error, color=colours.BAND, linewidth=0, zorder=0,
                         label=f"{OWN_ERROR}, {of_reference(own_error)} %")
        for y, row in enumerate(rows):
            axes.plot([PERCENT * row.error, PERCENT * row.stiffness], [y, y], color=colours.FAINT, linewidth=1, zorder=1)
        axes.plot([PERCENT * row.error for row in rows], range(len(rows)), linestyle="", marker="o", color=colours.BLUE,
                  label="in position")
        axes.plot([PERCENT * row.stiffness for row in rows], range(len(rows)), linestyle="", marker="D",
                  color=colours.VERMILION, label="under the tool")
        axes.axvline(PERCENT * felt, color=colours.VERMILION, linewidth=1, linestyle=":", zorder=0)
    return figures.finish(axes, kind)


def _of_label(results: list[Result]) -> dict[str, list[Result]]:
    return {label: [result for result in results if result.label == label]
            for label in dict.fromkeys(result.label for result in results)}


class _Regime(NamedTuple):
    """Results of small or of large loads, by body."""
    size: str
    title: str
    cases: dict[str, list[Result]]
    numbers: dict[str, list[Numbers]]

    def counted(self, label: str) -> list[Result]:
        return [result for result in self.cases.get(label, ()) if result.counts]


def _regimes(data: ReportData) -> list[_Regime]:
    return [_Regime("small", "Small loads", _of_label(data.results), _numbers(data.told["brief"])),
            _Regime("large", "Loads of surgical size", _of_label(data.large), _numbers(data.told["large_brief"]))]


def _labels(data: ReportData) -> list[str]:
    """Of all bodies, in their order."""
    return data.in_order(dict.fromkeys(result.label for result in [*data.results, *data.large]), lambda label: label)


def first_picture_of(data: ReportData) -> Markup:
    """The first body that has a picture, under small loads if it has both."""
    for label in _labels(data):
        for regime in _regimes(data):
            for row in best_springs(regime.numbers.get(label, []))[:1]:
                if html := first_picture.section(regime.counted(label), row.model, data.smallest_felt_difference):
                    return html
    return Markup("")


def _body(data: ReportData, label: str, regimes: list[_Regime]) -> Markup:
    cases = [result for regime in regimes for result in regime.cases.get(label, ())]
    html = paragraph(_regions(cases[0])) + bullets(_parts(cases)) + patient.facts(data, label, cases)
    for regime in regimes:
        if label in regime.numbers:
            counted = regime.counted(label)
            html += paragraph(f"{regime.title}, {len(counted)} load case{'s' if len(counted) > 1 else ''}:")
            html += bullets(_sentences(regime.numbers[label], counted, data.smallest_felt_difference))
    return subsection(label, html)


def verdicts(data: ReportData) -> Markup:
    """A picture, the terms, in words what each body is and which springs are near there, then both numbers of all models."""
    felt, regimes = data.smallest_felt_difference, _regimes(data)
    html = first_picture_of(data) + words.section(data)
    for label in _labels(data):
        html += _body(data, label, regimes)
    have_both = all(regime.numbers for regime in regimes)
    panels = []
    for regime in regimes:
        for label, rows in regime.numbers.items():
            if any(math.isfinite(row.error) for row in rows):
                title = f"{label}, {regime.size} loads" if have_both else label
                panels.append(_panel(title, f"{label}-{regime.size}_loads-both_numbers", rows, own_error(regime.counted(label)), felt))
    if panels:
        grey = "Grey: the reference's own error in position. " if any(
            own_error(regime.counted(label)) > 0.0 for regime in regimes for label in regime.numbers) else ""
        references = " and ".join(dict.fromkeys(result.reference for result in [*data.results, *data.large] if result.reference))
        against = f"Errors are against {references}." if references else ""
        html += figure("figure", plots(panels[:MOST_PANELS]),
                       f"Both numbers of each model. Dotted: the {PERCENT * felt:.0f} % that a hand feels. {grey}{against}",
                       commands_of([*data.results, *data.large])[:1])
    return html


def title(data: ReportData) -> str:
    bodies = list(dict.fromkeys(result.body for result in [*data.results, *data.large]))
    return f"Livermark report: {bodies[0]}" if len(bodies) == 1 else "Livermark report"


def lead(data: ReportData) -> str:
    """What the report is about, in a sentence."""
    if data.has_no_results:
        return "Deformable models beside measurements of real bodies, needles in bodies, and what is not known of a patient."
    return reference.lead(data)


def facts(data: ReportData) -> list[tuple[str, str]]:
    told = data.told
    counts = {"runs": len(data.results) + len(data.large)}
    counts |= {kind: len(told[kind]) for kind in ("cohorts", "arenas", "stability", "timings", "experiments",
                                                  "needles", "sensitivities")}
    found = [("Files", ", ".join(f"{count} of {kind}" for kind, count in counts.items() if count))]
    found += [("Left out", fault) for fault in data.faults]
    if data.results:
        made = max(data.results, key=lambda result: result.provenance["created"]).provenance
        found += [("Newest run", f"{made['created']}, livermark {made['software_version']}, commit {made['git_commit']}"),
                  ("Machine", f"{made['cpu']}, {made['threads']} threads, {made['compiler']}, {made['build_type']}")]
    return found
