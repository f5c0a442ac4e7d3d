"""HDF5 files are read in a process of their own before the caller's process reads them."""
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import h5py
import livermark
import numpy
import pytest
from conftest import RUNS
from livermark import hdf5_trial

BENDING = RUNS / "beam" / "beam_bend.h5"
NO_LOCK = threading.RLock()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "result.h5"
    path.write_bytes(BENDING.read_bytes())
    return path


def children():
    listed = pathlib.Path(f"/proc/self/task/{threading.get_native_id()}/children").read_text()
    return set(listed.split())


def end_by(number):
    return lambda _: os.kill(os.getpid(), number)


def refuse(_):
    raise livermark.InputError("the sentence\nof the reader")


def take_memory(_):
    return [bytearray(1 << 28) for _ in range(100)]


@pytest.mark.parametrize("read, sentence", [
    (end_by(signal.SIGSEGV), "it cannot be read .a library has broken off with Segmentation fault"),
    (end_by(signal.SIGKILL), "it takes more time or memory"), (take_memory, "it takes more memory"),
    (refuse, "^the sentence\nof the reader$"), (lambda _: os._exit(0), "a library has broken off")])
def test_what_happens_to_the_reader_is_a_sentence_here(file, read, sentence):
    before = children()
    with pytest.raises(livermark.InputError, match=sentence):
        hdf5_trial.try_apart(str(file), read, NO_LOCK)
    assert children() == before


def test_a_reader_that_does_not_end_is_ended(file, monkeypatch):
    monkeypatch.setattr(hdf5_trial, "LEAST_SECONDS", 1)
    with pytest.raises(livermark.InputError, match="it takes more time or memory than there is for a file"):
        hdf5_trial.try_apart(str(file), lambda _: all(iter(lambda: True, False)), NO_LOCK)


def test_an_interrupt_ends_the_reader_too(file):
    before = children()
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.3, signal.pthread_kill, [threading.get_ident(), signal.SIGINT]).start()
        hdf5_trial.try_apart(str(file), lambda _: time.sleep(100), NO_LOCK)
    assert children() == before


def test_files_that_make_hdf5_crash_are_refused_in_this_process(tmp_path):
    """Damaged result files whose checksums were made right again."""
    writes = os.environ.get("LIVERMARK_TRY_READERS")
    if not writes:
        pytest.skip("try_readers is not built")
    read = refused = crashes = 0
    for number in range(24):
        place = subprocess.run([writes, "--write", "hdf5", str(number), tmp_path], check=True, capture_output=True, text=True)
        path = place.stdout.strip()
        try:
            with livermark.open(path) as result:
                result.errors()
            read += 1
        except livermark.InputError as error:
            assert path in str(error) and "\n" not in str(error), error
            refused += 1
            crashes += "a library has broken off with" in str(error)
    assert read > 0 and refused > 0 and read + refused == 24
    if h5py.version.hdf5_version == "1.10.8":
        assert crashes > 0


def test_a_file_is_tried_once_until_it_changes(file, monkeypatch):
    trials, answer_of = [], hdf5_trial._answer_of
    monkeypatch.setattr(hdf5_trial, "_answer_of", lambda *given: trials.append(given) or answer_of(*given))
    later = time.time() + 100.0
    monkeypatch.setattr(hdf5_trial.time, "time", lambda: later)
    for _ in range(3):
        livermark.open(file).close()
    assert len(trials) == 1
    file.write_bytes(file.read_bytes()[:-5000])
    with pytest.raises(livermark.InputError):
        livermark.open(file)
    assert len(trials) == 2


def test_a_file_that_was_written_a_moment_ago_is_not_remembered(file):
    livermark.open(file).close()
    assert hdf5_trial._state_of(str(file)) not in hdf5_trial._tried


def test_whoever_has_the_file_open_reads_on(file):
    """A fork shares open files, and the place in each."""
    with h5py.File(file) as mine:
        points = mine["mesh/points"][:]
        with livermark.open(file) as result:
            assert numpy.array_equal(result.points, points)
        assert numpy.array_equal(mine["solutions/lloyd/displacement"][:], mine["solutions/lloyd/displacement"][:])
        assert numpy.array_equal(mine["mesh/points"][:], points)


def open_twice(path):
    with livermark.open(path) as result:
        models = result.models
    damaged = path.with_name(f"{os.getpid()}.h5")
    damaged.write_bytes(path.read_bytes()[:-1000])
    with pytest.raises(livermark.InputError):
        livermark.open(damaged)
    return models


@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_files_are_read_in_processes_of_multiprocessing(file, method):
    with multiprocessing.get_context(method).Pool(2) as pool:
        assert pool.map(open_twice, [file] * 4) == [open_twice(file)] * 4


def test_files_are_read_in_threads(file):
    """While one of them is inside the library nearly all the time."""
    faults, is_done = [], threading.Event()

    def read_on():
        with h5py.File(file) as mine:
            while not is_done.is_set():
                mine["mesh/points"][:]

    def work(number):
        try:
            copy = file.with_name(f"{number}.h5")
            copy.write_bytes(file.read_bytes())
            for _ in range(10):
                with livermark.open(copy) as result:
                    assert len(result.points) == 1142
        except BaseException as error:
            faults.append(error)

    reader = threading.Thread(target=read_on)
    workers = [threading.Thread(target=work, args=(number,)) for number in range(3)]
    for thread in [reader, *workers]:
        thread.start()
    for thread in workers:
        thread.join()
    is_done.set()
    reader.join()
    assert not faults, faults


def test_a_program_that_takes_no_notice_of_its_children_reads_files(file):
    code = f"""import signal, livermark
signal.signal(signal.SIGCHLD, signal.SIG_IGN)
assert len(livermark.open({str(file)!r}).models) == 11
open("bad.h5", "wb").write(open({str(file)!r}, "rb").read()[:-5000])
try:
    livermark.open("bad.h5")
except livermark.InputError as error:
    print(error)
"""
    ended = subprocess.run([sys.executable, "-c", code], check=True, cwd=file.parent, capture_output=True, text=True, timeout=100)
    assert ended.stdout.startswith("bad.h5: ") and ended.stderr == ""
