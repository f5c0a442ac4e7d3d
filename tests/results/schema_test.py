"""schema_test.py <schema.md> <folder>: the tables of schema.md and files that together hold everything say the same.

A result file is what all sections say but those of other files; one of these is the section named and where it comes from.
"""

import math
import re
import sys

import h5py

OTHER_FILES = {
    "Cohort files": "sample_cohort.h5",
    "Arena files": "sample_arena.h5",
    "Needle files": "sample_needles.h5",
    "Cut files": "sample_cut.h5",
    "Tool scenes": "sample_scene.h5",
    "Experiment files": "sample_experiment.h5",
    "Sensitivity files": "sample_sensitivity.h5",
    "Stability files": "sample_stability.h5",
    "Calibration files": "sample_calibration.h5",
    "Timing files": "sample_timings.h5",
}
PROVENANCE = "Where it comes from"
TYPES = {"float64": "<f8", "float32": "<f4", "int64": "<i8", "int32": "<i4", "uint8": "|u1"}


def read_tables(path, wanted_section):
    """{path: (shape, type, unit)} of all lines of the tables that say what is in the file."""
    lines = {}
    section = ""
    for line in open(path, encoding="utf-8"):
        if line.startswith("## "):
            section = line[3:].strip()
        if section not in (wanted_section, PROVENANCE) if wanted_section else section in OTHER_FILES:
            continue
        cells = [cell.strip() for cell in line.strip().strip("|").split(" |")]
        if match := re.fullmatch(r"`(/.*)`", cells[0]):
            assert len(cells) == 5, line
            assert match[1] not in lines, f"{match[1]} stands twice in {path}"
            lines[match[1]] = tuple(cells[1:4])
    return lines


def general(path, file):
    """The path with <model> for the name of a model, <n> for the number of a needle or a motion, and <benchmark> for that
    of a benchmark."""
    path = re.sub(r"^/timings/[^@]+?(/seconds)?(?=@|$)", r"/timings/<benchmark>\1", path)
    path = re.sub(r"^/needles/\d+(/models/[^/@]+)?",
                  lambda found: "/needles/<n>" + ("/models/<model>" if found[1] else ""), path)
    path = re.sub(r"^/experiment/(ring_downs|forces)/\d+", r"/experiment/\1/<n>", path)
    path = re.sub(r"^/cut/models/[^/@]+", "/cut/models/<model>", path)
    for model in file.get("/solutions", ()):
        path = re.sub(rf"(/solutions/|/comparisons/|/modes/|displacement_|error_){model}(?=[/@]|$)", r"\1<model>", path)
    return path


def entries(file):
    """(path, shape, dtype, units) of every dataset and attribute, under each of its names."""

    def walk(group, prefix):
        yield from attributes(group, prefix or "/")
        for name, item in group.items():
            if isinstance(item, h5py.Group):
                yield from walk(item, f"{prefix}/{name}")
            else:
                yield f"{prefix}/{name}", item.shape, item.dtype, item.attrs.get("units", b"").decode()
                yield from attributes(item, f"{prefix}/{name}")

    def attributes(item, path):
        for name in item.attrs:
            if name != "units":
                attribute = item.attrs.get_id(name)
                yield f"{path}@{name}", attribute.shape, attribute.dtype, ""

    yield from walk(file, "")


def check_type(path, dtype, said):
    text = h5py.check_string_dtype(dtype)
    if said == "text":
        assert text and text.length is not None and text.encoding == "utf-8", f"{path} is {dtype}"
    elif said == "ASCII":
        assert text and text.length is not None and text.encoding == "ascii", f"{path} is {dtype}"
    else:
        assert not text and dtype.str == TYPES[said], f"{path} is {dtype} and not {said}"


def sizes_of(found, tables):
    """{letter: size}: the first shape that has a letter alone says its size, and all others have to agree."""
    sizes = {}
    for line, shape in found:
        said = tables[line][0]
        for text, extent in zip(said.strip("()").split(",") if " or " not in said else (), shape):
            if re.fullmatch("[A-Z]", text):
                sizes.setdefault(text, extent)
    return sizes


def size(text, sizes):
    """Of 3, N, 4M, FN or M+1."""
    factor, symbols, addend = re.fullmatch(r"(\d*)([A-Z]*)(?:\+(\d+))?", text).groups()
    return int(factor or 1) * math.prod(sizes[symbol] for symbol in symbols) + int(addend or 0)


def check_shape_and_type(path, shape, dtype, said_shapes, said_types, sizes):
    """Shape and type are those said; where there is a choice, the first shape goes with the first type."""
    shapes = [tuple(size(text, sizes) for text in said.strip("()").split(",") if text)
              for said in said_shapes.split(" or ")]
    assert shape in shapes, f"{path} has shape {shape} and not {said_shapes} = {shapes}"
    check_type(path, dtype, said_types.split(" or ")[shapes.index(shape)] if " or " in said_types else said_types)


def check(schema, results, section):
    tables = read_tables(schema, section)
    assert tables, f"{schema} has no tables in section '{section}'"
    missing = set(tables)
    for result in results:
        missing -= lines_of(result, schema, tables, section)
    assert not missing, f"in {schema} and not in {results}: {sorted(missing)}"


def lines_of(result, schema, tables, section):
    """Lines of the tables that a file has; all that it has is as they say."""
    with h5py.File(result) as file:
        found = [(general(path, file), path, shape, dtype, units) for path, shape, dtype, units in entries(file)]
    for line, path, shape, dtype, units in found:
        assert line in tables, f"not in {schema}: | `{line}` | {shape} | {dtype} | {units} | |"
    sizes = sizes_of([(line, shape) for line, _, shape, _, _ in found], tables)
    if not section:
        assert len(set(sizes.values())) == len(sizes) - 2, f"{sizes}: only R, P and G may be equal"
    for line, path, shape, dtype, units in found:
        said_shape, said_type, said_unit = tables[line]
        check_shape_and_type(path, shape, dtype, said_shape, said_type, sizes)
        assert units == said_unit, f"{path} has units '{units}' and not '{said_unit}'"
    return {line for line, *_ in found}


def main(schema, folder):
    # No tool is a plate and two jaws; the body with jaws has a capsule and a map.
    check(schema, [f"{folder}/sample_result.h5", f"{folder}/with_jaws_result.h5"], "")
    for section, file in OTHER_FILES.items():
        check(schema, [f"{folder}/{file}"], section)


if __name__ == "__main__":
    main(*sys.argv[1:])
