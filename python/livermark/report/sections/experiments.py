"""Models beside measurements of real bodies, at rest and while they ring down."""
from __future__ import annotations

import math
import pathlib

import matplotlib
import numpy
from markupsafe import Markup

from livermark.report import colours, figure_files, figures
from livermark.report.data import ReportData, attributes_of, scaled_forces, table_of, texts_of
from livermark.report.parts import Section, bullets, figure, paragraph, plots, subsection, table
from livermark.studies.tables import MILLIMETRES, fixed

TITLE = "Beside measurements"
COMMAND = "livermark experiment NAME --output FOLDER"  # makes the files
MOST_CURVES = 4  # beside the measurement: more cannot be told apart


def _errors(file) -> dict[str, list[float]]:
    """Errors of each model in all states, on the mesh on which all are compared; NaN where it has no solution."""
    runs = file["experiment/runs"]
    models, statuses = texts_of(runs, "models"), texts_of(runs, "statuses")
    tetrahedra, state, error = runs["tetrahedra"][:], runs["state"][:], runs["error"][:]
    num_states = len(texts_of(file["experiment/states"], "names"))
    errors: dict[str, list[float]] = {}
    for r, model in enumerate(models):
        if tetrahedra[r] == tetrahedra.min():
            of_model = errors.setdefault(model, [math.nan] * num_states)
            of_model[state[r]] = float(error[r]) if statuses[r] == "ok" else math.nan
    return dict(sorted(errors.items(), key=lambda item: sum(item[1]) if math.isfinite(sum(item[1])) else math.inf))


def _lengths(values) -> str:
    return ", ".join(fixed(MILLIMETRES * value, 2) for value in values) + " mm"


def _verdict(file, errors: dict[str, list[float]]) -> Markup:
    """In words: who is nearest, how that compares with the noise, and who is worse than no mechanics at all."""
    states = file["experiment/states"]
    solved = {model: values for model, values in errors.items() if all(map(math.isfinite, values))}
    if not solved:
        return paragraph("No model has a solution in every state.")
    best, nearest = next(iter(solved.items()))
    noise = states["noise"][:]
    text = f"Nearest to the markers is {best}, {_lengths(nearest)} off"
    if (noise > 0.0).all():
        worst = max(error / of_noise for error, of_noise in zip(nearest, noise))
        text += (f". The noise of the measurement is {_lengths(noise)}, so "
                 + ("the measurement cannot tell it from the real body. " if worst <= 1.0 else
                    f"it is off by up to {worst:.1f} times that. "))
    else:
        text += ", and the noise of the measurement is unknown. "
    line, word = states["straight_line"][:], "the straight line between the driven places"
    if not numpy.isfinite(line).all():
        line, word = states["rigid_motion"][:], "the rigid motion that fits the markers best"
    if not numpy.isfinite(line).all():  # fewer than three markers
        return paragraph(text)
    worse = [model for model, values in solved.items() if all(value > of_line for value, of_line in zip(values, line))]
    if len(worse) == len(solved):
        text += f"All models are worse than {word}, which has {_lengths(line)}"
        text += ": that says little, because it was fitted to the same markers." if "rigid" in word else "."
    elif worse:
        text += f"Worse than {word} in every state: {', '.join(worse)}."
    else:
        text += f"No model is worse than {word} in every state."
    return paragraph(text)


def _error_plot(file, errors: dict[str, list[float]]) -> Markup:
    """A row for each model, a mark for each state, and the noise as lines."""
    names = list(errors)[::-1]
    states, noise = texts_of(file["experiment/states"], "names"), file["experiment/states/noise"][:]
    axes = figures.new_rows("Error of the markers", "root mean square distance [mm]", names, 640, 19)
    with matplotlib.rc_context(figures.SETTINGS):
        rows = range(len(names))
        for s, state in enumerate(states):
            colour = colours.SERIES[s % len(colours.SERIES)]
            axes.plot([MILLIMETRES * errors[name][s] for name in names], rows, linestyle="",
                      marker="oD^sXP"[s % 6], color=colour, label=state)
            if noise[s] > 0.0:
                axes.axvline(MILLIMETRES * noise[s], color=colour, linewidth=1, linestyle=":", zorder=0)
    shown = [MILLIMETRES * value for values in errors.values() for value in values]
    figures.set_logarithmic(axes, "x", {"x": shown + [MILLIMETRES * value for value in noise]})
    return figures.finish(axes)


