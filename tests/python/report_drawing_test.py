"""How the report draws: colours, surfaces, vessels in them, names beside points, and SVG that goes with the page."""
import math
import os
import pathlib
import re
import xml.etree.ElementTree

import numpy
import pytest
from livermark.report import colours, figures, labels, surfaces
from livermark.studies.tables import fixed, rounded_up
from livermark.vessels import Vessels
from matplotlib.colors import to_hex

NOTHING = (0, 0, 0, 0)
CORNERS = numpy.array([[0.0, 0, 0], [8, 0, 0], [0, 8, 0]])
TRIANGLE = numpy.array([[0, 1, 2]])
X, Y, Z = numpy.eye(3)


def from_above(size):
    """Looks down along z at a square of so many pixels of 1 m, its corner at the origin."""
    return surfaces.View(X, Y, Z, (0.0, 0.0), 1.0, size, size)


def of_one_colour(triangles, colour):
    return numpy.broadcast_to(numpy.array(colour, float), (len(triangles), 3, 3))


@pytest.mark.parametrize("name, colour_map", [("displacement", colours.DISPLACEMENT), ("error", colours.ERROR)])
def test_colour_maps_are_those_of_the_page(name, colour_map):
    source = pathlib.Path(os.environ["LIVERMARK_SOURCE_DIR"]) / "app/viewer/src/picture/colour_maps.ts"
    stops = re.search(f"const {name} = `([^`]*)`", source.read_text()).group(1).split()
    assert len(stops) > 8
    for at, stop in zip(numpy.linspace(0.0, 1.0, len(stops)), stops):
        expected = [int(stop[k:k + 2], 16) for k in (0, 2, 4)]
        assert numpy.allclose(255.0 * numpy.array(colour_map(at)[:3]), expected, atol=3.0), (name, at)


def test_colours_of_patches_are_those_of_the_page():
    source = pathlib.Path(os.environ["LIVERMARK_SOURCE_DIR"]) / "app/viewer/src/picture/patch_colours.ts"
    of_page = [tuple(map(int, colour)) for colour in re.findall(r"\[(\d+), (\d+), (\d+)\]", source.read_text())]
    assert tuple(of_page) == colours.PATCHES
    more = colours.patch_colours(2 * len(colours.PATCHES))
    assert len({to_hex(colour) for colour in more}) == len(more)


def test_the_colour_of_vessels_is_that_of_the_page():
    source = pathlib.Path(os.environ["LIVERMARK_SOURCE_DIR"]) / "app/viewer/src/picture/vessel_colour.ts"
    colour = re.search(r"vesselColour: Colour = \[(\d+), (\d+), (\d+)\]", source.read_text()).groups()
    assert tuple(map(int, colour)) == colours.VESSELS


def test_colours_get_brighter_of_displacements_and_darker_of_errors_all_the_way():
    def luma(colour_map):
        return colour_map(numpy.linspace(0.0, 1.0, 101))[:, :3] @ [0.2126, 0.7152, 0.0722]
    assert (numpy.diff(luma(colours.DISPLACEMENT)) > 0.0).all()
    assert (numpy.diff(luma(colours.ERROR)) < 0.0).all()


def test_a_model_looks_the_same_wherever_it_is():
    models = ["fem_p1", *(f"springs_{k}" for k in range(18)), "fem_p2"]
    styles = [colours.style_of(model, models) for model in models]
    assert len({(style.colour, style.marker) for style in styles}) == len(models)
    assert styles[0].colour in colours.GREYS and styles[1].colour == colours.BLUE
    assert colours.style_of("fem_p2", ["fem_p1", "fem_p2"]) == styles[-1]


def test_a_surface_covers_the_pixels_of_a_triangle():
    picture = surfaces.draw_surface(TRIANGLE, CORNERS, of_one_colour(TRIANGLE, (0.0, 0.5, 1.0)), from_above(8))
    for y in range(8):
        for x in range(8):  # its long side runs from the top left to the bottom right, y down
            if x < y - 1:
                assert numpy.allclose(picture[y, x], (0, 128, 255, 255), atol=4), (x, y)
            elif x > y + 1:
                assert tuple(picture[y, x]) == NOTHING, (x, y)


