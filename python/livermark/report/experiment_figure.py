"""Draws an experiment file: python3 -m livermark.report.experiment_figure <experiment>.h5 makes <experiment>.png beside it.

`livermark experiment --figure` calls it. Where bodies rang down, <experiment>.ring_down.png is made as well: the mean of the
markers over time, as measured and of the nearest models. Each state is drawn as measured markers over the boundary of the body as the
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

MILLIMETRES = 1e3
MOST_CURVES = 5  # beside the measurement


def edges_seen_from_outside(triangles):
    """(E, 2) node numbers of the edges of triangles, each once."""
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    return np.unique(edges, axis=0)


def draw_body(axes, points, edges, along):
    """The boundary as lines in the plane of two axes."""
    flat = MILLIMETRES * np.delete(points, along, axis=1)
    axes.add_collection(LineCollection(flat[edges], colors="0.8", linewidths=0.4, zorder=0))
    axes.set_aspect("equal")
    axes.set_xlabel(f"{'xyz'[0 if along else 1]} [mm]")
    axes.set_ylabel(f"{'xyz'[2 if along < 2 else 1]} [mm]")
    axes.autoscale_view()


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


def draw(path):
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
    figure, axes = plt.subplots(len(states), 3, figsize=(15, 4.5 * len(states)), squeeze=False)
    for s, name in enumerate(states):
        of_state = state_of == s
        of_reference = np.flatnonzero(of_state & (models == reference))
        finest = of_reference[np.argmax(tetrahedra[of_reference])]
        for column, along in enumerate((1, 0)):
            seen = slab(positions, along, drives)
            draw_body(axes[s, column], points + deformed[s], edges, along)
            draw_markers(axes[s, column], (positions + measured[s])[seen], (positions + displacement[finest])[seen],
                         along, reference)
            axes[s, column].set_title(f"{name}, seen along {'xyz'[along]}")
        axes[s, 0].legend(loc="upper right", fontsize=7)
        on_mesh = np.flatnonzero(of_state & (tetrahedra == tetrahedra[of_reference].min()) & np.isfinite(error))
        order = on_mesh[np.argsort(error[on_mesh])[::-1]]
        bars = axes[s, 2]
        bars.barh(range(len(order)), MILLIMETRES * error[order], color="tab:blue")
        bars.set_yticks(range(len(order)), models[order], fontsize=6)
        bars.axvline(MILLIMETRES * noise[s], color="k", linestyle="--", linewidth=0.8)
        bars.set_xlabel("error [mm]; dashed: noise of the measurement")
    figure.suptitle(title)
    figure.tight_layout()
    target = Path(path).with_suffix(".png")
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
    for target in (draw(sys.argv[1]), draw_ring_downs(sys.argv[1])):
        if target:
            print(f"The picture is {target}")


if __name__ == "__main__":
    main()
