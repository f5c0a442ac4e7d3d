"""What a body was made of and how sure that is, for a body that comes from an image of a patient."""
from __future__ import annotations

import math
import pathlib
import tomllib
from typing import Any, Optional

import numpy
from markupsafe import Markup

from livermark.report import figure_files, figures, slices
from livermark.report.data import Column, ReportData, Result, Table, cleaned, with_signs
from livermark.report.parts import bullets, figure, paragraph, table
from livermark.report.sections.pictures import DRAWN_PART, LEAST_DRAWN
from livermark.studies.tables import MILLIMETRES, PERCENT, fixed, rounded_up
from livermark.volumes import tetrahedron_volumes

MADE_OF = "made of the segmentation "  # how the reader of bodies begins its remark on the image
NEAR = ("median", "in the median"), ("percentile_95", "at 95 %"), ("worst", "at most")


def is_patient(result: Result) -> bool:
    """Whether a body comes from an image, or its patches were found by its shape."""
    return result.patch_confidence is not None or any(remark.startswith(MADE_OF) for remark in result.assumptions)


def _number(table: Any, *names: str) -> float:
    """NaN where a file has no such number."""
    for key in names:
        table = table.get(key) if isinstance(table, dict) else None
    return float(table) if isinstance(table, (int, float)) and not isinstance(table, bool) else math.nan


def body_file(result: Result, folder: pathlib.Path) -> Optional[dict[str, Any]]:
    """What the .toml of a body says, where `livermark run` puts it: beside the folder of its results. None where there is
    none, or where it is of another mesh."""
    if pathlib.PurePath(result.body).name != result.body:  # a file may say any name
        return None
    with result.open() as file:
        counts = len(file.tetrahedra), len(file.points)
    for place in dict.fromkeys((result.path.parent.parent, result.path.parent, folder)):
        try:
            said = cleaned(tomllib.loads((place / f"{result.body}.toml").read_text(encoding="utf-8")))
        except (OSError, ValueError):
            continue
        if tuple(_number(said, "image", "mesh", key) for key in ("tetrahedra", "nodes")) == counts:
            return said
    return None


def _distance(said: Optional[dict[str, Any]], result: Result) -> str:
    """A sentence on how far the surface of the mesh is from that of the voxels."""
    found = [(words, _number(said, "image", "mesh", "surface_from_voxels", key)) for key, words in NEAR]
    if not all(math.isfinite(value) for _, value in found):
        return (f"Surface: its distance from that of the voxels is not known here. If the body was made of an image, {result.body}.toml has "
                "it; put that file beside the folder of these results.")
    return "Surface: its distance from that of the voxels is " + ", ".join(
        f"{MILLIMETRES * value:.2f} mm {words}" for words, value in found) + "."


def _orientation(result: Result) -> str:
    if result.patch_confidence is None:
        return "Orientation: as the file of the body says; it was not checked against a shape."
    return (f"Orientation: found by laying the liver that ships over this body, with a confidence of {result.patch_confidence:.2f} "
            "from 0 to 1.")


def _held(cases: list[Result]) -> str:
    places: dict[str, list[str]] = {}
    for result in cases:
        with result.open() as file:
            tools = set((file.tools or {}).get("places", ()))
            held = [place for place in cleaned(file.constraint_names) if place not in tools]
            held += ["elastic foundation"] if file.foundation else []
        places.setdefault(", ".join(held) or "nothing", []).append(result.load_case)
    return "Held: " + "; ".join(f"{place} under {', '.join(dict.fromkeys(of))}" for place, of in places.items()) + "."


def _left_out(result: Result) -> str:
    """Names what the body has none of; empty where it has all."""
    with result.open() as file:
        lacks = [word for word, part in (("capsule", file.capsule), ("vessels as lines", file.vessels),
                                         ("map of stiffness", file.modulus_factor)) if part is None]
    return f"Left out of the body: {', '.join(lacks)}." if lacks else ""


