"""Pictures of surfaces: triangles that the software renderer of Matplotlib fills, the far ones first.

VTK of Debian needs a screen and ends the program where there is none, as on a server.
"""
from __future__ import annotations

import base64
import io
import math
from dataclasses import dataclass, replace
from typing import Optional

import numpy
from markupsafe import Markup, escape
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.transforms import IdentityTransform
from matplotlib.path import Path
from PIL import Image

from livermark.report import colours as colours_of_report
from livermark.vessels import Vessels

SAMPLES = 2  # along each side of a pixel
SMOOTH_COSINE = 0.75  # triangles that meet at a sharper angle have an edge between them
LEAST_LIGHT = 0.5  # brightness of a surface seen from its side
OUTLINE_GREY = 128  # seen on white and on black
VESSEL_OPACITY = 0.8  # of what is seen through a surface
VESSEL_EDGE = 0.55  # brightness of the rim of a tube, which parts it from those behind it
MARGIN = 4  # [pixel] on each side
TALLEST = 1.5  # of the width


@dataclass(frozen=True)
class View:
    """Where one looks at a body from, along parallel lines, and which part of the plane across them is in the picture."""
    right: numpy.ndarray  #: of unit length, at right angles, like the next two
    up: numpy.ndarray
    toward: numpy.ndarray  #: points at who looks
    low: tuple[float, float] = (0.0, 0.0)  #: corner of the picture along right and up [m]
    pixel: float = 1.0  #: side of a pixel [m]
    width: int = 1  #: [pixel]
    height: int = 1

    def project(self, points: numpy.ndarray) -> numpy.ndarray:
        """(..., 3) along right and up in samples of the picture, and toward [m]."""
        scale = SAMPLES / self.pixel
        return numpy.stack([scale * (points @ self.right - self.low[0]), scale * (points @ self.up - self.low[1]),
                            points @ self.toward], axis=-1)


def area_vectors(triangles: numpy.ndarray, points: numpy.ndarray) -> numpy.ndarray:
    """(T, 3) normals as long as the areas [m^2]"""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return 0.5 * numpy.cross(b - a, c - a)


def _looking_along(azimuth: float, elevation: float) -> View:
    toward = numpy.array([math.cos(elevation) * math.cos(azimuth), math.cos(elevation) * math.sin(azimuth),
                          math.sin(elevation)])
    right = numpy.cross([0.0, 0.0, 1.0], toward)
    right /= numpy.linalg.norm(right)
    return View(right, numpy.cross(toward, right), toward)


def looking_from(direction: numpy.ndarray, tilt: float = 0.0) -> View:
    """From a direction of unit length, raised by an angle [rad]. z is up, or y where one looks down or up along z."""
    across = numpy.cross([0.0, 0.0, 1.0], direction)
    if numpy.linalg.norm(across) < 0.7:
        across = numpy.cross([0.0, 1.0, 0.0], direction)
    right = across / numpy.linalg.norm(across)
    up = numpy.cross(direction, right)
    toward = math.cos(tilt) * direction + math.sin(tilt) * up
    return View(right, numpy.cross(toward, right), toward)


def fitted(view: View, shapes: list[numpy.ndarray], width: int, tallest: float = TALLEST) -> View:
    """The same with all shapes in the picture, in the middle. tallest: height over width."""
    across = numpy.concatenate([numpy.stack([shape @ view.right, shape @ view.up], axis=1) for shape in shapes])
    low, size = across.min(axis=0), numpy.ptp(across, axis=0)
    room = width - 2 * MARGIN
    pixel = max(size[0], size[1] / tallest) / room
    corner = (low[0] - 0.5 * (room * pixel - size[0]) - MARGIN * pixel, low[1] - MARGIN * pixel)
    return replace(view, low=corner, pixel=pixel, width=width, height=math.ceil(size[1] / pixel) + 2 * MARGIN)


def find_view(triangles: numpy.ndarray, points: numpy.ndarray, displacement: numpy.ndarray,
              shapes: list[numpy.ndarray], width: int) -> View:
    """One of sixteen directions around the body, from a little above or below, that shows much of the body and of what
    moves: these count alike. Vertical is z. shapes: all that is to be in the picture."""
    views = [_looking_along(math.pi * (0.25 * i - 0.5) - 0.2, elevation) for elevation in (0.3, -0.3) for i in range(8)]
    facing = numpy.maximum(area_vectors(triangles, points) @ numpy.stack([view.toward for view in views], axis=1), 0.0)
    moving = numpy.linalg.norm(displacement[triangles].mean(axis=1), axis=1)
    areas, motions = facing.sum(axis=0), moving @ facing
    merit = areas / areas.max() + motions / motions.max()
    return fitted(views[int(numpy.argmax(merit))], shapes, width)


