"""Figures of Matplotlib as inline SVG: colours are variables of the page, texts are texts in its font, and the same data
give the same bytes. Lengths are in CSS pixels."""
from __future__ import annotations

import io
import itertools
import math
import re
from typing import Sequence

import matplotlib
from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from livermark.report import colours, figure_files
from livermark.report.data import cleaned

PIXELS_PER_INCH = 72.0  # a point of Matplotlib is a pixel then
TEXT, TITLE = 11.5, 13.5
LEFT, RIGHT, TOP, BOTTOM = 58, 12, 30, 44
KEY_LINE = 18
NAME_WIDTH = 6.6  # of a letter beside a row
#: Nothing of a user's matplotlibrc, no mathematics in names, the same names of clip paths each time.
SETTINGS = {
    **matplotlib.rcParamsDefault, "figure.dpi": PIXELS_PER_INCH, "svg.fonttype": "none", "svg.hashsalt": "livermark",
    "text.parse_math": False, "font.size": TEXT, "text.color": colours.INK, "axes.labelcolor": colours.SOFT,
    "axes.labelsize": TEXT, "axes.titlesize": TITLE, "axes.titleweight": "semibold", "axes.titlelocation": "left",
    "axes.edgecolor": colours.AXIS, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
    "axes.axisbelow": True, "axes.facecolor": "none", "figure.facecolor": "none", "grid.color": colours.HAIR,
    "xtick.color": colours.AXIS, "ytick.color": colours.AXIS, "xtick.labelcolor": colours.SOFT,
    "ytick.labelcolor": colours.SOFT, "xtick.labelsize": TEXT, "ytick.labelsize": TEXT, "lines.linewidth": 1.8,
    "lines.markersize": 7, "lines.markeredgewidth": 0, "legend.frameon": False, "legend.fontsize": TEXT}


def tick_label(value: float, _=None) -> str:
    """Short: 0.05, 20, 1e-06."""
    return f"{value:.0e}" if value != 0.0 and not 1e-3 <= abs(value) < 1e5 else f"{value:.6g}"


def new_plot(title: str, x_label: str, y_label: str, width: int = 440, height: int = 310) -> Axes:
    """Axes of a figure of their own; texts may be of files."""
    with matplotlib.rc_context(SETTINGS):
        figure = Figure(figsize=(width / PIXELS_PER_INCH, height / PIXELS_PER_INCH))
        FigureCanvasAgg(figure)  # which measures texts
        figure.subplots_adjust(LEFT / width, BOTTOM / height, 1.0 - RIGHT / width, 1.0 - TOP / height)
        axes = figure.add_subplot()
        axes.set_title(title, pad=12.0)
        axes.set_xlabel(x_label, labelpad=6.0)
        axes.set_ylabel(y_label)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_formatter(FuncFormatter(tick_label))
            axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    return axes


def new_rows(title: str, x_label: str, names: Sequence[str], width: int, row: int) -> Axes:
    """Axes with a row of some height for each name, the first at the bottom, and room for the longest name."""
    height = TOP + BOTTOM + row * len(names)
    axes = new_plot(title, x_label, "", width, height)
    with matplotlib.rc_context(SETTINGS):
        axes.figure.subplots_adjust(left=(20 + NAME_WIDTH * max(map(len, names))) / width)
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(-0.6, len(names) - 0.4)
    return axes


def set_logarithmic(axes: Axes, names: str, values: dict[str, Sequence[float]]) -> None:
    """Makes the axes x, y or xy logarithmic over the values that can be drawn there, with a margin."""
    for name in names:
        axis = getattr(axes, f"{name}axis")
        shown = [value for value in values[name] if math.isfinite(value) and value > 0.0] or [1.0]
        margin = max((max(shown) / min(shown)) ** 0.07, 1.3)
        low, high = min(shown) / margin, max(shown) * margin
        with matplotlib.rc_context(SETTINGS):
            getattr(axes, f"set_{name}scale")("log")
            getattr(axes, f"set_{name}lim")(low, high)
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if math.log10(high / low) < 2.5 else (1.0,), numticks=9))
        axis.set_minor_locator(NullLocator())
        axis.set_major_formatter(FuncFormatter(tick_label))


