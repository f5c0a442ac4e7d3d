"""Files that somebody else has made: what is asked before one is opened, and what reading it may take."""
from __future__ import annotations

import contextlib
import os
import pathlib
import resource
import stat
from typing import Any, Iterator

from livermark.errors import InputError

LEAST_SECONDS, MOST_SECONDS, SECONDS_PER_BYTE = 20, 600, 1e-5
LEAST_BYTES, MOST_BYTES, BYTES_PER_BYTE = 1 << 30, 16 << 30, 500  # beside what Python has


def plain_file(path: Any, remedy: str) -> str:
    """The path as text. Raises FileNotFoundError if there is nothing, and InputError for a folder, a device or a named pipe,
    which would be waited for."""
    name = os.fspath(path)
    if not os.path.exists(name):
        raise FileNotFoundError(f"{name}: there is no such file")
    if not stat.S_ISREG(os.stat(name).st_mode):
        raise InputError(f"{name}: this is not a plain file; {remedy}")
    return name


@contextlib.contextmanager
def whole_file(path: pathlib.Path) -> Iterator[pathlib.Path]:
    """A file beside the path, to be written, which takes the place of an earlier one when it is whole. Errors stay OSError."""
    part = path.with_name(f"{path.name}.{os.getpid()}.partial")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def limits_of(path: str, least_seconds: int = LEAST_SECONDS) -> tuple[int, int]:
    """Seconds of computing, and bytes of memory beside what Python has, in proportion to a file."""
    size = os.path.getsize(path) if os.path.isfile(path) else 0
    return (int(min(least_seconds + SECONDS_PER_BYTE * size, MOST_SECONDS)),
            int(min(LEAST_BYTES + BYTES_PER_BYTE * size, MOST_BYTES)))


def put_limits(path: str, least_seconds: int = LEAST_SECONDS) -> None:
    """Limits for this process in proportion to a file; smaller ones that it has already stay."""
    seconds, num_bytes = limits_of(path, least_seconds)
    with open("/proc/self/statm") as pages:
        present = int(pages.read().split()[0]) * resource.getpagesize()
    for kind, most in ((resource.RLIMIT_CPU, seconds), (resource.RLIMIT_AS, present + num_bytes)):
        _, hard = resource.getrlimit(kind)
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (least, hard))
