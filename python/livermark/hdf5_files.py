"""HDF5 files: those that somebody else may have made, in which nothing leads out of the file, and new ones as the program
writes them. Needs h5py alone."""
from __future__ import annotations

import contextlib
import functools
import pathlib
from typing import Any, Iterator, Optional

import numpy

from livermark.errors import InputError
from livermark.hdf5_trial import read_all, try_apart
from livermark.plain_files import limits_of, plain_file, whole_file

RUN = "livermark run"  # the command that writes most files
SCHEMA_VERSION = 1
SMALLEST_CHUNKED, CHUNK = 16 * 1024, 1024 * 1024  # [byte], as results/hdf5/hdf5_output.cpp has them
FAULTS = (KeyError, OSError, RuntimeError, ValueError, TypeError, IndexError, AttributeError)  # of h5py on what is damaged


def library() -> Any:
    """h5py. Raises ImportError if it is missing."""
    try:
        import h5py
    except ImportError as error:
        raise ImportError("this needs h5py; install python3-h5py") from error
    return h5py


def _fault(file: Any, most_bytes: int) -> Optional[str]:
    """The first place whose content is somewhere else: a link, or a dataset kept in another file. None is opened. Or the
    first dataset that takes more memory than a file of this size can hold."""
    h5py = library()
    datasets: list[str] = []

    def look_at_link(name: bytes, info: Any) -> Optional[bytes]:
        return name if info.type != h5py.h5l.TYPE_HARD else None  # what is not None ends the visit

    def look_at_object(name: bytes, info: Any) -> None:
        if info.type == h5py.h5o.TYPE_DATASET:
            datasets.append(name)

    linked = file.id.links.visit(look_at_link, info=True)
    if linked is not None:
        return f"/{linked.decode(errors='replace')} is a link to another place, and links are not followed"
    h5py.h5o.visit(file.id, look_at_object, info=True)
    for name in datasets:
        dataset = h5py.h5d.open(file.id, name)
        properties = dataset.get_create_plist()
        if properties.get_layout() == h5py.h5d.VIRTUAL or properties.get_external_count() > 0:
            return f"/{name.decode(errors='replace')} is kept in another file"
        size = dataset.get_space().get_simple_extent_npoints() * dataset.get_type().get_size()
        if size > most_bytes:
            return f"/{name.decode(errors='replace')} is said to have {size >> 20} MB, which is not in the file"
    return None


def damaged(name: str, error: BaseException, maker: str = RUN) -> InputError:
    """What to raise for a part of a file that is not there or cannot be read."""
    words = (str(error.args[0] if error.args else "") or type(error).__name__).splitlines()[0]
    return InputError(f"{name}: it cannot be read ({words[:200]}), so it is damaged or of another version; make it again with "
                      f"`{maker}`")


def _in_our_words(function: Any) -> Any:
    @functools.wraps(function)
    def with_our_words(self: Any, *arguments: Any, **named: Any) -> Any:
        try:
            return function(self, *arguments, **named)
        except InputError:
            raise
        except MemoryError:
            raise InputError(f"{self.path}: it takes more memory than there is") from None
        except FAULTS as error:
            if not self.is_open:
                raise InputError(f"{self.path}: the file is closed; open it again") from error
            raise damaged(self.path, error) from error
    return with_our_words


def says_what_is_damaged(kind: Any) -> Any:
    """A class with path and is_open, whose properties and methods raise InputError where h5py raises something of its own."""
    for name, member in list(vars(kind).items()):
        if isinstance(member, property) and name != "is_open":
            setattr(kind, name, property(_in_our_words(member.fget), doc=member.__doc__))
        elif callable(member) and (not name.startswith("_") or name in ("__getitem__", "__repr__", "_check")):
            setattr(kind, name, _in_our_words(member))
    return kind


