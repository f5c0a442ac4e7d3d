"""Pictures of surfaces with their names and scales in one figure, for files: what the page lays out by its style sheet."""
from __future__ import annotations

from typing import NamedTuple, Optional, Sequence

import matplotlib
import numpy
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator

from livermark.report import colours
from livermark.report.figures import PIXELS_PER_INCH, SETTINGS, TEXT, tick_label, to_svg

PANEL, ALONE, GAP, WORDS = 300.0, 460.0, 14.0, 40.0  # width of a panel, of one alone, room between, height of the words below [point]
BAR = 42.0  # height of a scale with its words


class Panel(NamedTuple):
    """One picture."""
    drawn: numpy.ndarray  #: (H, W, 4)
    title: str
    detail: str


class Scale(NamedTuple):
    """Colours from 0 to a length."""
    colour_map: object
    largest: float
    title: str


def draw_scale(axes: Axes, scale: Scale) -> None:
    """A bar of colours with ticks."""
    axes.imshow(numpy.linspace(0.0, 1.0, 128)[None], cmap=scale.colour_map, aspect="auto", extent=(0.0, scale.largest, 0.0, 1.0),
                interpolation="none")
    axes.set_title(scale.title, fontsize=TEXT, fontweight="normal", pad=5.0)
    axes.grid(False)
    axes.yaxis.set_visible(False)
    for spine in axes.spines.values():
        spine.set_visible(False)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.xaxis.set_major_formatter(FuncFormatter(tick_label))


def gradient(scale: Scale) -> Markup:
    """The bar as inline SVG."""
    with matplotlib.rc_context(SETTINGS):
        axes = Figure(figsize=(232 / PIXELS_PER_INCH, 52 / PIXELS_PER_INCH)).add_axes((6 / 232, 22 / 52, 220 / 232, 12 / 52))
        draw_scale(axes, scale)
        return to_svg(axes.figure, scale.title, "bar")


def _on_white(drawn: numpy.ndarray) -> numpy.ndarray:
    opacity = drawn[..., 3:] / 255.0
    return (opacity * drawn[..., :3] + (1.0 - opacity) * 255.0).astype(numpy.uint8)


def sheet(rows: Sequence[Sequence[Optional[Panel]]], scales: Sequence[Scale]) -> Figure:
    """Rows of panels, a gap where there is None, and the scales below. All panels have one shape."""
    height, width = next(panel for row in rows for panel in row if panel).drawn.shape[:2]
    columns = max(map(len, rows))
    wide = PANEL if columns > 1 else ALONE
    tall = wide * height / width
    size = columns * (wide + GAP) - GAP, len(rows) * (tall + WORDS) + BAR + GAP
    figure = Figure(figsize=tuple(length / PIXELS_PER_INCH for length in size), facecolor="white")
    FigureCanvasAgg(figure)
    for r, row in enumerate(rows):
        for c, panel in enumerate(row):
            if panel is None:
                continue
            left, low = c * (wide + GAP), size[1] - r * (tall + WORDS) - tall
            axes = figure.add_axes((left / size[0], low / size[1], wide / size[0], tall / size[1]))
            axes.imshow(_on_white(panel.drawn), interpolation="none", aspect="auto")
            axes.axis("off")
            figure.text((left + 4.0) / size[0], (low - 14.0) / size[1], panel.title, fontsize=TEXT, fontweight="semibold")
            figure.text((left + 4.0) / size[0], (low - 29.0) / size[1], panel.detail, fontsize=TEXT, color=colours.SOFT)
    for s, scale in enumerate(scales):
        left = s * (wide + GAP) + 6.0
        draw_scale(figure.add_axes((left / size[0], 18.0 / size[1], min(220.0, wide - 12.0) / size[0], 12.0 / size[1])), scale)
    return figure
