"""Reads all of an HDF5 file in a process of its own first, because HDF5 crashes on files whose checksums are right and whose
contents are not, and does so again in the same place. After that a file may be read here. Needs h5py alone.

The process is a fork: it has h5py already, so a trial takes milliseconds and not the start of an interpreter.
"""
from __future__ import annotations

import contextlib
import gc
import os
import resource
import signal
import time
import warnings
from typing import Any, Callable, Optional

from livermark.errors import InputError
from livermark.plain_files import put_limits

LEAST_SECONDS = 5  #: of computing, for a file of any size
LONGEST_ANSWER = 2000  #: bytes of a sentence, less than a pipe takes without a reader
PIECE = 1 << 26  #: bytes of a dataset that are read at once
READ, REFUSED, TOO_LARGE = b"r", b"f", b"m"
ENDS = (signal.SIGXCPU, signal.SIGALRM, signal.SIGKILL)  #: at a limit
HANDLED = ("SIGSEGV", "SIGABRT", "SIGFPE", "SIGBUS", "SIGILL", "SIGXCPU", "SIGALRM", "SIGINT", "SIGTERM", "SIGCHLD")

_tried: dict[tuple, None] = {}  #: files that were read to their end, the latest ones


def _state_of(name: str) -> tuple:
    found = os.stat(name)
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns


def _remember(state: tuple) -> None:
    """Not of a file that was written a moment ago: clocks of file systems go in steps."""
    if time.time() - max(state[-2:]) * 1e-9 > 2.0:
        if len(_tried) >= 1000:
            del _tried[next(iter(_tried))]
        _tried[state] = None


def _read_values(dataset: Any) -> None:
    if not dataset.shape:  # one value, or none
        dataset[()]
        return
    row = dataset.dtype.itemsize
    for extent in dataset.shape[1:]:
        row *= extent
    chunk = dataset.chunks[0] if dataset.chunks else 1
    step = max(1, PIECE // max(row, 1) // chunk) * chunk
    for first in range(0, dataset.shape[0], step):
        dataset[first:first + step]


def read_all(file: Any, faults: tuple) -> None:
    """Every attribute and every dataset of an h5py.File. What cannot be read is passed over: whoever asks for it is told."""
    def read(_: str, part: Any) -> None:
        for name in list(part.attrs):
            with contextlib.suppress(*faults):
                part.attrs[name]
        if hasattr(part, "chunks"):  # a dataset
            with contextlib.suppress(*faults):
                _read_values(part)
    with contextlib.suppress(*faults):
        read("/", file)
        file.visititems(read)


def _put_limits(name: str) -> None:
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    put_limits(name, LEAST_SECONDS)
    signal.alarm(30 + 3 * resource.getrlimit(resource.RLIMIT_CPU)[0])
    for word in HANDLED:
        signal.signal(getattr(signal, word), signal.SIG_DFL)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)


def _try_and_exit(name: str, read: Callable[[str], None], answers: int) -> None:
    """All that the other process does. Nothing of this one is given back there, and nothing of it ends."""
    answer = REFUSED
    try:
        gc.disable()
        _put_limits(name)
        read(name)
        answer = READ
    except MemoryError:
        answer = TOO_LARGE
    except InputError as error:
        answer += str(error).encode(errors="replace")[:LONGEST_ANSWER]
    except BaseException as error:
        answer += f"{name}: it cannot be read ({type(error).__name__})".encode(errors="replace")
    finally:
        os.write(answers, answer)
        os._exit(0)


def _ended(child: int) -> Optional[int]:
    """Waits for the process. Its status; None if somebody else has asked for that."""
    try:
        return os.waitpid(child, 0)[1]
    except ChildProcessError:
        return None


def _answer_of(name: str, read: Callable[[str], None], lock: Any) -> tuple[bytes, Optional[int]]:
    """What the process has said, and its status."""
    answers, writes = os.pipe()
    child = 0
    try:
        with lock, warnings.catch_warnings():  # no other thread is inside the library
            warnings.simplefilter("ignore", DeprecationWarning)  # of forks beside threads: no thread is needed there
            child = os.fork()
            if child == 0:
                _try_and_exit(name, read, writes)
        status = _ended(child)
        os.set_blocking(answers, False)
        try:
            return os.read(answers, LONGEST_ANSWER + 1), status
        except BlockingIOError:
            return b"", status
    except BaseException:  # an interrupt, say
        if child > 0:
            with contextlib.suppress(ProcessLookupError):
                os.kill(child, signal.SIGKILL)
            _ended(child)
        raise
    finally:
        os.close(answers)
        os.close(writes)


def try_apart(name: str, read: Callable[[str], None], lock: Any) -> None:
    """Lets a function read a file in a process with limits of time and memory, once for what is in the file.

    read: may raise InputError. lock: of the library that reads. Raises InputError with its sentence, or with one that says how
    the process ended.
    """
    state = _state_of(name)
    if state in _tried:
        return
    answer, status = _answer_of(name, read, lock)
    if answer == READ:
        return _remember(state)
    if answer.startswith(REFUSED):
        raise InputError(answer[len(REFUSED):].decode(errors="replace"))
    why = "a library has broken off"
    if answer == TOO_LARGE:
        why = "it takes more memory than there is for a file"
    elif status is not None and os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        why = ("it takes more time or memory than there is for a file" if number in ENDS
               else f"a library has broken off with {signal.strsignal(number)}")
    raise InputError(f"{name}: it cannot be read ({why}), so it is damaged or not what its name says; make it again")
