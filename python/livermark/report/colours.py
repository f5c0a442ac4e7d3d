"""Colours of the report. Those of series are variables of the style sheet, so that they change with the page."""
from __future__ import annotations

from dataclasses import dataclass

import matplotlib
import numpy
from matplotlib.colors import ListedColormap

#: Of lines and texts, as drawn, and their variables in templates/style.css.
INK, SOFT, HAIR, AXIS, FAINT, BAND = "#1d2329", "#56606a", "#e8ebed", "#8a949d", "#b5bdc4", "#c3cad0"
PAPER = "#ffffff"
#: Okabe and Ito's colours without the yellow, which is too light for lines on white.
BLUE, VERMILION, GREEN, PINK, ORANGE, SKY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"
#: Finite elements.
GREYS = ("#111111", "#555555", "#888888", "#aaaaaa")
SERIES = (BLUE, VERMILION, GREEN, PINK, ORANGE, SKY)
VARIABLES = {
    PAPER: "paper", INK: "ink", SOFT: "soft", HAIR: "hair", AXIS: "axis", FAINT: "faint", BAND: "band", BLUE: "blue",
    VERMILION: "vermilion", GREEN: "green", PINK: "pink", ORANGE: "orange", SKY: "sky",
    **{grey: f"grey-{g}" for g, grey in enumerate(GREYS)}}

#: The maps of the page, app/viewer/src/picture/colour_maps.ts: viridis, and magma from pale to dark without its ends (van der
#: Walt and Smith 2015). Equal steps look equal, and they are legible in grey and to the colour-blind.
DISPLACEMENT = matplotlib.colormaps["viridis"]
ERROR = ListedColormap(matplotlib.colormaps["magma"](numpy.linspace(248 / 255, 33 / 255, 256)), "error")

#: Of the patches of a body, as on the page (app/viewer/src/picture/patch_colours.ts): pale, so that light on a surface is seen.
PATCHES = ((119, 170, 221), (238, 221, 136), (68, 187, 153), (238, 136, 102), (255, 170, 187), (187, 204, 51), (153, 221, 255),
           (170, 170, 0))
#: Of vessels that are lines, as on the page (app/viewer/src/picture/vessel_colour.ts).
VESSELS = (40, 120, 245)


def patch_colours(count: int) -> numpy.ndarray:
    """(count, 3) from 0 to 1. With more patches than colours these come again, darker each time."""
    patch = numpy.arange(count)
    return numpy.array(PATCHES)[patch % len(PATCHES)] * 0.65 ** (patch // len(PATCHES))[:, None] / 255.0


@dataclass(frozen=True)
class Style:
    """How one series looks; marker and dash as Matplotlib names them."""
    colour: str
    marker: str
    dash: str = "-"


def style_of(model: str, models: list[str]) -> Style:
    """The same look for a model wherever it is drawn: finite elements in greys, others in colours."""
    is_finite_elements = model.startswith("fem_")
    place = [name for name in models if name.startswith("fem_") == is_finite_elements].index(model)
    colours, markers = (GREYS, "sXP") if is_finite_elements else (SERIES, "oD^")
    turn = place // len(colours) % 3
    return Style(colours[place % len(colours)], markers[turn], ("-", "--", "-.")[turn])
