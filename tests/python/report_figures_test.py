"""`livermark report --figures`: each figure as SVG and PDF, on white, with texts as texts and fonts inside."""
import base64
import io
import re
import shutil
import subprocess
import xml.etree.ElementTree

import numpy
import pytest
from conftest import BINARY, RUNS
from livermark.report import figure_files, figures, picture_sheets
from livermark.report.colours import BLUE, ERROR, Style

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """A folder with a report and its figures, and what the program printed."""
    folder = tmp_path_factory.mktemp("figures")
    shutil.copytree(RUNS / "beam", folder / "beam")
    done = subprocess.run([BINARY, "report", str(folder), "--figures"], check=True, capture_output=True, text=True)
    return folder, done.stdout.splitlines()


def test_names_say_body_load_case_and_kind_and_are_printed(written):
    folder, printed = written
    assert printed[0] == str(folder / "report.html")
    found = sorted(str(path) for path in (folder / "figures").iterdir())
    assert sorted(printed[1:]) == found
    names = {path.rpartition("/")[2] for path in found}
    for name in ("beam-beam_bend-error_from_the_hand", "beam-small_loads-both_numbers", "beam-beam_bend-picture",
                 "beam-beam_release-picture"):
        assert {f"{name}.svg", f"{name}.pdf"} <= names, names
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.startswith("<!DOCTYPE html>")
    charts = page.count('<svg class="plot"')
    assert len(found) == 2 * (charts + 3), "each chart, a picture of each load case and the first one"


def test_without_the_option_there_are_no_files(tmp_path):
    shutil.copy(RUNS / "beam" / "beam_bend.h5", tmp_path)
    subprocess.run([BINARY, "report", str(tmp_path)], check=True, capture_output=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["beam_bend.h5", "report.html"]


def test_files_have_texts_white_ground_and_fonts(written):
    folder, _ = written
    for path in (folder / "figures").glob("*.svg"):
        text = path.read_text(encoding="utf-8")
        root = xml.etree.ElementTree.fromstring(text)
        words = ["".join(item.itertext()) for item in root.iter(f"{SVG}text")]
        assert any("lloyd" in word or "nodal" in word for word in words), path
        ground = next(item for item in root.iter(f"{SVG}path"))
        assert "fill: #ffffff" in ground.get("style"), path
        assert "var(--" not in text
        assert re.findall(r"@font-face \{ font-family: '([^']*)'; font-weight: (\d+)", text) == [("DejaVu Sans", "400"), ("DejaVu Sans", "600")]
    for path in (folder / "figures").glob("*.pdf"):
        content = path.read_bytes()
        assert content.startswith(b"%PDF-") and b"/FontFile2" in content and b"/Type3" not in content, path


def test_the_font_inside_has_all_letters_of_the_texts(tmp_path):
    ttlib = pytest.importorskip("fontTools.ttLib")
    with figure_files.kept_in(tmp_path) as files:
        axes = figures.new_plot("± & <é>", "x", "y")
        figures.draw_line(axes, [0.0, 1.0], [1.0, 2.0], "a name", Style(BLUE, "o"))
        figures.finish(axes)
    text = (tmp_path / f"{files.names[0]}.svg").read_text(encoding="utf-8")
    words = "".join("".join(item.itertext()) for item in xml.etree.ElementTree.fromstring(text).iter(f"{SVG}text"))
    for data in re.findall(r"base64,([^)]*)\) format", text):
        font = ttlib.TTFont(io.BytesIO(base64.b64decode(data)))
        assert set(map(ord, words)) - {ord("\n")} <= set(font.getBestCmap())


def test_the_same_figures_are_the_same_bytes_and_equal_names_get_numbers(tmp_path):
    def write(folder):
        with figure_files.kept_in(folder) as files, figure_files.about("a body/../x", "press"):
            for _ in range(2):
                figures.finish(figures.new_plot("title", "x", "y"), "kind")
        return files.names
    assert write(tmp_path / "a") == write(tmp_path / "b") == ["a_body_.._x-press-kind", "a_body_.._x-press-kind-2"]
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name
    figures.finish(figures.new_plot("title", "x", "y"), "kind")
    assert len(list((tmp_path / "a").iterdir())) == 4, "nothing is kept when it is closed"


def test_a_folder_that_cannot_be_made_is_a_sentence(tmp_path):
    (tmp_path / "figures").write_text("a file")
    with pytest.raises(figure_files.NotWritten, match="figures/kind.svg: cannot be written"):
        with figure_files.kept_in(tmp_path / "figures"):
            figures.finish(figures.new_plot("title", "x", "y"), "kind")


def test_a_sheet_of_pictures_is_on_white_with_their_names():
    drawn = numpy.zeros((20, 30, 4), dtype=numpy.uint8)
    drawn[5:15, 5:15] = (255, 0, 0, 255)
    sheet = picture_sheets.sheet([[picture_sheets.Panel(drawn, "left", "a"), None], [None, picture_sheets.Panel(drawn, "right", "b")]],
                                 [picture_sheets.Scale(ERROR, 2.0, "error [mm]")])
    assert {text.get_text() for text in sheet.texts} == {"left", "a", "right", "b"}
    pixels = sheet.axes[0].images[0].get_array()
    assert tuple(pixels[0, 0]) == (255, 255, 255) and tuple(pixels[10, 10]) == (255, 0, 0)
