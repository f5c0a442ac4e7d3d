"""A card for each method of the arena, one open at a time: what it converges to, what is said against it, and its errors
over iterations, over meshes and over time."""
from __future__ import annotations

import math
from typing import Callable, NamedTuple

import matplotlib
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, Table, attributes_of, table_of, texts_of
from livermark.report.parts import Section, bullets, choice, figure, paragraph, plots, subsection, table
from livermark.report.sections.arena import best_runs, runs_of, touching_shape
from livermark.studies.tables import PERCENT

TITLE = "A card for each method"
COMMAND = "livermark arena --iterations 1 2 5 10 20 50 100 --output FOLDER"  # makes the files
WIDTH, HEIGHT = 440, 310
MOST_ERROR = 150.0  # [%]: lines above it leave the picture
WORDS = ("sources", "implementations", "converge_to", "objections")
FIELDS = 4  # records from one field to the next


class Line(NamedTuple):
    name: str
    x: list[float]
    y: list[float]


class Arena(NamedTuple):
    """An arena file."""
    title: str  #: the body, and what the tool does
    command: str
    has_reference: bool
    told: dict  #: what the program says of it
    time: list[float]
    reference_force: list[float]  #: sizes [N]
    reference_pressed: float  #: [N]
    runs: list[dict]
    series: list[dict]
    words: dict[str, dict[str, str]]  #: of each method


def _size(force) -> list[float]:
    return list((force ** 2).sum(axis=1) ** 0.5)


def _arena(data: ReportData, told: dict) -> Arena:
    with data.open(told["file"]) as file:
        about, arena = attributes_of(file), attributes_of(file["arena"])
        words = {}
        if "methods" in file:
            columns = [texts_of(file["methods"], word) for word in WORDS]
            words = {name: dict(zip(WORDS, row)) for name, *row in zip(texts_of(file["methods"], "names"), *columns)}
        touches = arena.get("tool") == "touching"
        return Arena(
            title=about["body"] + (f", a {touching_shape(arena)} that touches, friction {arena['friction']:g}" if touches else ""),
            command=about["command"], has_reference=bool(arena["reference"]), told=told,
            time=list(file["arena/time"][:]), reference_force=_size(file["arena/reference_force"][:]),
            reference_pressed=float(arena.get("reference_pressed_force", math.nan)),
            runs=runs_of(file["arena"]), series=runs_of(file["series"]) if "series" in file else [], words=words)


def _of(runs: list[dict], method: str) -> list[dict]:
    return [run for run in runs if run["method"] == method]


def _total(run: dict) -> int:
    """Iterations in a frame, or explicit steps."""
    return int(run["steps"]) * int(run["iterations"])


def _draw(title: str, x_label: str, y_label: str, lines: list[Line], logarithmic: str, low: float = math.nan,
          high: float = math.nan) -> Markup:
    """Nothing where there is nothing to draw. low and high: of y, where they are known."""
    lines = [line for line in lines if any(map(math.isfinite, line.y))]
    if not lines:
        return Markup("")
    axes = figures.new_plot(title, x_label, y_label, WIDTH, HEIGHT)
    values = {"x": [x for line in lines for x in line.x], "y": [y for line in lines for y in line.y if not y > high]}
    figures.set_logarithmic(axes, logarithmic, values)
    names = [line.name for line in lines]
    for line in lines:
        figures.draw_line(axes, line.x, line.y, line.name, colours.style_of(line.name, names))
    if "y" not in logarithmic:
        with matplotlib.rc_context(figures.SETTINGS):
            axes.axhline(0.0, color=colours.AXIS, linewidth=1)
            if math.isfinite(low):
                shown = [min(max(y, low), high) for y in values["y"] if math.isfinite(y)]
                margin = 0.1 * max(max(shown) - min(shown), 1.0)
                axes.set_ylim(min(shown + [0.0]) - margin, max(shown + [0.0]) + margin)
    return figures.finish(axes)


