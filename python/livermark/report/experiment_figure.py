"""Draws an experiment file: python3 -m livermark.report.experiment_figure <experiment>.h5 makes <experiment>.png beside it.

`livermark experiment --figure` calls it. Where forces were measured, <experiment>.force.png is made as well: force over
way, as measured and of the nearest models. Where bodies rang down, so is <experiment>.ring_down.png: the mean of the markers over
time, as measured and of the nearest models. Each state is drawn as measured markers over the boundary of the body as the
reference deforms it, seen along two axes, and as the errors of the models.
"""
import sys
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator

from livermark.report.data import attributes_of, scaled_forces, texts_of

MILLIMETRES = 1e3
MOST_CURVES = 5  # beside the measurement
VIEWS = (1, 0)  # axes along which the body is seen
MARGIN = 0.04  # around a body, of its longest side
# Sizes in inches. The longest side of a body grows with the square root of how slender it is.
MODERATE_SIDE, LONGEST_SIDE = 4.0, 10.0  # of a body as thick as long, and of all
LEAST_PANEL = 1.2  # of a view, for its ticks
BAR_HEIGHT, BARS_WIDTH, NAMES_WIDTH = 0.16, 4.5, 2.6  # of a model, of all, and of the names before them
TICKS_WIDTH, TITLES_HEIGHT, HEAD_HEIGHT = 0.85, 1.15, 1.25  # beside a view, between rows, and above all


