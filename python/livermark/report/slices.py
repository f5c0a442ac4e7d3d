"""Slices of the label image that a body was made of, with the contour of its mesh, at rest and deformed.

`livermark` reads the image, by ITK, and hands over three planes of labels as JSON: this package has no reader of images.
"""
from __future__ import annotations

import itertools
import json
import pathlib
from typing import Any, NamedTuple, Optional

import matplotlib.lines
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from livermark.errors import InputError
from livermark.report import colours, figures

SIDE, GAP, KEY = 300.0, 20.0, 72.0  # of a panel, between panels, height of the names below [point]
ENDS = (("R", "L"), ("A", "P"), ("I", "S"))  # of the axes of LPS
MOST_PIXELS = 4096  # along a side of a plane


class Plane(NamedTuple):
    """A plane of voxels; the place of pixel (i, j) is origin + i right + j up."""
    label: numpy.ndarray  #: (height, width)
    origin: numpy.ndarray  #: [m]
    right: numpy.ndarray  #: from pixel to pixel [m]
    up: numpy.ndarray

    @property
    def normal(self) -> numpy.ndarray:
        across = numpy.cross(self.right, self.up)
        return across / numpy.linalg.norm(across)


def _plane(told: dict[str, Any]) -> Plane:
    width, height = (int(size) for size in told["size"])
    if not (0 < width <= MOST_PIXELS and 0 < height <= MOST_PIXELS):
        raise ValueError("its size")
    label = numpy.asarray(told["label"], dtype=int).reshape(height, width)
    origin, right, up = (numpy.asarray(told[name], dtype=float).reshape(3) for name in ("origin", "right", "up"))
    if not numpy.isfinite([origin, right, up]).all() or numpy.linalg.norm(numpy.cross(right, up)) == 0.0:
        raise ValueError("its axes")
    return _as_read(Plane(label, origin, right, up))


def _patient_axes(plane: Plane) -> tuple[int, int, int]:
    """The axes of LPS that are nearest to right, up and normal: of all ways to pair them, because several may be nearest to one alone."""
    near = [numpy.abs(axis) / numpy.linalg.norm(axis) for axis in (plane.right, plane.up, plane.normal)]
    return max(itertools.permutations(range(3)), key=lambda axes: round(float(sum(part[axis] for part, axis in zip(near, axes))), 9))


def _as_read(plane: Plane) -> Plane:
    """The same with left to the right, posterior to the right or down, and superior up, as radiologists look at a patient in LPS."""
    axes = _patient_axes(plane)[:2]
    if axes[0] > axes[1]:
        plane, axes = Plane(plane.label.T, plane.origin, plane.up, plane.right), axes[::-1]
    if plane.right[axes[0]] < 0.0:
        plane = Plane(plane.label[:, ::-1], plane.origin + (plane.label.shape[1] - 1) * plane.right, -plane.right, plane.up)
    if plane.up[axes[1]] < 0.0:
        plane = Plane(plane.label[::-1], plane.origin + (plane.label.shape[0] - 1) * plane.up, plane.right, -plane.up)
    return plane


def planes_of(told: dict[str, Any]) -> list[Plane]:
    """Across the patient's axis from head to feet first, then front to back, then left to right. Raises InputError for what is no planes."""
    try:
        return sorted((_plane(plane) for plane in told["planes"]), key=lambda plane: -_patient_axes(plane)[2])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"slices of an image: they cannot be read ({error})") from error


def read(path: pathlib.Path) -> list[Plane]:
    """Of a JSON file. Raises InputError."""
    return planes_of(json.loads(path.read_text(encoding="utf-8")))


