"""Writes what other programs read beside a scene: python3 -m livermark.convert.scene_files LOAD_CASE.scene.h5

That is LOAD_CASE.feb for FEBio and LOAD_CASE.sofa.py for SOFA, whose paths it prints. `livermark export` calls it.
"""
import sys

from livermark.convert.tool_scene import read_tool_scene, tool_scene_to_febio, tool_scene_to_sofa
from livermark.errors import InputError

SUFFIX = ".scene.h5"


def main(arguments: list) -> int:
    try:
        if len(arguments) != 1 or not arguments[0].endswith(SUFFIX):
            raise InputError(f"give one file that ends in {SUFFIX}, of 'livermark export' of a load case with a moving tool")
        scene, stem = read_tool_scene(arguments[0]), arguments[0][:-len(SUFFIX)]
        for write, path in ((tool_scene_to_febio, stem + ".feb"), (tool_scene_to_sofa, stem + ".sofa.py")):
            write(scene, path)
            print(path)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