def _corner_normals(triangles: numpy.ndarray, points: numpy.ndarray) -> numpy.ndarray:
    """(T, 3, 3) for each corner the mean of the triangles at its node that go on smoothly from its triangle."""
    areas = area_vectors(triangles, points)
    normals = areas / numpy.maximum(numpy.linalg.norm(areas, axis=1, keepdims=True), 1e-300)
    node = triangles.ravel()
    order = numpy.argsort(node, kind="stable")
    count = numpy.bincount(node, minlength=len(points))
    start = numpy.concatenate([[0], numpy.cumsum(count)])[node]
    sums = numpy.zeros((len(node), 3))
    corner = numpy.arange(len(node))
    for k in range(count.max()):
        has_one = corner[k < count[node]]
        other = order[start[has_one] + k] // 3
        is_smooth = numpy.einsum("ij,ij->i", normals[other], normals[has_one // 3]) > SMOOTH_COSINE
        sums[has_one] += numpy.where(is_smooth[:, None], areas[other], 0.0)
    lengths = numpy.maximum(numpy.linalg.norm(sums, axis=1, keepdims=True), 1e-300)
    return (sums / lengths).reshape(-1, 3, 3)


def _filled(view: View, corners: numpy.ndarray, colours: numpy.ndarray) -> numpy.ndarray:
    """Samples (H, W, 4), with nothing where there is no triangle. corners: (T, 3, 3) as projected; colours: (T, 3, 4)."""
    renderer = RendererAgg(SAMPLES * view.width, SAMPLES * view.height, 72.0)
    order = numpy.argsort(corners[:, :, 2].sum(axis=1), kind="stable")
    renderer.draw_gouraud_triangles(renderer.new_gc(), numpy.ascontiguousarray(corners[order, :, :2]), colours[order],
                                    IdentityTransform())
    return numpy.asarray(renderer.buffer_rgba()).copy()


def outline_of(triangles: numpy.ndarray, points: numpy.ndarray, view: View) -> numpy.ndarray:
    """Which samples of a picture the outline of a shape covers; the same for all pictures of one view."""
    corners = view.project(points)[triangles]
    inside = _filled(view, corners, numpy.ones((len(triangles), 3, 4)))[..., 3] > 127
    framed = numpy.pad(inside, 1)
    inner = framed[1:-1, 1:-1]
    return numpy.logical_or.reduce([inner != framed[1 + y:framed.shape[0] - 1 + y, 1 + x:framed.shape[1] - 1 + x]
                                    for y, x in ((1, 0), (-1, 0), (0, 1), (0, -1))])


def _tubes(view: View, vessels: Vessels) -> numpy.ndarray:
    """Samples (H, W, 4) of tubes as wide as they are, the far ones first."""
    renderer = RendererAgg(SAMPLES * view.width, SAMPLES * view.height, 72.0)
    colour = numpy.array(colours_of_report.VESSELS) / 255.0
    ends = view.project(vessels.points)[vessels.segments]
    radius = vessels.radius[vessels.segments].mean(axis=1)
    depth = ends[:, :, 2].mean(axis=1)
    context = renderer.new_gc()
    context.set_capstyle("round")
    # Rims are a few radii behind, so that they do not part tubes that join.
    strokes = [(depth - 4.0 * radius, 1.0, VESSEL_EDGE), (depth, 0.6, 1.0)]
    order = numpy.argsort(numpy.concatenate([far for far, _, _ in strokes]), kind="stable")
    for stroke, s in zip(order // len(ends), order % len(ends)):
        _, part, brightness = strokes[stroke]
        context.set_linewidth(max(part * 2.0 * radius[s] * SAMPLES / view.pixel, 1.0))
        context.set_foreground(tuple(brightness * colour))
        renderer.draw_path(context, Path(ends[s, :, :2]), IdentityTransform())
    return numpy.asarray(renderer.buffer_rgba()).copy()


def draw_surface(triangles: numpy.ndarray, points: numpy.ndarray, colours: numpy.ndarray, view: View,
                 outline=None, vessels: Optional[Vessels] = None) -> numpy.ndarray:
    """(height, width, 4) a surface lit from where one looks, so that a part that faces the eye has its own colours.
    Nothing behind it, whatever the colour of the page. colours: (T, 3, 3) of the corners, from 0 to 1. outline: drawn over it; of the same view.
    vessels: seen through it, where they are drawn."""
    facing = numpy.abs(_corner_normals(triangles, points) @ view.toward)
    light = LEAST_LIGHT + (1.0 - LEAST_LIGHT) * facing
    shaded = numpy.concatenate([colours * light[..., None], numpy.ones((len(triangles), 3, 1))], axis=2)
    samples = _filled(view, view.project(points)[triangles], shaded).astype(numpy.float32)
    if vessels is not None:
        tubes = _tubes(view, vessels).astype(numpy.float32)
        part = VESSEL_OPACITY * tubes[..., 3:] / numpy.float32(255.0)
        samples[..., :3] = (1.0 - part) * samples[..., :3] + part * tubes[..., :3]
        samples[..., 3:] = numpy.maximum(samples[..., 3:], 255.0 * part)
    if outline is not None:
        samples[outline] = (OUTLINE_GREY, OUTLINE_GREY, OUTLINE_GREY, 255.0)
    samples[..., :3] *= samples[..., 3:] / numpy.float32(255.0)  # so that nothing has no colour
    mean = sum(samples[y::SAMPLES, x::SAMPLES] for y in range(SAMPLES) for x in range(SAMPLES)) / SAMPLES ** 2
    mean[..., :3] /= numpy.maximum(mean[..., 3:] / 255.0, 1.0 / 255.0)
    # In 64 steps, which nobody sees, and which halve the size of a file.
    return numpy.minimum(numpy.round(mean / 4.0) * 4.0, 255.0).astype(numpy.uint8)


def png_of(picture: numpy.ndarray) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "png")
    return stream.getvalue()


def image(picture: numpy.ndarray, words: str) -> Markup:
    """An element of the page. words: what it shows."""
    height, width = picture.shape[:2]
    data = base64.b64encode(png_of(picture)).decode()
    return Markup(f'<img width="{width}" height="{height}" alt="{escape(words)}" src="data:image/png;base64,{data}"/>')