def _refusal(name: str, error: OSError, maker: str) -> InputError:
    """Of a file that HDF5 cannot open."""
    if getattr(error, "errno", None) in (11, 13) or "unable to lock file" in str(error):
        return InputError(f"{name}: cannot be read ({error}); check its permissions, and whether a program has it open to write")
    return InputError(f"{name}: this is no HDF5 file, or it is damaged; make it again with `{maker}`")


def _read_whole(name: str, maker: str) -> None:
    """What is tried in a process of its own. There the file has another driver: HDF5 would share an open file with the
    process that it was forked from, and with it the place in the file."""
    h5py = library()
    try:
        file = h5py.File(name, "r", driver="stdio")
    except OSError as error:
        raise _refusal(name, error, maker) from error
    try:
        fault = _fault(file, limits_of(name)[1])
    except FAULTS as error:
        raise damaged(name, error, maker) from error
    if fault is not None:
        raise InputError(f"{name}: {fault}; copy what is there into the file, or make it again with `{maker}`")
    read_all(file, FAULTS)


def open_hdf5(path: Any, maker: str = RUN) -> Any:
    """An h5py.File to read, after a process of its own has read all of it. maker: the command that writes such files.

    Raises FileNotFoundError if there is none, and InputError for what is no HDF5 file, has a part in another file, has
    more in it than fits, or makes HDF5 crash: it would open whatever file is named there, and wait where that is a named pipe.
    """
    h5py = library()
    name = plain_file(path, f"give a file that `{maker}` wrote")
    try_apart(name, functools.partial(_read_whole, maker=maker), getattr(h5py._objects, "phil", None) or contextlib.nullcontext())
    try:
        return h5py.File(name, "r")
    except OSError as error:
        raise _refusal(name, error, maker) from error


def put_attribute(place: Any, name: str, value: Any) -> None:
    """A text, a list of texts, a whole number or a number as an attribute of a group or dataset."""
    if isinstance(value, (str, list)):
        encoded = [text.encode("utf-8", errors="replace") for text in ([value] if isinstance(value, str) else value)]
        kind = library().string_dtype("utf-8", max([1, *map(len, encoded)]))
        place.attrs[name] = numpy.array(encoded if isinstance(value, list) else encoded[0], dtype=kind)
    else:
        place.attrs[name] = numpy.int64(value) if isinstance(value, int) else numpy.float64(value)


def put_dataset(place: Any, name: str, values: Any, units: str = "") -> None:
    """Arrays that are not small are in chunks with checksums, integers compressed; truths are bytes."""
    values = numpy.asarray(values)
    values = values.astype(numpy.uint8) if values.dtype == bool else values
    filters: dict[str, Any] = {}
    if values.nbytes >= SMALLEST_CHUNKED:
        num_chunks = min(-(-values.nbytes // CHUNK), len(values))
        filters = {"chunks": (-(-len(values) // num_chunks), *values.shape[1:])}
        filters |= {"fletcher32": True} if values.dtype.kind == "f" else {
            "shuffle": True, "compression": "gzip", "compression_opts": 1}
    dataset = place.create_dataset(name, data=values, **filters)
    if units:
        put_attribute(dataset, "units", units)


@contextlib.contextmanager
def new_hdf5(path: pathlib.Path, provenance: dict[str, Any]) -> Iterator[Any]:
    """An h5py.File to fill, which takes the place of an earlier one when it is whole. provenance: attributes of the root that
    say where it comes from. Raises InputError if it cannot be written."""
    try:
        with whole_file(path) as part, library().File(part, "w", libver=("v110", "v110")) as file:
            for name, value in {"schema_version": SCHEMA_VERSION, **provenance}.items():
                put_attribute(file, name, value)
            yield file
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error}); choose another place") from error


def read_attribute(place: Any, name: str) -> Any:
    """What put_attribute() wrote."""
    value = place.attrs[name]
    if getattr(value, "ndim", 0) == 1:
        return [text.decode(errors="replace") if isinstance(text, bytes) else str(text) for text in value]
    if isinstance(value, (bytes, str)):
        return value.decode(errors="replace") if isinstance(value, bytes) else value
    return value.item()
