"""The figures of a report as files for a thesis, each as SVG and PDF: on white, texts as texts, with the fonts inside."""
from __future__ import annotations

import base64
import contextlib
import functools
import io
import logging
import pathlib
import re
from typing import Callable, Iterator, Optional

import matplotlib
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont

from livermark.plain_files import whole_file

FAMILY = "DejaVu Sans"  # which Matplotlib brings
WEIGHTS = {400: "normal", 600: "semibold"}
LONGEST_NAME = 120
NO_DATES = {"svg": dict.fromkeys(("Creator", "Date", "Format", "Type")), "pdf": dict.fromkeys(("Creator", "Producer", "CreationDate"))}
FILES = {"svg.fonttype": "none", "pdf.fonttype": 42, "font.family": FAMILY}  # 42: TrueType, which can be searched and edited


class NotWritten(Exception):
    """A sentence on a file that cannot be written."""


class FigureFiles:
    """Files of one report."""

    def __init__(self, folder: pathlib.Path):
        self.folder = folder
        self.names: list[str] = []  #: without .svg and .pdf, in the order of the page

    def write(self, figure: Figure, words: tuple[str, ...]) -> None:
        name = self._new_name(words)
        for ending, finished in (("svg", _with_fonts), ("pdf", bytes)):
            stream = io.BytesIO()
            figure.savefig(stream, format=ending, facecolor="white", metadata=NO_DATES[ending])
            _write_whole(self.folder / f"{name}.{ending}", finished(stream.getvalue()))
        self.names.append(name)

    def _new_name(self, words: tuple[str, ...]) -> str:
        """Of letters that every system takes; a number tells those apart that would be the same."""
        name = "-".join(filter(None, (re.sub(r"[^A-Za-z0-9_.-]+", "_", word).strip("_.-") for word in words)))[:LONGEST_NAME]
        name, number = name or "figure", 1
        while (numbered := name if number == 1 else f"{name}-{number}") in self.names:
            number += 1
        return numbered


_files: Optional[FigureFiles] = None
_about: tuple[str, ...] = ()


@contextlib.contextmanager
def kept_in(folder: Optional[pathlib.Path]) -> Iterator[Optional[FigureFiles]]:
    """While it is open, keep() writes figures there; nowhere where folder is None."""
    global _files
    before, _files = _files, FigureFiles(folder) if folder else None
    try:
        yield _files
    finally:
        _files = before


@contextlib.contextmanager
def about(*words: str) -> Iterator[None]:
    """While it is open, names of files begin with the words: a body, and a load case where there is one."""
    global _about
    before, _about = _about, _about + words
    try:
        yield
    finally:
        _about = before


def keep(make: Callable[[], Figure], settings: dict, kind: str) -> None:
    """Writes a figure if files are wanted. kind: the end of its name."""
    if _files is not None:
        with matplotlib.rc_context({**settings, **FILES}):
            _files.write(make(), (*_about, kind))


def _write_whole(path: pathlib.Path, content: bytes) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(path) as part:
            part.write_bytes(content)
    except OSError as error:
        raise NotWritten(f"{path}: cannot be written ({error.strerror}); choose another folder with --output") from error


def _with_fonts(svg: bytes) -> bytes:
    """The same with the letters that it uses inside, so that it looks alike where the font is not installed."""
    text = svg.decode("utf-8")
    letters = "".join(sorted(set("".join(re.findall(r"<text[^>]*>([^<]*)", text)))))
    if not letters:
        return svg
    faces = "".join(f"@font-face {{ font-family: '{FAMILY}'; font-weight: {weight}; "
                    f"src: url(data:font/woff;base64,{_part_of_font(name, letters)}) format('woff'); }}\n"
                    for weight, name in WEIGHTS.items())
    start = text.index(">", text.index("<svg")) + 1
    return f"{text[:start]}\n<defs><style type=\"text/css\">\n{faces}</style></defs>{text[start:]}".encode()


@functools.lru_cache(maxsize=256)
def _part_of_font(weight: str, letters: str) -> str:
    """In base64. letters: XML, so those of its entities are there too, which does no harm."""
    from fontTools import subset
    from fontTools.ttLib import TTFont
    logging.getLogger("fontTools").setLevel(logging.ERROR)
    font = TTFont(findfont(FontProperties(family=FAMILY, weight=weight)), recalcTimestamp=False)
    made = subset.Subsetter(subset.Options(layout_features=["kern"], hinting=False, notdef_outline=True))
    made.populate(text=letters + "&<>\"'")
    made.subset(font)
    font.flavor = "woff"
    stream = io.BytesIO()
    font.save(stream)
    return base64.b64encode(stream.getvalue()).decode()
