"""write_body.py BODY.toml CONTRAST POISSON OUT.toml: the same body with other materials.

Young's modulus of every region but the first becomes CONTRAST times that of the first, Poisson's ratio of all POISSON.
Everything else, sources and patches, stays as it is.
"""
import os
import pathlib
import re
import sys
import tomllib


def with_materials(text, contrast, poisson_ratio, mesh):
    first = next(iter(tomllib.loads(text)["regions"]))
    first_modulus = tomllib.loads(text)["regions"][first]["young_modulus"]
    lines, region = [], None
    for line in text.splitlines():
        if header := re.match(r"\s*\[(.+)\]\s*$", line):
            region = header[1].removeprefix("regions.") if header[1].startswith("regions.") else None
        if region is None and re.match(r"mesh\s*=", line):
            line = f'mesh = "{mesh}"'
        elif region is not None and re.match(r"\s*poisson_ratio\s*=", line):
            line = f"poisson_ratio = {poisson_ratio!r}"
        elif region not in (None, first) and re.match(r"\s*young_modulus\s*=", line):
            line = f"young_modulus = {contrast * first_modulus!r} # Pa, {contrast:g} times {first}"
        lines.append(line)
    return "\n".join(lines) + "\n"


def main():
    source, contrast, poisson_ratio, target = sys.argv[1:]
    source, target = pathlib.Path(source), pathlib.Path(target)
    text = source.read_text()
    mesh = os.path.relpath(source.parent / tomllib.loads(text)["mesh"], target.parent)
    target.write_text(with_materials(text, float(contrast), float(poisson_ratio), mesh))


main()
