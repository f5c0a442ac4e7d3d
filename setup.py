"""Compiles the extension of the Python package with CMake, for pip; pyproject.toml has the rest.

CMAKE_ARGS are arguments for CMake, such as -DCMAKE_CXX_FLAGS=-march=native.
"""
import os
import pathlib
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext
from setuptools.errors import SetupError

SOURCE = pathlib.Path(__file__).resolve().parent
BUILD = SOURCE / "build" / f"pip-{sys.implementation.cache_tag}"  # as far from the sources as other presets: see ccache
PACKAGES = ("g++ cmake ninja-build libeigen3-dev libfmt-dev libhwy-dev libspectra-dev libboost-dev pybind11-dev python3-dev")


class BuildWithCMake(build_ext):
    def build_extension(self, extension: Extension) -> None:
        if shutil.which("cmake") is None:
            raise SetupError(f"there is no CMake; on Debian, apt-get install {PACKAGES}")
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        configure = ["cmake", "-S", str(SOURCE), "-B", str(BUILD), *generator, "-DCMAKE_BUILD_TYPE=Release",
                     "-DLIVERMARK_WITH_FEM_REFERENCE=OFF", f"-DPython_EXECUTABLE={sys.executable}",
                     *shlex.split(os.environ.get("CMAKE_ARGS", ""))]
        for command in (configure, ["cmake", "--build", str(BUILD), "--target", "livermark_python", "--parallel"]):
            if subprocess.run(command).returncode != 0:
                raise SetupError(f"CMake has failed, see above; it needs what these Debian packages have: {PACKAGES}")
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        built = BUILD / "python" / "livermark" / target.name
        if not built.exists():
            raise SetupError("the extension was not built, because pybind11 or the headers of Python are missing; on Debian, "
                             "apt-get install pybind11-dev python3-dev")
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(built, target)


BUILD.mkdir(parents=True, exist_ok=True)
setup(ext_modules=[Extension("livermark._livermark", sources=[])], cmdclass={"build_ext": BuildWithCMake},
      options={"build": {"build_base": str(BUILD / "setuptools")}, "egg_info": {"egg_base": str(BUILD)}})