def _series_lines(series: list[dict], value: Callable[[dict], float]) -> list[Line]:
    """A line for each mesh and setting. With one iteration settings are one run, and so are steps that are stable and half
    of them one line."""
    lines = []
    for size in sorted({int(run["tetrahedra"]) for run in series}):
        on_mesh = [run for run in series if run["tetrahedra"] == size]
        explicit = [run for run in on_mesh if run["setting"] in ("stable", "half steps")]
        one = [run for run in on_mesh if run["setting"] == "one step" and _total(run) == 1]
        groups = {"explicit steps": explicit} if explicit else {
            "one step": [run for run in on_mesh if run["setting"] == "one step"],
            "steps with ten iterations": [run for run in on_mesh if run["setting"] == "ten iterations"],
            "steps with one iteration": one + [run for run in on_mesh if run["setting"] == "one iteration"]}
        for name, runs in groups.items():
            if not runs:
                continue
            runs = sorted(runs, key=_total)
            lines.append(Line(f"{size}, {name}", [float(_total(run)) for run in runs], [value(run) for run in runs]))
    return lines


def _mesh_lines(runs: list[dict], series: list[dict]) -> list[Line]:
    """Error over the number of tetrahedra: of the best setting within each budget, and with the most iterations."""
    lines = []
    sizes = sorted({int(run["tetrahedra"]) for run in runs + series})
    for budget in sorted({float(run["budget"]) for run in runs if math.isfinite(run["budget"])}):
        found = {size: min((PERCENT * float(run["contact_error"]) for run in runs if run["budget"] == budget and
                            run["tetrahedra"] == size and run["outcome"] == "ok"), default=math.nan) for size in sizes}
        lines.append(Line(f"within {1e3 * budget:.3g} ms", [float(size) for size in sizes], [found[size] for size in sizes]))
    for setting, name in (("one step", "most iterations"), ("ten iterations", "most steps of ten"), ("one iteration", "most steps"),
                          ("half steps", "half steps")):
        last = {}
        for run in sorted((run for run in series if run["setting"] == setting), key=_total):
            last[int(run["tetrahedra"])] = PERCENT * float(run["contact_error"])
        lines.append(Line(f"{name}, any time", [float(size) for size in last], list(last.values())))
    return lines


def _shown_runs(arena: Arena, method: str) -> dict[int, dict]:
    """On each mesh the best within the longest budget, or else the one of the series with the smallest error."""
    shown = {}
    runs = _of(arena.runs, method)
    for size in sorted({int(run["tetrahedra"]) for run in runs + _of(arena.series, method)}):
        within = best_runs([run for run in runs if run["tetrahedra"] == size and run["outcome"] == "ok"]).get(method)
        others = [run for run in runs + _of(arena.series, method)
                  if run["tetrahedra"] == size and run["outcome"] != "diverged"]
        if within:
            shown[size] = within[-1]
        elif others:
            shown[size] = min(others, key=lambda run: run["contact_error"] if math.isfinite(run["contact_error"]) else 0.0)
    return shown


def _time_plot(arena: Arena, method: str, title: str, y_label: str, value: Callable[[dict], list[float]], time: list[float],
               reference: list[float]) -> Markup:
    axes = figures.new_plot(title, "time [s]", y_label, WIDTH, HEIGHT)
    shown = _shown_runs(arena, method)
    names = [f"{size} tetrahedra" for size in shown]
    top = max(reference, default=0.0)
    with matplotlib.rc_context(figures.SETTINGS):
        if reference:
            axes.plot(time, reference, color=colours.INK, linewidth=3.0, label="reference")
        for name, run in zip(names, shown.values()):
            style = colours.style_of(name, names)
            axes.plot(time, value(run), color=style.colour, linestyle=style.dash, linewidth=1.4, label=name)
            finite = [item for item in value(run) if math.isfinite(item)]
            top = max([top] + ([min(max(finite), 3.0 * max(reference, default=math.inf))] if finite else []))
        axes.set_xlim(left=0.0)
        axes.set_ylim(0.0, 1.1 * min(top, MOST_ERROR) if not reference and "%" in y_label else 1.1 * top or 1.0)
    return figures.finish(axes)


