"""Draws the patches of a body from four sides, and its vessels: python3 -m livermark.report.patches BODY.msh PICTURE.png [VESSELS.swc]

The picture has their names below, each beside its colour. Prints these too, a line for each patch.
"""
import pathlib
import sys
from typing import Optional

import matplotlib
import matplotlib.colors
import meshio
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from livermark.report import colours, figures, surfaces
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


def main(mesh_file: str, picture: str, vessel_file: str = "") -> None:
    mesh = meshio.read(mesh_file)
    triangles, patch, names = patches_of(mesh)
    of_patches = colours.patch_colours(len(names))
    vessels = read_swc(vessel_file) if vessel_file else None
    drawn = draw(mesh.points, triangles, patch, of_patches, vessels=vessels)
    if vessels is not None:
        names, of_patches = [*names, "vessels"], numpy.concatenate([of_patches, [numpy.array(colours.VESSELS) / 255.0]])
    save_with_key(drawn, names, of_patches, pathlib.Path(picture))
    for colour, name in zip(of_patches, names):
        print(f"{matplotlib.colors.to_hex(colour)}  {name}")


if __name__ == "__main__":
    main(*sys.argv[1:])
