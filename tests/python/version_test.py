"""There is one version, which everything says."""
import json
import os
import pathlib
import re
import subprocess

import livermark
from conftest import BINARY

SOURCE = pathlib.Path(os.environ["LIVERMARK_SOURCE_DIR"])


def test_every_file_and_program_has_the_version_of_the_package(bending):
    assert re.fullmatch(r"\d+\.\d+\.\d+", livermark.__version__)
    said = subprocess.run([BINARY, "--version"], check=True, capture_output=True, text=True).stdout
    citation = re.search(r"^version: (\S+)$", (SOURCE / "CITATION.cff").read_text(), re.MULTILINE)
    lock = json.loads((SOURCE / "app/viewer/package-lock.json").read_text())
    found = {"livermark --version": re.search(r"\d+\.\d+\.\d+", said).group(), "CITATION.cff": citation.group(1),
             "app/viewer/package.json": json.loads((SOURCE / "app/viewer/package.json").read_text())["version"],
             "app/viewer/package-lock.json": lock["version"], "its package": lock["packages"][""]["version"],
             "result files": bending.file.attrs["software_version"].decode(),
             "CHANGELOG.md": re.search(r"^## (\d+\.\d+\.\d+)", (SOURCE / "CHANGELOG.md").read_text(), re.MULTILINE).group(1)}
    assert set(found.values()) == {livermark.__version__}, found