def edges_seen_from_outside(triangles):
    """(E, 2) node numbers of the edges of triangles, each once."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0)


def box_around(groups, along):
    """(2, 2) least and largest coordinates of points in the plane of two axes [mm], with a margin. Points that are not known are
    left out."""
    flat = MILLIMETRES * np.delete(np.concatenate(groups), along, axis=1)
    flat = flat[np.isfinite(flat).all(axis=1)]
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = MARGIN * (high - low).max()
    return np.array([low - margin, high + margin])


def inches_per_millimetre(boxes):
    """The scale of all views, at which a slender body is long enough to be thick enough."""
    sides = np.array([high - low for low, high in boxes])
    broadest = sides[np.argmax(sides.prod(axis=1))]
    return min(MODERATE_SIDE * np.sqrt(broadest.max() / broadest.min()), LONGEST_SIDE) / sides.max()


def place_axes(figure, left, top, width, height):
    """Axes with a place from the upper left corner and a size, in inches."""
    whole_width, whole_height = figure.get_size_inches()
    return figure.add_axes([left / whole_width, 1.0 - (top + height) / whole_height, width / whole_width, height / whole_height])


def draw_body(axes, points, edges, along, box, scale):
    """The boundary as lines in the plane of two axes, in a box [mm] that is widened to the size of the axes at a scale."""
    flat = MILLIMETRES * np.delete(points, along, axis=1)
    axes.add_collection(LineCollection(flat[edges], colors="0.8", linewidths=0.4, zorder=0))
    size = np.array([axes.bbox.width, axes.bbox.height]) / axes.figure.dpi  # [in]
    middle, half = 0.5 * box.sum(axis=0), 0.5 * size / scale
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])
    for axis, inches in ((axes.xaxis, size[0] / 0.6), (axes.yaxis, size[1] / 0.35)):
        axis.set_major_locator(MaxNLocator(nbins=max(2, int(inches)), steps=[1, 2, 5, 10]))
    axes.set_xlabel(f"{'xyz'[0 if along else 1]} [mm]")
    axes.set_ylabel(f"{'xyz'[2 if along < 2 else 1]} [mm]")


def draw_markers(axes, measured, computed, along, label):
    """Measured markers as circles, computed ones as dots, and lines between the two."""
    measured, computed = (MILLIMETRES * np.delete(of, along, axis=1) for of in (measured, computed))
    axes.plot(*measured.T, "o", markersize=4, markerfacecolor="none", markeredgecolor="tab:blue", label="measured")
    axes.plot(*computed.T, ".", markersize=3, color="tab:red", label=label)
    axes.add_collection(LineCollection(np.stack([measured, computed], axis=1), colors="tab:red", linewidths=0.6))


def slab(positions, along, drives):
    """The markers in the middle along an axis, where there are many: all of them would hide each other."""
    compared = np.array([not drive for drive in drives])
    if compared.sum() < 50:
        return compared
    offset = np.abs(positions[:, along] - np.median(positions[compared, along]))
    return compared & (offset < 0.1 * np.ptp(positions[:, along]))


def draw_states(path):
    """The figure of all states, a row for each: two views at one scale, and the errors of the models."""
    with h5py.File(path, "r") as file:
        group = file["experiment"]
        text = lambda value: value.decode() if isinstance(value, bytes) else str(value)
        title, reference = text(group.attrs["title"]), text(group.attrs["reference"])
        states = [text(name) for name in group["states"].attrs["names"]]
        drives = [text(name) for name in group["markers"].attrs["drives"]]
        models = np.array([text(name) for name in group["runs"].attrs["models"]])
        positions, measured = group["markers/position"][()], group["states/displacement"][()]
        points, deformed = group["body/points"][()], group["body/displacement"][()]
        edges = edges_seen_from_outside(group["body/boundary_triangles"][()])
        state_of, tetrahedra = group["runs/state"][()], group["runs/tetrahedra"][()]
        displacement, error = group["runs/displacement"][()], group["runs/error"][()]
        noise = group["states/noise"][()]
    boxes, seen = {}, {along: slab(positions, along, drives) for along in VIEWS}
    finest, on_mesh = [], []
    for s in range(len(states)):
        reference_runs = np.flatnonzero((state_of == s) & (models == reference))
        finest.append(reference_runs[np.argmax(tetrahedra[reference_runs])])
        at_mesh = np.flatnonzero((state_of == s) & (tetrahedra == tetrahedra[reference_runs].min()) & np.isfinite(error))
        on_mesh.append(at_mesh[np.argsort(error[at_mesh])[::-1]])
        for along in VIEWS:
            boxes[s, along] = box_around([points + deformed[s], (positions + measured[s])[seen[along]],
                                          (positions + displacement[finest[s]])[seen[along]]], along)
    scale = inches_per_millimetre(list(boxes.values()))
    sizes = {view: np.maximum(scale * (high - low), LEAST_PANEL) for view, (low, high) in boxes.items()}
    widths = [max(sizes[s, along][0] for s in range(len(states))) for along in VIEWS]
    heights = [max([BAR_HEIGHT * len(on_mesh[s])] + [sizes[s, along][1] for along in VIEWS]) for s in range(len(states))]
    figure = plt.figure(figsize=(sum(widths) + 2 * TICKS_WIDTH + NAMES_WIDTH + BARS_WIDTH + 0.3,
                                 HEAD_HEIGHT + sum(heights) + len(states) * TITLES_HEIGHT))
    top = HEAD_HEIGHT
    for s, name in enumerate(states):
        left = TICKS_WIDTH
        for along, width in zip(VIEWS, widths):
            panel_width, panel_height = sizes[s, along]
            axes = place_axes(figure, left, top, panel_width, panel_height)
            draw_body(axes, points + deformed[s], edges, along, boxes[s, along], scale)
            draw_markers(axes, (positions + measured[s])[seen[along]], (positions + displacement[finest[s]])[seen[along]], along,
                         reference)
            axes.set_title(f"seen along {'xyz'[along]}", fontsize=10, loc="left")
            left += width + TICKS_WIDTH
        bars = place_axes(figure, left - TICKS_WIDTH + NAMES_WIDTH, top, BARS_WIDTH, max(BAR_HEIGHT * len(on_mesh[s]), LEAST_PANEL))
        bars.barh(range(len(on_mesh[s])), MILLIMETRES * error[on_mesh[s]], color="tab:blue")
        bars.set_yticks(range(len(on_mesh[s])), models[on_mesh[s]], fontsize=8)
        bars.margins(y=0.01)
        if noise[s] > 0.0:
            bars.axvline(MILLIMETRES * noise[s], color="k", linestyle="--", linewidth=0.8)
        bars.set_xlabel("error [mm]; dashed: noise of the measurement" if noise[s] > 0.0 else "error [mm]")
        whole_width, whole_height = figure.get_size_inches()
        figure.text(0.15 / whole_width, 1.0 - (top - 0.32) / whole_height, name, fontsize=11, fontweight="bold")
        top += heights[s] + TITLES_HEIGHT
    figure.text(0.15 / whole_width, 1.0 - 0.3 / whole_height, title, fontsize=13)
    figure.legend(*axes.get_legend_handles_labels(), loc="upper left", ncol=2, fontsize=9, frameon=False,
                  bbox_to_anchor=(0.05 / whole_width, 1.0 - 0.35 / whole_height))
    return figure


def draw(path):
    """None where no markers are compared."""
    with h5py.File(path, "r") as file:
        markers = file["experiment"].get("markers")
        if markers is None or not any(drive in ("", b"") for drive in markers.attrs["drives"]):
            return None
    target = Path(path).with_suffix(".png")
    draw_states(path).savefig(target, dpi=110)
    return target


def draw_forces(path):
    """Force over the way in each state, over the force at the first way; None where none was measured."""
    with h5py.File(path, "r") as file:
        if "forces" not in file["experiment"]:
            return None
        parent = file["experiment/forces"]
        figure, axes = plt.subplots(1, len(parent), figsize=(5.5 * len(parent), 4.6), squeeze=False)
        for plot, name in zip(axes[0], sorted(parent, key=int)):
            group, runs = parent[name], parent[name]["runs"]
            models = texts_of(runs, "models")
            way, measured = MILLIMETRES * group["way"][()], group["force"][()]
            plot.errorbar(way, measured, 2.0 * group["deviation"][()], fmt="ko", markersize=3.5, capsize=3, zorder=3,
                          label="measured, two standard deviations")
            if "uniform" in group:
                uniform = group["uniform"][()]
                plot.plot(way, uniform / uniform[0] * measured[0], color="0.6", linestyle="--", label="uniform, neo-Hookean")
            scaled, error = scaled_forces(group)
            order = np.argsort(np.where(np.isfinite(error), error, np.inf), kind="stable")
            for r in order[:MOST_CURVES]:
                plot.plot(way, scaled[r], linewidth=1.0, label=f"{models[r]}, {runs['tetrahedra'][r]}")
            plot.set_title(attributes_of(group)["state"], fontsize=10)
            plot.set_xlabel("way [mm]")
            plot.set_ylabel("force [N], each model with its own modulus")
            plot.legend(fontsize=7, loc="upper left")
    figure.tight_layout()
    target = Path(path).with_suffix(".force.png")
    figure.savefig(target, dpi=110)
    return target


def draw_ring_downs(path):
    """The mean displacement of the markers along the way in which they go at first; None where nothing rang down."""
    with h5py.File(path, "r") as file:
        if "ring_downs" not in file["experiment"]:
            return None
        parent = file["experiment/ring_downs"]
        figure, axes = plt.subplots(len(parent), 1, figsize=(10, 3.2 * len(parent)), squeeze=False)
        for plot, name in zip(axes[:, 0], sorted(parent, key=int)):
            group, runs = parent[name], parent[name]["runs"]
            measured, interval = group["displacement"][()].mean(axis=1), group.attrs["interval"]
            opposite = min(max(round(0.5 / (group.attrs["frequency"] * interval)), 1), len(measured) - 1)
            way = (measured[opposite] - measured[0]) / np.linalg.norm(measured[opposite] - measured[0])
            time = interval * np.arange(len(measured))
            plot.plot(time, MILLIMETRES * measured @ way, "ko", markersize=2.5, label="measured")
            error = np.where(np.isfinite(runs["error"][()]), runs["error"][()], np.inf)
            for r in np.argsort(error)[:MOST_CURVES]:
                moved = runs["displacement"][r].reshape(len(measured), -1, 3).mean(axis=1)
                model = runs.attrs["models"][r]
                plot.plot(time, MILLIMETRES * moved @ way, linewidth=1.0,
                          label=f"{model.decode() if isinstance(model, bytes) else model}, {runs['tetrahedra'][r]}")
            state = group.attrs["state"]
            plot.set_title(state.decode() if isinstance(state, bytes) else state, fontsize=10)
            plot.set_ylabel("markers [mm]")
            plot.legend(fontsize=7, loc="upper right")
        axes[-1, 0].set_xlabel("time [s]")
    figure.tight_layout()
    target = Path(path).with_suffix(".ring_down.png")
    figure.savefig(target, dpi=110)
    return target


def main() -> None:
    for target in (draw(sys.argv[1]), draw_forces(sys.argv[1]), draw_ring_downs(sys.argv[1])):
        if target:
            print(f"The picture is {target}")


if __name__ == "__main__":
    main()
