"""Pictures of experiments, two views of a body at one scale whatever its shape, and what the report says of them."""
import h5py
import numpy
import pytest
from livermark.report.experiment_figure import draw, draw_states
from livermark.report.sections import experiments

STATES, MODELS = ["hangs", "hangs with a weight"], ["elements", "springs"]


def write_bar(path, size, is_solved=True):
    """Experiment file of a bar [m] with a marker at its far corner and one that was not seen."""
    points = numpy.array(size) * [[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)]
    triangles = [[0, 1, 3], [0, 3, 2], [4, 7, 5], [4, 6, 7], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7],
                 [1, 7, 3]]
    moved = numpy.full((2, 2, 3), 0.002)
    moved[:, 1] = numpy.nan
    with h5py.File(path, "w") as file:
        group = file.create_group("experiment")
        group.attrs.update({"title": "A bar", "reference": "elements"})
        file["experiment/states/displacement"] = moved
        file["experiment/states/noise"] = [0.0, 1e-4]
        file["experiment/states"].attrs["names"] = STATES
        file["experiment/markers/position"] = points[[7, 5]]
        file["experiment/markers"].attrs["drives"] = ["", ""]
        file["experiment/body/points"] = points
        file["experiment/body/displacement"] = numpy.zeros((2, 8, 3))
        file["experiment/body/boundary_triangles"] = numpy.array(triangles)
        runs = file.create_group("experiment/runs")
        runs.attrs["models"] = numpy.repeat(MODELS, 2).tolist()
        runs["state"], runs["tetrahedra"] = [0, 1, 0, 1], [5, 5, 5, 5]
        runs["displacement"] = numpy.full((4, 2, 3), 0.0021 if is_solved else numpy.nan)
        runs["error"] = numpy.full(4, 1e-4 if is_solved else numpy.nan)
    return path


def views_of(figure):
    """The axes in which a body is drawn."""
    figure.canvas.draw()
    return [axes for axes in figure.axes if axes.get_title(loc="left").startswith("seen along")]


@pytest.mark.parametrize("size", [(0.3, 0.03, 0.03), (0.03, 0.3, 0.03), (0.03, 0.03, 0.3), (0.06, 0.06, 0.06), (1.0, 0.01, 0.01)])
def test_a_body_has_one_scale_in_all_views_and_labels_apart(tmp_path, size):
    figure = draw_states(write_bar(tmp_path / "bar.h5", size))
    views = views_of(figure)
    assert len(views) == 2 * len(STATES)
    scales = [extent / (limits[1] - limits[0]) for axes in views
              for extent, limits in ((axes.bbox.width, axes.get_xlim()), (axes.bbox.height, axes.get_ylim()))]
    assert numpy.allclose(scales, scales[0], rtol=1e-9)
    longest = scales[0] * 1e3 * max(size) / figure.dpi  # [in]
    assert 3.5 < longest <= 10.0
    if max(size) >= 10.0 * min(size):
        assert longest > 8.0
    for axes in views:
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            shown = [label.get_window_extent() for place, label in zip(axis.get_ticklocs(), axis.get_ticklabels())
                     if low <= place <= high]
            assert len(shown) >= 2
            assert not any(a.overlaps(b) for a, b in zip(shown, shown[1:]))
    boxes = [axes.get_tightbbox() for axes in figure.axes]
    assert not any(a.overlaps(b) for k, a in enumerate(boxes) for b in boxes[:k])
    assert all(0.0 <= box.x0 and box.x1 <= figure.bbox.width and 0.0 <= box.y0 and box.y1 <= figure.bbox.height for box in boxes)


def test_an_experiment_without_a_solution_has_a_picture(tmp_path):
    target = draw(write_bar(tmp_path / "bar.h5", (0.3, 0.03, 0.03), is_solved=False))
    assert target == tmp_path / "bar.png" and target.stat().st_size > 0


@pytest.mark.parametrize("rigid_motion, is_compared", [(0.002, True), (numpy.nan, False)])
def test_the_report_compares_with_a_rigid_motion_where_there_is_one(tmp_path, rigid_motion, is_compared):
    with h5py.File(write_bar(tmp_path / "bar.h5", (0.3, 0.03, 0.03)), "r+") as file:
        file["experiment/states/straight_line"] = [numpy.nan, numpy.nan]
        file["experiment/states/rigid_motion"] = [rigid_motion, rigid_motion]
        text = str(experiments._verdict(file, {"elements": [1e-4, 1e-4]}))
    assert "Nearest to the markers is elements" in text and ("rigid" in text) == is_compared