def _direction(displacement, interval: float, frequency: float):
    """Where the mean of the markers goes at first."""
    opposite = min(max(round(0.5 / (frequency * interval)), 1), len(displacement) - 1)
    way = displacement[opposite].mean(axis=0) - displacement[0].mean(axis=0)
    size = numpy.linalg.norm(way)
    return way / size if size > 0.0 else numpy.array([0.0, 0.0, 1.0])


def _best_runs(group) -> list[int]:
    """Of each model that came to an end the run on the finest mesh, the smallest error first."""
    models, statuses = texts_of(group, "models"), texts_of(group, "statuses")
    tetrahedra, error = group["tetrahedra"][:], group["error"][:]
    finest: dict[str, int] = {}
    for r, model in enumerate(models):
        if statuses[r] == "ok" and math.isfinite(error[r]) and (
                model not in finest or tetrahedra[r] > tetrahedra[finest[model]]):
            finest[model] = r
    return sorted(finest.values(), key=lambda r: error[r])


def _swing_plot(group, models: list[str]) -> Markup:
    """The mean of the markers over time."""
    made = attributes_of(group)
    measured = group["displacement"][:]
    way = _direction(measured, made["interval"], made["frequency"])
    time = made["interval"] * numpy.arange(len(measured))
    axes = figures.new_plot(f"Let go: {made['state']}", "time [s]", "markers, in the mean [mm]")
    with matplotlib.rc_context(figures.SETTINGS):
        axes.plot(time, MILLIMETRES * measured.mean(axis=1) @ way, color=colours.INK, linestyle="", marker="o",
                  markersize=3.2, label="measured")
        runs = group["runs"]
        names, computed = texts_of(runs, "models"), runs["displacement"]
        best = _best_runs(runs)
        is_near = [runs["error"][r] <= made["no_motion"] for r in best]  # others are off by more than the swings
        for r in best[:max(1, min(sum(is_near), MOST_CURVES))]:
            style = colours.style_of(names[r], models)
            swing = computed[r].reshape(measured.shape).mean(axis=1) @ way
            axes.plot(time, MILLIMETRES * swing, color=style.colour, linestyle=style.dash, linewidth=1.4, label=names[r])
        axes.set_xlim(0.0, time[-1])
    return figures.finish(axes)


def _ring_down_verdict(groups) -> Markup:
    """Frequencies and damping of the best model, beside how sure the measurement is."""
    sentences = []
    for group in groups:
        made, runs = attributes_of(group), group["runs"]
        best = _best_runs(runs)[:1]
        text = (f"{made['state']}: measured {made['frequency']:.2f} ± {made['frequency_uncertainty']:.2f} Hz, damping ratio "
                f"{made['damping_ratio']:.3f} ± {made['damping_uncertainty']:.3f}")
        for r in best:
            off = 100.0 * (runs["frequency"][r] / made["frequency"] - 1.0)
            text += (f"; nearest over time is {texts_of(runs, 'models')[r]}, {off:+.1f} % in frequency, "
                     f"{runs['damping_ratio'][r]:.3f} in damping, {MILLIMETRES * runs['error'][r]:.2f} mm off in the mean, "
                     f"where repeats differ by {MILLIMETRES * made['noise']:.2f} mm")
        sentences.append(text + ".")
    return bullets(sentences)


