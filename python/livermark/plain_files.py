"""What is asked of every file before it is opened."""
from __future__ import annotations

import os
import stat
from typing import Any

from livermark.errors import InputError


def plain_file(path: Any, remedy: str) -> str:
    """The path as text. Raises FileNotFoundError if there is nothing, and InputError for a folder, a device or a named pipe,
    which would be waited for."""
    name = os.fspath(path)
    if not os.path.exists(name):
        raise FileNotFoundError(f"{name}: there is no such file")
    if not stat.S_ISREG(os.stat(name).st_mode):
        raise InputError(f"{name}: this is not a plain file; {remedy}")
    return name
