"""A report has to be well-formed XML that holds all it needs, and be the same each time it is made.

usage: report_page_test.py LIVERMARK FILE.h5...
"""
import base64
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import xml.etree.ElementTree

XHTML = "{http://www.w3.org/1999/xhtml}"


def make(livermark, folder, *options):
    done = subprocess.run([livermark, "report", folder, *options], check=True, capture_output=True, text=True)
    path = pathlib.Path(done.stdout.strip())
    assert path.is_file(), done.stdout
    return path


def check_picture(image):
    kind, data = image.get("src").split(",", 1)
    assert kind == "data:image/png;base64", kind
    png = base64.b64decode(data, validate=True)
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", png[16:24]) == (int(image.get("width")), int(image.get("height")))
    assert image.get("alt"), "a picture without words"


def main():
    livermark, *files = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            shutil.copy(file, folder)
        page = make(livermark, folder)
        assert page == pathlib.Path(folder) / "report.html"
        text = page.read_text(encoding="utf-8")
        again = make(livermark, folder, "-o", f"{folder}/again.html")
        assert again.read_text(encoding="utf-8").replace(f" -o {folder}/again.html", "") == text, "another page"
        assert page.read_bytes() == make(livermark, folder).read_bytes(), "other bytes"

    root = xml.etree.ElementTree.fromstring(text)
    elements = list(root.iter())
    tags = {element.tag.removeprefix(XHTML) for element in elements}
    assert str(pathlib.Path(livermark).parent) not in text, "where it was built"
    assert "<code>livermark report" in text
    assert "@media screen and (prefers-color-scheme: dark)" in text
    assert not tags & {"script", "link", "iframe", "object"}, tags
    assert "url(" not in text.replace("url(#", "") and "@import" not in text, "the page asks for more"
    images = root.findall(f".//{XHTML}img")
    assert len(images) >= 6, len(images)
    for image in images:
        check_picture(image)
    ids = [element.get("id") for element in elements if element.get("id")]
    assert len(ids) == len(set(ids)), ids
    for used in re.findall(r'(?:xlink:href="|url\()#([^")]*)', text):
        assert used in ids, used
    for drawn in root.iter("{http://www.w3.org/2000/svg}image"):
        assert drawn.get("{http://www.w3.org/1999/xlink}href").startswith("data:image/png;base64,")
    for link in root.iter(f"{XHTML}a"):
        target = link.get("href")
        assert target == "https://doi.org/10.11113/jt.v75.5068" or target[1:] in ids, target
    for element in elements:  # what only a pointer finds is lost on paper
        assert element.get("title") is None and not any(name.startswith("on") for name in element.keys()), element.keys()
    for table in root.iter(f"{XHTML}table"):
        widths = {len(row) for row in table.iter(f"{XHTML}tr")}
        assert len(widths) == 1, widths
    for figure in root.iter(f"{XHTML}figure"):
        assert figure.find(f"{XHTML}figcaption") is not None, "a figure without caption"


if __name__ == "__main__":
    main()
