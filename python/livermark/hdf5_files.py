"""Opens HDF5 files that somebody else may have made, in which nothing leads out of the file. Needs h5py alone."""
from __future__ import annotations

import os
import stat
from typing import Any, Optional

from livermark.errors import InputError


def _library() -> Any:
    try:
        import h5py
    except ImportError as error:
        raise ImportError("this needs h5py; install python3-h5py") from error
    return h5py


def _way_out(file: Any) -> Optional[str]:
    """The first place whose content is somewhere else: a link, or a dataset kept in another file. None is opened."""
    h5py = _library()
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
        properties = h5py.h5d.open(file.id, name).get_create_plist()
        if properties.get_layout() == h5py.h5d.VIRTUAL or properties.get_external_count() > 0:
            return f"/{name.decode(errors='replace')} is kept in another file"
    return None


def open_hdf5(path: Any) -> Any:
    """An h5py.File to read.

    Raises FileNotFoundError if there is none, and InputError for what is no HDF5 file or has a part in another file: HDF5
    would open whatever file is named there, and wait where that is a named pipe.
    """
    h5py = _library()
    name = os.fspath(path)
    if not os.path.exists(name):
        raise FileNotFoundError(f"{name}: there is no such file")
    if not stat.S_ISREG(os.stat(name).st_mode):
        raise InputError(f"{name}: this is no plain file; give a file that `livermark run` wrote")
    try:
        file = h5py.File(name, "r")
    except OSError as error:
        if getattr(error, "errno", None) in (11, 13) or "unable to lock file" in str(error):
            raise InputError(f"{name}: cannot be read ({error}); see who may read it, and whether a program has it open to "
                             "write") from error
        raise InputError(f"{name}: this is no HDF5 file, or it is damaged; make it again with `livermark run`") from error
    fault = _way_out(file)
    if fault is not None:
        file.close()
        raise InputError(f"{name}: {fault}; copy what is there into the file, or make it again with `livermark run`")
    return file
