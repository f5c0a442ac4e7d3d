"""Draws the patches of a body from four sides, and its vessels:

    python3 -m livermark.report.patches BODY.msh PICTURE.png [--vessels VESSELS.swc] [--slices SLICES.json]

The picture has their names below, each beside its colour. Prints these too, a line for each patch. Below the names are slices of
the image that the body was made of, where there are some, with the contour of the mesh.
"""
import argparse
import io
import pathlib
from typing import Optional

import matplotlib
import matplotlib.colors
import meshio
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image

from livermark.report import colours, figures, slices, surfaces
from livermark.vessels import Vessels, read_swc

WIDTH = 400  # of each of the four [pixel]
NAMES_IN_A_ROW, ROW = 6, 30  # of the key; height [pixel]
X, Y, Z = numpy.eye(3)
#: Right and toward: from the front, from behind, from above and from below, as a patient in LPS lies.
SIDES = ((X, -Y), (-X, Y), (X, Z), (X, -Z))


def patches_of(mesh: meshio.Mesh) -> tuple[numpy.ndarray, numpy.ndarray, list[str]]:
    """Triangles of the boundary (T, 3), the number of the patch of each (T), and the names of the patches, in alphabetical
    order, so that a name has the same colour on every body that has these names."""
    triangles, patch = [], []
    for block, tags in zip(mesh.cells, mesh.cell_data["gmsh:physical"]):
        if block.type == "triangle":
            triangles.append(block.data)
            patch.append(numpy.asarray(tags, dtype=int) - 1)
    tags = {name: int(tag) for name, (tag, dimension) in mesh.field_data.items() if dimension == 2}
    names = sorted(tags)
    place = numpy.argsort([tags[name] for name in names])
    return numpy.concatenate(triangles), place[numpy.concatenate(patch)], names


def draw(points: numpy.ndarray, triangles: numpy.ndarray, patch: numpy.ndarray, of_patches: numpy.ndarray,
         width: int = WIDTH, vessels: Optional[Vessels] = None) -> numpy.ndarray:
    """The four pictures side by side on one scale. of_patches: (B, 3) colours from 0 to 1. vessels: seen through the surface."""
    side = 1.05 * numpy.ptp(points[triangles.ravel()], axis=0).max()
    # Colours end where facets do, not between their nodes.
    corners = numpy.repeat(of_patches[patch][:, None, :], 3, axis=1)
    pictures = []
    for right, toward in SIDES:
        view = surfaces.View(right, numpy.cross(toward, right), toward, pixel=side / width, width=width, height=width)
        across = numpy.stack([points[triangles.ravel()] @ view.right, points[triangles.ravel()] @ view.up], axis=1)
        low = 0.5 * (across.min(axis=0) + across.max(axis=0) - side)
        view = surfaces.replace(view, low=(low[0], low[1]))
        pictures.append(surfaces.draw_surface(triangles, points, corners, view, vessels=vessels))
    rgba = numpy.concatenate(pictures, axis=1).astype(float)
    opacity = rgba[..., 3:] / 255.0
    return (opacity * rgba[..., :3] + (1.0 - opacity) * 255.0).astype(numpy.uint8)


def save_with_key(drawn: numpy.ndarray, names: list[str], of_patches: numpy.ndarray, path: pathlib.Path) -> None:
    """The pictures as they are, and the names of what they show below them."""
    height, width = drawn.shape[:2]
    key = ROW * (-(-len(names) // NAMES_IN_A_ROW)) + 10
    with matplotlib.rc_context(figures.SETTINGS):
        page = Figure(figsize=(width / figures.PIXELS_PER_INCH, (height + key) / figures.PIXELS_PER_INCH),
                      dpi=figures.PIXELS_PER_INCH, facecolor="white")
        FigureCanvasAgg(page)
        page.figimage(drawn, 0, key)
        page.legend(handles=[Patch(color=tuple(colour), label=name) for colour, name in zip(of_patches, names)], loc="lower center",
                    ncol=min(NAMES_IN_A_ROW, len(names)), fontsize=15, handlelength=1.2, columnspacing=1.4, borderaxespad=0.2)
        page.savefig(path, dpi=figures.PIXELS_PER_INCH, metadata={"Software": None})


def add_below(path: pathlib.Path, below: Figure) -> None:
    """Puts a figure below the picture of a file, both in the middle, on white."""
    stream = io.BytesIO()
    below.savefig(stream, format="png", dpi=1.2 * figures.PIXELS_PER_INCH)
    parts = [Image.open(path).convert("RGB"), Image.open(stream).convert("RGB")]
    width = max(part.width for part in parts)
    whole = Image.new("RGB", (width, sum(part.height for part in parts)), "white")
    top = 0
    for part in parts:
        whole.paste(part, ((width - part.width) // 2, top))
        top += part.height
    whole.save(path, "png")


def main(mesh_file: str, picture: str, vessel_file: str = "", slice_file: str = "") -> None:
    mesh = meshio.read(mesh_file)
    triangles, patch, names = patches_of(mesh)
    of_patches = colours.patch_colours(len(names))
    vessels = read_swc(vessel_file) if vessel_file else None
    drawn = draw(mesh.points, triangles, patch, of_patches, vessels=vessels)
    if vessels is not None:
        names, of_patches = [*names, "vessels"], numpy.concatenate([of_patches, [numpy.array(colours.VESSELS) / 255.0]])
    save_with_key(drawn, names, of_patches, pathlib.Path(picture))
    if slice_file:
        add_below(pathlib.Path(picture), slices.sheet(slices.read(pathlib.Path(slice_file)), triangles, mesh.points))
    for colour, name in zip(of_patches, names):
        print(f"{matplotlib.colors.to_hex(colour)}  {name}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="livermark.report.patches")
    for place in ("body", "picture"):
        parser.add_argument(place)
    for option in ("--vessels", "--slices"):
        parser.add_argument(option, default="")
    options = parser.parse_args()
    main(options.body, options.picture, options.vessels, options.slices)