def test_colours_change_between_the_corners():
    large = 12.5 * CORNERS
    corners = numpy.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]])
    picture = surfaces.draw_surface(TRIANGLE, large, corners, from_above(100))
    assert numpy.allclose(picture[-1, 50, :3], (0.505 * 255, 0.005 * 255, 0), atol=6)
    assert numpy.allclose(picture[49, 0, :3], (0.005 * 255, 0.505 * 255, 0), atol=6)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_what_is_near_hides_what_is_far(order):
    points = numpy.concatenate([CORNERS, CORNERS + [0.0, 0.0, 1.0]])
    triangles = numpy.array([[0, 1, 2], [3, 4, 5]])[list(order)]
    of_each = numpy.array([[1.0, 0, 0], [0, 0, 1.0]])[list(order)]
    picture = surfaces.draw_surface(triangles, points, numpy.repeat(of_each[:, None], 3, axis=1), from_above(8))
    assert numpy.allclose(picture[6, 1], (0, 0, 255, 255), atol=4)


def test_a_surface_that_is_turned_away_is_darker():
    tilted = CORNERS.copy()
    tilted[2] = [0.0, 8.0, 8.0]  # at 45 degrees
    picture = surfaces.draw_surface(TRIANGLE, tilted, of_one_colour(TRIANGLE, (1.0, 1.0, 1.0)), from_above(8))
    assert picture[6, 1, 0] == pytest.approx(255 * (0.5 + 0.5 * 0.5 ** 0.5), abs=4)


def test_edges_are_sharp_where_triangles_meet_at_a_right_angle():
    points = numpy.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    triangles = numpy.array([[0, 1, 2], [0, 2, 3]])
    normals = surfaces._corner_normals(triangles, points)
    assert numpy.allclose(normals[0], Z) and numpy.allclose(normals[1], X)
    points[3] = [-1.0, 0.5, 0.1]
    smooth = surfaces._corner_normals(triangles, points)
    assert numpy.allclose(smooth[0, 0], smooth[1, 0]) and numpy.allclose(smooth[0, 1], Z)


def test_the_outline_at_rest_stays_where_a_body_has_left():
    view = from_above(10)
    outline = surfaces.outline_of(TRIANGLE, CORNERS, view)
    away = CORNERS + [100.0, 0.0, 0.0]
    picture = surfaces.draw_surface(TRIANGLE, away, of_one_colour(TRIANGLE, (1.0, 0.0, 0.0)), view, outline)
    assert picture[5, 0, 3] > 60  # a side of the triangle
    assert tuple(picture[7, 2]) == NOTHING and tuple(picture[0, 9]) == NOTHING


def test_a_view_shows_what_moves_and_all_of_it():
    points = numpy.array([[x, y, z] for x in (-1.0, 1) for y in (-0.1, 0.1) for z in (-1.0, 1)])
    triangles = numpy.array([[0, 4, 5], [0, 5, 1], [2, 7, 6], [2, 3, 7], [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5],
                             [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])  # a plate, its broad sides along y
    displacement = numpy.where(points[:, 1:2] < 0.0, 1.0, 0.0) * [0.0, -1.0, 0.0]
    view = surfaces.find_view(triangles, points, displacement, [points, points + displacement], 200)
    assert view.toward[1] < -0.8
    samples = view.project(numpy.concatenate([points, points + displacement]))
    assert samples[:, :2].min() >= 0.0
    assert (samples[:, :2].max(axis=0) <= [surfaces.SAMPLES * view.width, surfaces.SAMPLES * view.height]).all()


def test_names_cover_neither_each_other_nor_points():
    names = [f"model_{k}" for k in range(6)]
    x = [1.0, 1.01, 1.02, 5.0, 5.01, 9.0]
    axes = figures.new_plot("title", "x", "y")
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(0.0, 10.0)
    labels.name_points(axes, x, [5.0] * 6, names)
    renderer = axes.figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer).extents for text in axes.texts if text.get_text()]
    assert len(boxes) == 6
    points = axes.transData.transform(numpy.column_stack([x, [5.0] * 6]))
    for b, box in enumerate(boxes):
        for other in boxes[:b]:
            common = numpy.minimum(box[2:], other[2:]) - numpy.maximum(box[:2], other[:2])
            assert not (common > 1.0).all(), (box, other)
        assert not ((points > box[:2]) & (points < box[2:])).all(axis=1).any()


