"""Draws the patches of a body from four sides: python3 -m livermark.report.patches BODY.msh PICTURE.png

Prints a line for each patch: its colour and its name.
"""
import pathlib
import sys

import matplotlib.colors
import meshio
import numpy

from livermark.report import colours, surfaces

WIDTH = 400  # of each of the four [pixel]
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
         width: int = WIDTH) -> numpy.ndarray:
    """The four pictures side by side on one scale. of_patches: (B, 3) colours from 0 to 1."""
    side = 1.05 * numpy.ptp(points[triangles.ravel()], axis=0).max()
    # Colours end where facets do, not between their nodes.
    corners = numpy.repeat(of_patches[patch][:, None, :], 3, axis=1)
    pictures = []
    for right, toward in SIDES:
        view = surfaces.View(right, numpy.cross(toward, right), toward, pixel=side / width, width=width, height=width)
        across = numpy.stack([points[triangles.ravel()] @ view.right, points[triangles.ravel()] @ view.up], axis=1)
        low = 0.5 * (across.min(axis=0) + across.max(axis=0) - side)
        view = surfaces.replace(view, low=(low[0], low[1]))
        pictures.append(surfaces.draw_surface(triangles, points, corners, view))
    return numpy.concatenate(pictures, axis=1)


def main(mesh_file: str, picture: str) -> None:
    mesh = meshio.read(mesh_file)
    triangles, patch, names = patches_of(mesh)
    of_patches = colours.patch_colours(len(names))
    drawn = draw(mesh.points, triangles, patch, of_patches)
    pathlib.Path(picture).write_bytes(surfaces.png_of(drawn))
    for colour, name in zip(of_patches, names):
        print(f"{matplotlib.colors.to_hex(colour)}  {name}")


if __name__ == "__main__":
    main(*sys.argv[1:])