def draw_line(axes: Axes, x: Sequence[float], y: Sequence[float], name: str, style: colours.Style) -> None:
    """A series with markers. Values that cannot be drawn leave a gap."""
    with matplotlib.rc_context(SETTINGS):
        axes.plot(x, y, color=style.colour, marker=style.marker, linestyle=style.dash, label=name)


def has_points(x: Sequence[float], y: Sequence[float]) -> bool:
    """Whether there is a point to draw on logarithmic axes."""
    return any(math.isfinite(a) and math.isfinite(b) and a > 0.0 and b > 0.0 for a, b in zip(x, y))


def _add_key(axes: Axes, width: float) -> float:
    """Names of series below the axes, in as many columns as they have room for. Returns the height."""
    handles, names = axes.get_legend_handles_labels()
    if not names:
        return 0.0
    longest = max(map(len, names))
    columns = max(1, min(len(names), int((width - LEFT) // (46 + 6.4 * longest))))
    rows = math.ceil(len(names) / columns)
    axes.figure.legend(handles, names, loc="lower left", ncol=columns, bbox_to_anchor=(LEFT / width, 0.0),
                       borderaxespad=0.0, borderpad=0.2, handlelength=2.2, handletextpad=0.6, columnspacing=1.4,
                       labelspacing=(KEY_LINE - TEXT * 1.25) / TEXT)
    return rows * KEY_LINE + 8.0


def finish(axes: Axes, kind: str = "") -> Markup:
    """The figure as inline SVG, with a key below it if its series have names. kind: ends the name of its files; by default its
    title."""
    figure = axes.figure
    with matplotlib.rc_context(SETTINGS):
        width, height = figure.get_size_inches() * PIXELS_PER_INCH
        key = _add_key(axes, width)
        if key:
            height += key
            figure.set_size_inches(width / PIXELS_PER_INCH, height / PIXELS_PER_INCH)
            figure.subplots_adjust(bottom=(BOTTOM + key) / height, top=1.0 - TOP / height)
        figure_files.keep(lambda: figure, SETTINGS, kind or axes.get_title("left"))
        return to_svg(figure, axes.get_title("left"), "plot")


def to_svg(figure: Figure, title: str, css_class: str) -> Markup:
    stream = io.StringIO()
    with matplotlib.rc_context(SETTINGS):
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        figure.savefig(stream, format="svg", metadata=nothing)
    svg = stream.getvalue()
    width, height = figure.get_size_inches() * PIXELS_PER_INCH
    body = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index(">", svg.index("<svg")) + 1:], flags=re.DOTALL)
    body = re.sub("<[^>]*>", _plain_tag, body)
    used = set(re.findall(r'(?:href="|url\()#([^")]*)', body))
    body = re.sub(r' id="([^"]*)"', lambda found: found[0] if found[1] in used else "", body)
    return Markup(f'<svg class="{css_class}" style="max-width:{1.25 * width:.0f}px" viewBox="0 0 {width:g} {height:g}" '
                  'role="img" xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink">'
                  f"<title>{escape(cleaned(title))}</title>{body.strip()}\n")


def _plain_tag(found: re.Match) -> str:
    """A tag with colours of the page, sizes of texts alone, and numbers to a hundredth of a pixel."""
    tag = found[0]
    for colour, name in colours.VARIABLES.items():
        tag = tag.replace(colour, f"var(--{name})")
    tag = re.sub(r"font: ([0-9]+ )?([0-9.]+px)[^;\"]*",
                 lambda font: (f"font-weight: {font[1].strip()}; " if font[1] else "") + f"font-size: {font[2]}", tag)
    return tag if "base64," in tag else re.sub(r"(\d+\.\d\d)\d+", r"\1", tag)


def numbered(page: str) -> str:
    """A page in which no two figures have the same names inside."""
    numbers = itertools.count()

    def renamed(svg: re.Match) -> str:
        prefix = f"s{next(numbers)}-"
        return re.sub(r'( id="|href="#|url\(#)', rf"\g<1>{prefix}", svg[0])
    return re.sub(r"<svg.*?</svg>", renamed, page, flags=re.DOTALL)