def _regions(result: Result, said: Optional[dict[str, Any]]) -> Table:
    """Volume and material of each region."""
    with result.open() as file:
        volume = numpy.bincount(file.region, tetrahedron_volumes(file.points, file.tetrahedra), len(file.region_names))
        names, materials = cleaned(file.region_names), file.materials
    rows = []
    for r, region in enumerate(names):
        voxels = _number(said, "image", "volumes", region)
        off = round(PERCENT * (volume[r] / voxels - 1.0), 1) + 0.0 if voxels > 0.0 else math.nan
        rows.append([region, fixed(1e6 * volume[r], 2), fixed(1e6 * voxels, 2), fixed(off, 1), fixed(1e-3 * materials["young_modulus"][r], 1),
                     f"{materials['poisson_ratio'][r]:g}", f"{materials['density'][r]:g}"])
    return Table([Column("region"), Column("mesh [mL]", True), Column("voxels [mL]", True), Column("off [%]", True),
                  Column("Young's modulus [kPa]", True), Column("Poisson's ratio", True), Column("density [kg/m³]", True)],
                 rows)


def _sources(result: Result, said: Optional[dict[str, Any]]) -> list[str]:
    """Where the material of each region comes from, a sentence for regions with the same source."""
    tables = (said or {}).get("regions")
    regions: dict[str, list[str]] = {}
    for region in result.regions:
        of_region = tables.get(region) if isinstance(tables, dict) else None
        if isinstance(of_region, dict) and isinstance(of_region.get("source"), str):
            regions.setdefault(with_signs(of_region["source"]), []).append(region)
    return [f"Material of {', '.join(names)}: {source.rstrip('.')}." for source, names in regions.items()]


def _slices(data: ReportData, cases: list[Result]) -> Markup:
    """Three slices of the image with the contour of the mesh at rest and as the best springs move it; nothing without an image."""
    told = data.slices.get(cases[0].body, {})
    result = next((case for case in cases if case.load_case == told.get("load_case")), None)
    if result is None:
        return Markup("")
    planes, springs = slices.planes_of(told["slices"]), result.best_springs
    with result.open() as file:
        points, triangles = file.points, file.boundary_triangles
        moved = file[springs.name].displacement if springs else None
    words, deformed, moves = "", None, ""
    size = float(numpy.linalg.norm(numpy.ptp(points, axis=0)))
    longest = float(numpy.linalg.norm(moved, axis=1).max()) if springs else 0.0
    if springs and LEAST_DRAWN * size < longest < 100.0 * size:
        factor = max(1.0, 1.0 / rounded_up(longest / (DRAWN_PART * size)))
        words = f"as {springs.name} deforms it" + (f", {factor:g} times as far" if factor > 1.0 else "")
        deformed, moves = points + factor * moved, f"; red: {words} under {result.load_case}"
    sheet = slices.sheet(planes, triangles, points, deformed, words)
    figure_files.keep(lambda: sheet, figures.SETTINGS, f"{result.label}-{result.load_case}-slices")
    return figure("figure", figures.to_svg(sheet, f"{result.label}: slices of its image", "plot"),
                  f"{result.label}: slices of the label image below the tool. Blue: the contour of the mesh{moves}. "
                  "R, L, A, P, I and S are the patient's right, left, front, back, feet and head.", [result.command])


def facts(data: ReportData, label: str, cases: list[Result]) -> Markup:
    """Nothing for a body that ships."""
    first = cases[0]
    if not is_patient(first):
        return Markup("")
    said = body_file(first, data.folder)
    sentences = [_orientation(first), _distance(said, first), *_sources(first, said), _held(cases), _left_out(first)]
    html = paragraph("A patient's body. What was found, and what was assumed:") + bullets([text for text in sentences if text])
    html += figure("table", table(_regions(first, said)), f"{label}: volume and material of each region.", [first.command])
    html += _slices(data, cases)
    return html + Markup("<details>\n<summary>Remarks of the readers of this body</summary>\n{}</details>\n").format(
        bullets(list(dict.fromkeys(remark for result in cases for remark in result.assumptions))))