def _pictures(arena: Arena, method: str) -> list[Markup]:
    runs, series = _of(arena.runs, method), _of(arena.series, method)
    x_label = "iterations in a frame"
    pictures = [
        _draw("Error against iterations", x_label, "error in contact [%]",
              _series_lines(series, lambda run: PERCENT * float(run["contact_error"])), "xy", high=MOST_ERROR),
        _draw("Stiffness at the tool", x_label, "force above that of the reference [%]",
              _series_lines(series, lambda run: PERCENT * (float(run["pressed_force"]) / arena.reference_pressed - 1.0)), "x",
              -100.0, MOST_ERROR)]
    if not arena.has_reference:
        pictures = [_draw("Force against iterations", x_label, "force when the slide begins [N]",
                          _series_lines(series, lambda run: float(run["pressed_force"])), "xy")]
    pictures.append(_draw("Error against mesh", "tetrahedra", "error in contact [%]", _mesh_lines(runs, series), "xy",
                          high=MOST_ERROR))
    if arena.has_reference:
        pictures.append(_time_plot(arena, method, "Error over time", "error [%]",
                                   lambda run: list(PERCENT * run["error_over_time"]), arena.time[::FIELDS], []))
    pictures.append(_time_plot(arena, method, "Force over time", "force on the tool [N]", lambda run: _size(run["force"]),
                               arena.time, arena.reference_force if arena.has_reference else []))
    return [picture for picture in pictures if picture]


def _rows_of(layout: dict, method: str) -> Table:
    """Without the column of the method."""
    whole = table_of(layout)
    at = [column.title for column in whole.columns].index("method")
    keep = [c for c in range(len(whole.columns)) if c != at]
    return Table([whole.columns[c] for c in keep],
                 [[row[c] for c in keep] for row in whole.rows if row[at] == method])


def _of_arena(arena: Arena, method: str) -> Markup:
    html = figure("figure", plots(_pictures(arena, method)),
                  "Number of tetrahedra, and how the method spends its iterations. Stiffness at the tool: the force when the slide "
                  "begins over that of the reference, minus 1, with as many iterations. Over time: the best within the longest "
                  f"budget. What is above {MOST_ERROR:.0f} % is outside.", [arena.command])
    within = _rows_of(arena.told["table" if arena.has_reference else "overview"], method)
    if within.rows:
        html += figure("table", table(within), "Within each budget: errors, volume, time, setup and memory.", [arena.command])
    series = _rows_of(arena.told["series"], method)
    if series.rows:
        html += figure("table", table(series), "With given numbers of iterations.", [arena.command])
    return subsection(arena.title, html)


def _card(arenas: list[Arena], method: str) -> Markup:
    words = next((arena.words[method] for arena in arenas if method in arena.words), None)
    html = Markup("")
    if words:
        html += bullets([f"Source: {words['sources']}.", f"Here: {words['implementations']}.",
                         f"Converges to {words['converge_to']}.", f"Objections: {words['objections']}"])
    for arena in arenas:
        if _of(arena.runs, method) or _of(arena.series, method):
            with figure_files.about(arena.title, method):
                html += _of_arena(arena, method)
    return choice("cards", method, html)


def section(data: ReportData) -> Section | None:
    arenas = [arena for arena in (_arena(data, told) for told in data.told["arenas"]) if arena.words]
    methods = list(dict.fromkeys(run["method"] for arena in arenas for run in arena.runs + arena.series))
    if not methods:
        return None
    html = paragraph("What each method under a moving tool is, and how far it is from the reference with more iterations, on other "
                     "meshes and over time. An iteration of an explicit method is a step.")
    for method in methods:
        html += _card(arenas, method)
    return Section("cards", TITLE, html)