def test_a_figure_has_the_colours_of_the_page_and_texts_as_texts():
    def draw():
        axes = figures.new_plot("<b> & $x_1$", "x", "y")
        figures.draw_line(axes, [0.0, 1.0], [1.0, 2.0], "a_name", colours.Style(colours.BLUE, "o"))
        return str(figures.finish(axes))
    svg = draw()
    assert svg == draw()
    root = xml.etree.ElementTree.fromstring(svg)
    found = {"".join(text.itertext()) for text in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"<b> & $x_1$", "a_name", "x", "y"} <= found
    assert "var(--blue)" in svg and colours.BLUE not in svg
    assert "font-family" not in svg and "DejaVu" not in svg and "<metadata" not in svg


def test_no_two_figures_of_a_page_have_the_same_names_inside():
    svg = '<svg><path id="a"/><use href="#a"/><g clip-path="url(#a)"/></svg>'
    page = figures.numbered(svg + "<p/>" + svg)
    assert re.findall(r' id="([^"]*)"', page) == ["s0-a", "s1-a"]
    assert page.count("s0-a") == page.count("s1-a") == 3


def test_numbers_are_written_as_in_the_tables_of_the_program():
    assert fixed(12.346, 2) == "12.35"
    assert fixed(1.234e34, 2) == "1.2e+34" and fixed(float("nan"), 2) == "-"
    assert [rounded_up(value) for value in (0.03, 1.0, 1.1, 5.1)] == [0.05, 1.0, 2.0, 10.0]
    assert [figures.tick_label(value) for value in (0.05, 20.0, 1e-6)] == ["0.05", "20", "1e-06"]
    assert to_hex(colours.DISPLACEMENT(0.0)) == "#440154"


def test_vessels_are_seen_through_a_surface_as_wide_as_they_are():
    sheet = of_one_colour(TRIANGLE, (0.0, 0.0, 0.0))
    lines = Vessels(numpy.array([[0.0, 20.0, -1.0], [60.0, 20.0, -1.0], [0.0, 90.0, 0.0], [90.0, 90.0, 0.0]]),
                    numpy.array([6.0, 6.0, 2.0, 4.0]), numpy.array([[0, 1], [2, 3]]))
    picture = surfaces.draw_surface(TRIANGLE, 12.0 * CORNERS, sheet, from_above(100), vessels=lines)
    expected = surfaces.VESSEL_OPACITY * numpy.array(colours.VESSELS)
    assert numpy.allclose(picture[79, 30, :3], expected, atol=6) and picture[79, 30, 3] == 255  # y goes down
    is_blue = picture[..., 2].astype(int) > picture[..., 0].astype(int) + 20
    assert abs(is_blue[:, 30].sum() - 12 - 6) <= 2, "two tubes, the other one of a mean radius of 3"
    assert is_blue[9, 80] and 0 < picture[9, 80, 3] < 255, "and beside the surface"
    assert not is_blue[50:60, 30].any()


def test_vessels_move_with_the_tetrahedra_that_hold_them(bar):
    points, tetrahedra = bar
    gradient, shift = numpy.array([[0.1, -0.2, 0.3], [0.05, 0.2, -0.1], [-0.3, 0.1, 0.2]]), numpy.array([1e-3, -2e-3, 5e-4])
    inside = 0.01 * numpy.random.default_rng(2).random((50, 3))
    places = numpy.concatenate([inside, points, [[0.02, 0.011, 0.012]]])
    lines = Vessels(places, numpy.full(len(places), 1e-3), numpy.array([[0, 1], [1, 2]]))
    moved = lines.moved(points, tetrahedra, points @ gradient.T + shift)
    with_mesh = places + places @ gradient.T + shift  # outside as inside
    assert numpy.abs(moved.points - with_mesh).max() < 1e-14
    assert lines.volume == pytest.approx(math.pi * 1e-6 * sum(numpy.linalg.norm(places[k + 1] - places[k]) for k in (0, 1)))