def contour(triangles: numpy.ndarray, points: numpy.ndarray, plane: Plane) -> numpy.ndarray:
    """(S, 2, 2) segments in which a surface cuts a plane, in pixels."""
    distance = (points - plane.origin) @ plane.normal
    distance = numpy.where(distance == 0.0, 1e-15, distance)  # a node on the plane is on one side
    side = distance[triangles] > 0.0
    cut = triangles[side.any(axis=1) & ~side.all(axis=1)]
    ends = []
    for a, b in ((0, 1), (1, 2), (2, 0)):
        first, second = distance[cut[:, a]], distance[cut[:, b]]
        with numpy.errstate(divide="ignore", invalid="ignore"):
            part = first / (first - second)
            place = points[cut[:, a]] + part[:, None] * (points[cut[:, b]] - points[cut[:, a]])
        ends.append(numpy.where(((first > 0.0) != (second > 0.0))[:, None], place, numpy.nan))
    if len(cut) == 0:
        return numpy.zeros((0, 2, 2))
    found = numpy.stack(ends, axis=1)
    is_end = ~numpy.isnan(found[..., 0])  # two of three edges of each triangle
    pair = found[is_end].reshape(-1, 2, 3) - plane.origin
    return numpy.stack([pair @ plane.right / (plane.right @ plane.right), pair @ plane.up / (plane.up @ plane.up)], axis=-1)


def _draw_plane(axes, plane: Plane, shapes: list[tuple[numpy.ndarray, str, str]], triangles: numpy.ndarray) -> None:
    height, width = plane.label.shape
    found = numpy.unique(plane.label)
    index = numpy.searchsorted(found, plane.label)
    palette = numpy.array([(*colours.patch_colours(int(label) % 64 + 1)[-1], 0.0 if label == 0 else 1.0) for label in found])
    axes.imshow(palette[index], origin="lower", interpolation="nearest",
                aspect=float(numpy.linalg.norm(plane.up) / numpy.linalg.norm(plane.right)))
    for points, colour, _ in shapes:
        axes.add_collection(LineCollection(contour(triangles, points, plane), colors=colour, linewidths=1.2))
    across, along, _ = _patient_axes(plane)
    labelled = numpy.argwhere(plane.label > 0)
    if len(labelled):
        margin = 0.06 * max(width, height)
        axes.set_xlim(labelled[:, 1].min() - margin, labelled[:, 1].max() + margin)
        axes.set_ylim(labelled[:, 0].min() - margin, labelled[:, 0].max() + margin)
    if along == 1:  # posterior is down
        axes.invert_yaxis()
    axes.set_xticks([])
    axes.set_yticks([])
    axes.grid(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    low, high = ENDS[across]
    bottom, top = ENDS[along] if along != 1 else ENDS[along][::-1]
    for x, y, word in ((-0.03, 0.5, low), (1.03, 0.5, high), (0.5, -0.05, bottom), (0.5, 1.05, top)):
        axes.text(x, y, word, transform=axes.transAxes, ha="center", va="center", color=colours.SOFT)


def sheet(planes: list[Plane], triangles: numpy.ndarray, points: numpy.ndarray, deformed: Optional[numpy.ndarray] = None,
          name: str = "") -> Figure:
    """The planes side by side, with the contour of the mesh in each. deformed: its points, drawn too; name: of what moved it."""
    shapes = [(points, colours.BLUE, "contour of the mesh")]
    if deformed is not None:
        shapes.append((deformed, colours.VERMILION, name))
    wide, tall = len(planes) * (SIDE + GAP) + GAP, SIDE + KEY + GAP
    with matplotlib.rc_context(figures.SETTINGS):
        page = Figure(figsize=(wide / figures.PIXELS_PER_INCH, tall / figures.PIXELS_PER_INCH), facecolor="white")
        FigureCanvasAgg(page)
        for p, plane in enumerate(planes):
            left = GAP + p * (SIDE + GAP)
            _draw_plane(page.add_axes((left / wide, KEY / tall, (SIDE - GAP) / wide, (SIDE - GAP) / tall)), plane, shapes, triangles)
        for s, (_, colour, words) in enumerate(shapes):
            low = (KEY - 48.0 - 15.0 * s) / tall
            page.add_artist(matplotlib.lines.Line2D([GAP / wide, (GAP + 24.0) / wide], [low + 4.0 / tall] * 2, color=colour, linewidth=1.2))
            page.text((GAP + 30.0) / wide, low, words, fontsize=figures.TEXT)
    return page
