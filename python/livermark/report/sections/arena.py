"""Methods under a moving tool: the error that is left of each within a budget of time, and the force over time."""
from __future__ import annotations

import math

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, attributes_of, table_of, texts_of
from livermark.report.parts import Section, figure, paragraph, plots, subsection, table
from livermark.studies.tables import PERCENT

TITLE = "Methods within a budget"
COMMAND = "livermark arena --output FOLDER"  # makes the files
MILLISECONDS = 1e3
MOST_FORCES = 4  # lines of force beside the reference: more cannot be told apart


def runs_of(group) -> list[dict]:
    """A dict for each run of a group of an arena file: its texts, and its numbers by their names."""
    if "methods" not in attributes_of(group):
        return []
    texts = {name: texts_of(group, name) for name in ("methods", "settings", "outcomes")}
    columns = {name: values[:] for name, values in group.items() if len(values) == len(texts["methods"])}
    return [{"method": texts["methods"][r], "outcome": texts["outcomes"][r], "setting": texts["settings"][r],
             **{name: values[r] for name, values in columns.items()}} for r in range(len(texts["methods"]))]


def best_runs(runs: list[dict]) -> dict[str, list[dict]]:
    """Of each method the runs with the smaller error within each budget, and of those that are too slow where they stand."""
    best: dict[str, dict[float, dict]] = {}
    for run in runs:
        if run["outcome"] == "diverged" or not math.isfinite(run["contact_error"]):
            continue
        place = max(run["frame_seconds"], run["budget"]) if run["outcome"] == "too slow" else run["budget"]
        of_method = best.setdefault(run["method"], {})
        if place not in of_method or run["contact_error"] < of_method[place]["contact_error"]:
            of_method[place] = run
    return {name: [of_method[place] for place in sorted(of_method)] for name, of_method in best.items()}


def _budget_plot(runs: list[dict], tetrahedra: int, methods: list[str]) -> Markup:
    """Error against the time that a frame really took."""
    axes = figures.new_plot(f"{tetrahedra} tetrahedra", "time of a frame, one core [ms]", "error in contact [%]", 440, 330)
    best = best_runs([run for run in runs if run["tetrahedra"] == tetrahedra])
    x = [MILLISECONDS * run["frame_seconds"] for of_method in best.values() for run in of_method]
    y = [PERCENT * run["contact_error"] for of_method in best.values() for run in of_method]
    figures.set_logarithmic(axes, "xy", {"x": x, "y": [min(value, 150.0) for value in y]})
    for name, of_method in best.items():
        points = sorted({(MILLISECONDS * run["frame_seconds"], PERCENT * run["contact_error"]) for run in of_method})
        figures.draw_line(axes, *zip(*points), name, colours.style_of(name, methods))
    with matplotlib.rc_context(figures.SETTINGS):
        for budget in sorted({run["budget"] for run in runs if math.isfinite(run["budget"])}):
            axes.axvline(MILLISECONDS * budget, color=colours.FAINT, linewidth=1, linestyle=":", zorder=0)
    return figures.finish(axes, f"error_against_time-{tetrahedra}")


def _force_plot(file, runs: list[dict], tetrahedra: int, methods: list[str]) -> Markup:
    """Size of the force over time, of the best within the longest budget and of the reference."""
    group = file["arena"]
    time = group["time"][:]
    axes = figures.new_plot(f"Force on the tool, {tetrahedra} tetrahedra", "time [s]", "force [N]", 440, 330)
    reference = (group["reference_force"][:] ** 2).sum(axis=1) ** 0.5
    with matplotlib.rc_context(figures.SETTINGS):
        axes.plot(time, reference, color=colours.INK, linewidth=3.0, label=attributes_of(group)["reference"])
    budget = max(run["budget"] for run in runs)
    within = {name: of_method[-1] for name, of_method in best_runs(
        [run for run in runs if run["tetrahedra"] == tetrahedra and run["budget"] == budget and
         run["outcome"] == "ok"]).items()}
    for name in sorted(within, key=lambda name: within[name]["contact_error"])[:MOST_FORCES]:
        style = colours.style_of(name, methods)
        with matplotlib.rc_context(figures.SETTINGS):
            axes.plot(time, (within[name]["force"] ** 2).sum(axis=1) ** 0.5, color=style.colour, linestyle=style.dash,
                      linewidth=1.4, label=name)
    axes.set_xlim(left=0.0)
    axes.set_ylim(0.0, 1.6 * reference.max())
    return figures.finish(axes)


def touching_shape(arena: dict) -> str:
    """A ball, or a round or square plate."""
    return f"{arena['face']} plate" if "face" in arena else "ball"


def _forces(attributes: dict, arena: dict, told: dict) -> Markup:
    """Forces of a tool that touches: no reference motion has contact, so there are no errors."""
    html = paragraph(f"{attributes['title']}. The tool is a {touching_shape(arena)} that touches, with a friction "
                     f"of {arena['friction']:g}. There is no reference motion with contact, so there are forces and no errors.")
    html += figure("table", table(table_of(told["overview"])),
                   "Force when the slide begins and within the slide, its part across the press over that along it, and by how "
                   "much the surface between nodes was inside the ball.", [attributes["command"]])
    return subsection(f"{attributes['body']}, touched", html)


def _arena(data: ReportData, told: dict) -> Markup:
    with data.open(told["file"]) as file, figure_files.about(attributes_of(file)["body"], "arena"):
        attributes = attributes_of(file)
        if not attributes_of(file["arena"])["reference"]:
            return _forces(attributes, attributes_of(file["arena"]), told)
        runs = runs_of(file["arena"])
        methods = list(dict.fromkeys(run["method"] for run in runs))
        sizes = sorted({int(run["tetrahedra"]) for run in runs})
        pictures = [_budget_plot(runs, size, methods) for size in sizes]
        pictures += [_force_plot(file, runs, size, methods) for size in sizes[:1]]
        change = PERCENT * attributes_of(file["arena"])["reference_contact_change"]
    command = attributes["command"]
    html = paragraph(f"{attributes['title']}. The last refinement of the reference changed it by {change:.1f} % in contact.")
    html += figure("figure", plots(pictures),
                   "Error in contact of each method in its best setting, against the processor time of a frame; dotted "
                   "lines are the budgets. Errors above 150 % are outside. Last: the size of the force on the tool, of the "
                   "best within the longest budget.", [command])
    html += figure("table", table(table_of(told["overview"])),
                   "Error in contact [%] within each budget, and the least time of a frame for some errors.", [command])
    html += figure("table", table(table_of(told["table"])), "Every budget and setting.", [command])
    return subsection(attributes["body"], html)


def section(data: ReportData) -> Section | None:
    if not data.told["arenas"]:
        return None
    html = paragraph(
        "Springs and interactive methods move under a tool that presses, slides and lets go, with as many steps or iterations "
        "as fit into a frame. Errors are those of displacements as long as the tool has hold, against finite elements.")
    for told in data.told["arenas"]:
        html += _arena(data, told)
    return Section("arena", TITLE, html)
