"""`pip install .` makes a package that works, and is of the version that the source tree says.

usage: pip_test.py SOURCE WORK        exit status 77 where pip or setuptools are missing
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys

PROGRAM = """import livermark, numpy
springs = livermark.Springs(numpy.eye(3), [[0, 1], [1, 2]], 10.0, 1.0)
simulation = livermark.Simulation(springs, 0.8 * livermark.critical_time_step(springs), forces=numpy.eye(3))
simulation.step(10)
print(livermark.__version__, livermark.__file__, simulation.positions.tolist() == springs.points.tolist())
"""
REPORT = "import livermark.report.page, livermark.report.sections; print(livermark.report.page.__file__)"


def main(source: pathlib.Path, work: pathlib.Path) -> int:
    for module in ("pip", "setuptools", "wheel", "numpy"):
        if subprocess.run([sys.executable, "-c", f"import {module}"], capture_output=True).returncode != 0:
            print(f"skipped: {sys.executable} has no {module}; install python3-{module}")
            return 77
    shutil.rmtree(work, ignore_errors=True)
    # What another build of these lines has compiled, ccache finds.
    environment = {**os.environ, "CMAKE_ARGS": "-DLIVERMARK_WARNINGS_AS_ERRORS=ON", "CCACHE_BASEDIR": str(source),
                   "CCACHE_NOHASHDIR": "1"}
    installed = subprocess.run([sys.executable, "-m", "pip", "install", "--no-build-isolation", "--no-deps", "--no-index",
                                "--disable-pip-version-check", "--target", work / "installed", source],
                               env=environment, capture_output=True, text=True)
    assert installed.returncode == 0, installed.stdout + installed.stderr
    alone = {**os.environ, "PYTHONPATH": str(work / "installed")}
    (work / "elsewhere").mkdir()

    def said_by(program: str) -> list:
        ended = subprocess.run([sys.executable, "-c", program], cwd=work / "elsewhere", env=alone, capture_output=True, text=True)
        assert ended.returncode == 0, ended.stderr
        return ended.stdout.split()

    version = re.search(r'__version__ = "(.*)"', (source / "python/livermark/_version.py").read_text()).group(1)
    package = work / "installed" / "livermark"
    assert said_by(PROGRAM) == [version, str(package / "__init__.py"), "False"]
    assert f"Successfully installed livermark-{version}" in installed.stdout, installed.stdout
    assert subprocess.run([sys.executable, "-c", "import jinja2, matplotlib"], capture_output=True).returncode != 0 \
        or said_by(REPORT) == [str(package / "report" / "page.py")]
    # Every file of the package is there, and nothing else; _suite is another package's.
    ours = {path.relative_to(source / "python/livermark") for path in (source / "python/livermark").rglob("*")
            if path.is_file() and path.suffix != ".pyc"}
    theirs = {path.relative_to(package) for path in package.rglob("*") if path.is_file() and path.suffix != ".pyc"}
    assert ours == {path for path in theirs if path.suffix != ".so"}, ours ^ theirs
    assert [path.name.split(".")[0] for path in theirs if path.suffix == ".so"] == ["_livermark"], theirs
    assert not list(source.glob("python/*.egg-info")), "pip has left something beside the sources"
    shutil.rmtree(work)
    return 0


if __name__ == "__main__":
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()))
