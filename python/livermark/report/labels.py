"""Names beside points, where they cover neither points nor each other."""
from __future__ import annotations

from typing import Sequence

import matplotlib
import numpy
from matplotlib.axes import Axes

from livermark.report import colours
from livermark.report.figures import SETTINGS, TEXT

GAP, HALF_MARKER, LINE = 7.0, 5.0, 1.15 * TEXT
#: A label is put in one of eight directions, at one of these distances in lines.
DIRECTIONS = ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1))
RINGS = (1.0, 2.0, 3.0, 4.5, 6.0)

#: Hides lines behind a name; markers are above it.
BEHIND = {"facecolor": colours.PAPER, "alpha": 0.8, "pad": 0.5, "linewidth": 0}


def _common_areas(box: numpy.ndarray, others: numpy.ndarray) -> numpy.ndarray:
    """Of a box (left, bottom, right, top) with each of others."""
    if len(others) == 0:
        return numpy.zeros(0)
    sizes = numpy.minimum(box[2:], others[:, 2:]) - numpy.maximum(box[:2], others[:, :2])
    return numpy.prod(numpy.maximum(sizes, 0.0), axis=1)


def _candidates(point: numpy.ndarray, width: float):
    """Boxes where a label could be, and what each costs because it is far away."""
    for ring in RINGS:
        for side, up in DIRECTIONS:
            left = point[0] + (GAP if side > 0 else -GAP - width if side < 0 else -0.5 * width)
            middle = point[1] + up * ring * LINE
            yield numpy.array([left, middle - 0.5 * LINE, left + width, middle + 0.5 * LINE]), ring


def name_points(axes: Axes, x: Sequence[float], y: Sequence[float], names: Sequence[str]) -> None:
    """Puts names beside points that are inside the axes, with a thin line where a name is far from its point.

    The axes have their limits and their place in the figure.
    """
    with matplotlib.rc_context(SETTINGS):
        renderer = axes.figure.canvas.get_renderer()
        panel = numpy.array(axes.get_window_extent(renderer).extents)
        points = axes.transData.transform(numpy.column_stack([x, y]))
        markers = numpy.hstack([points - HALF_MARKER, points + HALF_MARKER])
        taken = numpy.zeros((0, 4))
        for point, name in zip(points, names):
            text = axes.text(0, 0, name)
            width = text.get_window_extent(renderer).width
            text.remove()
            area = width * LINE

            def cost(candidate):
                box, ring = candidate
                outside = area - _common_areas(box, panel[None])[0]
                return 4.0 * outside + ring + _common_areas(box, markers).sum() + _common_areas(box, taken).sum()
            box, _ = min(_candidates(point, width), key=cost)
            taken = numpy.vstack([taken, box])
            middle = 0.5 * (box[1] + box[3])
            is_far = abs(middle - point[1]) > 1.6 * TEXT
            axes.annotate(name, point, (box[0], middle), xycoords="figure pixels", textcoords="figure pixels",
                          va="center_baseline", ha="left", zorder=1.5, bbox=BEHIND)
            if is_far:
                end = (numpy.clip(point[0], box[0], box[2]), box[1] if middle > point[1] else box[3])
                axes.annotate("", point, end, xycoords="figure pixels", textcoords="figure pixels",
                              arrowprops={"arrowstyle": "-", "color": colours.FAINT, "linewidth": 0.8, "shrinkA": 0,
                                          "shrinkB": 0})