def _ring_downs(file, told: dict, command: str) -> Markup:
    if "ring_downs" not in file["experiment"]:
        return Markup("")
    parent = file["experiment/ring_downs"]
    groups = [parent[name] for name in sorted(parent, key=int)]
    models = list(dict.fromkeys(name for group in groups for name in texts_of(group["runs"], "models")))
    html = _ring_down_verdict(groups) + paragraph(told["ring_down_note"])
    html += figure("figure", plots([_swing_plot(group, models) for group in groups]),
                   "Mean displacement of the markers after they were let go, along the way in which they go at first: as "
                   f"measured, and of the {MOST_CURVES} nearest models, without those that are off by more than a body that does not "
                   "move.", [command])
    return html + figure("table", table(table_of(told["ring_down_table"])),
                         "Frequency, damping, first swings and markers over time, of every model that moves.", [command])


def _force_plot(group) -> Markup:
    """Force over the way, each model with the modulus with which it is right at the first way."""
    made, runs = attributes_of(group), group["runs"]
    way, measured = MILLIMETRES * group["way"][:], group["force"][:]
    scaled, error = scaled_forces(group)
    names = texts_of(runs, "models")
    axes = figures.new_plot(f"Pressed: {made['state']}", "way [mm]", "force [N]")
    with matplotlib.rc_context(figures.SETTINGS):
        axes.errorbar(way, measured, 2.0 * group["deviation"][:], color=colours.INK, linestyle="", marker="o", markersize=3.2,
                      capsize=2, label="measured")
        order = [r for r in numpy.argsort(error, kind="stable") if math.isfinite(error[r])]
        for r in order[:MOST_CURVES]:
            style = colours.style_of(names[r], names)
            axes.plot(way, scaled[r], color=style.colour, linestyle=style.dash, linewidth=1.4, label=names[r])
    return figures.finish(axes)


def _forces(file, told: dict, command: str) -> Markup:
    if "forces" not in file["experiment"]:
        return Markup("")
    parent = file["experiment/forces"]
    html = figure("figure", plots([_force_plot(parent[name]) for name in sorted(parent, key=int)]),
                  f"Force as measured, with two standard deviations of the tests, and of the {MOST_CURVES} nearest models. Each has the "
                  "Young's modulus with which it is right at the first point, so shapes are compared.", [command])
    return html + figure("table", table(table_of(told["force_table"])),
                         "Error of the force of every model, and the modulus that it takes.", [command])


def _experiment(data: ReportData, told: dict) -> Markup:
    with data.open(told["file"]) as file:
        command = attributes_of(file)["command"]
        made = attributes_of(file["experiment"])
        if "markers" not in file["experiment"] or "" not in texts_of(file["experiment/markers"], "drives"):
            html = _forces(file, told, command) + bullets(told["null_notes"])
            html += paragraph(f"Measured by: {made['source']}. Assumed:") + bullets(list(made["assumptions"]))
            return subsection(made["title"], html)
        errors = _errors(file)
        html = _verdict(file, errors)
        html += figure("figure", plots([_error_plot(file, errors)]),
                       "Error of each model in each state, on one mesh. Dotted: the noise of the measurement in the same "
                       "colours.", [command])
        html += figure("table", table(table_of(told["table"])),
                       "Root mean square error of the markers [mm], beside the noise and what needs no mechanics.", [command])
        html += bullets(told["null_notes"]) + _forces(file, told, command) + _ring_downs(file, told, command)
        html += paragraph(f"Measured by: {made['source']}. Assumed:") + bullets(list(made["assumptions"]))
    return subsection(made["title"], html)


def section(data: ReportData) -> Section | None:
    if not data.told["experiments"]:
        return None
    html = paragraph("Somebody loaded real bodies and measured where markers went. Models are compared with these "
                     "measurements, and not with a reference.")
    for told in data.told["experiments"]:
        with figure_files.about(pathlib.PurePath(told["file"]).stem):
            html += _experiment(data, told)
    return Section("experiments", TITLE, html)
