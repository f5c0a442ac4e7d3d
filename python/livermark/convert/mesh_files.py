"""Reads mesh files of other programs, with meshio or by readers of this project, in a process of its own with limits of
time and memory."""
from __future__ import annotations

import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
from typing import Any, NamedTuple

import numpy

from livermark.convert import abaqus, avs, med, nastran, tetgen, vtk_files, vtk_grids
from livermark.convert.file_headers import check_counts
from livermark.convert.groups import TETRAHEDRA, groups_of, refuse_other_cells
from livermark.errors import InputError
from livermark.plain_files import limits_of, plain_file, put_limits
from livermark.volumes import tetrahedron_volumes

REFUSED = 2  #: exit status of the process that reads, with a sentence on standard error
FIRST_LINES = 1000  #: bytes, in which programs write what a file is
LONGEST_REASON = 200  #: of a sentence that somebody else's file may have a part in


class Tetrahedra(NamedTuple):
    points: numpy.ndarray  #: (N, 3) in the unit of the file
    corners: numpy.ndarray  #: (M, 4) node numbers, positive volumes
    region: numpy.ndarray  #: (M) number of the group
    names: dict[int, str]  #: of the groups
    remarks: list[str]  #: a sentence for all that is not used


def _of_vtk(path: str) -> Any:
    with open(path, "rb") as file:
        data = file.read()
    if not vtk_files.is_vtk(data):
        raise ValueError("it does not begin as a VTK file does")
    return vtk_grids.mesh_of(vtk_files.read_dataset(data))


def _of_meshio(path: str, ending: str) -> Any:
    """What meshio reads, compared with what the file says of itself."""
    import meshio
    if ending not in meshio.extension_to_filetypes:
        raise InputError(f"no mesh can be read from it as {ending[1:20].upper()}, which is no format that is known here"
                         if ending else "its name has no ending that says its format")
    mesh = meshio.read(path)
    with open(path, "rb") as file:
        mesh.remarks = check_counts(mesh, ending, file.read())
    return mesh


def _of_inp(path: str) -> Any:
    """Abaqus, or AVS-UCD."""
    return avs.read(path) if avs.is_avs(path) else abaqus.read(path)


def _space_of(mesh: Any, path: str) -> str:
    """Axes that the first lines of a file say, or field data of VTK."""
    with open(path, "rb") as file:
        found = re.search(rb"SPACE=([A-Z]+)", file.read(FIRST_LINES))
    return getattr(mesh, "space", "") or (found[1].decode() if found else "")


def _turn_to_lps(mesh: Any) -> None:
    mesh.points = mesh.points * [-1.0, -1.0, 1.0]
    for name, values in mesh.point_data.items():
        if values.shape == mesh.points.shape and values.dtype.kind == "f":
            mesh.point_data[name] = values * [-1.0, -1.0, 1.0]
    mesh.remarks.append("it says that it is in RAS, and is turned to LPS")


def read(source: Any, to_lps: bool = True) -> Any:
    """What has the attributes of a meshio.Mesh, `remarks`, and `space`, the axes that the file says ("RAS", "LPS" or "").

    to_lps: whether points of a file that says RAS are turned. Raises InputError with a sentence of ours, without the words that
    meshio has for its own readers."""
    path = os.fspath(source)
    ending = pathlib.Path(path).suffix.lower()
    try:
        if ending in NOT_READ:
            raise InputError(f"{ending[1:].upper()} is not read; {NOT_READ[ending]}")
        mesh = OWN[ending](path) if ending in OWN else _of_meshio(path, ending)
        mesh.remarks = getattr(mesh, "remarks", [])
        mesh.space = _space_of(mesh, path)
        if to_lps and mesh.space == "RAS":
            _turn_to_lps(mesh)
        return mesh
    except MemoryError:
        raise InputError("it takes more memory than there is for a file") from None
    except InputError:
        raise
    except ModuleNotFoundError as error:
        raise InputError(f"it needs the Python module {error.name}, which is not installed") from None
    except (Exception, SystemExit):
        raise InputError(f"no mesh can be read from it as {ending[1:].upper()}, so it is damaged or of another format") from None


OWN = {".inp": _of_inp, ".avs": avs.read, ".ucd": avs.read, ".ele": tetgen.read, ".node": tetgen.read, ".vtk": _of_vtk,
       ".vtu": _of_vtk, ".vtp": _of_vtk, ".med": med.read, ".rmed": med.read, ".bdf": nastran.read, ".nas": nastran.read,
       ".fem": nastran.read}
#: Formats that mesh generators write, and the program that converts each.
NOT_READ = {".unv": "gmsh converts it: gmsh FILE.unv -save -format msh22 -o FILE.msh",
            ".pvtu": "it only names other files; open it in ParaView and save one VTU",
            ".vtm": "it only names other files; open it in ParaView, merge the blocks and save one VTU",
            ".vtkhdf": "open it in ParaView and save it as VTU",
            ".key": "save it as Abaqus INP or Nastran BDF", ".k": "save it as Abaqus INP or Nastran BDF",
            ".cdb": "save it as Abaqus INP or Nastran BDF"}


def checked_points(points: Any, corners: numpy.ndarray) -> numpy.ndarray:
    """The points as numbers. Raises InputError if they have no three coordinates, or if a tetrahedron has not four of them.
    """
    if corners.ndim != 2 or corners.shape[1] != 4:
        raise InputError("its tetrahedra have no four corners")
    numbers = numpy.asarray(points, dtype=float)
    if numbers.ndim != 2 or numbers.shape[1] != 3:
        raise InputError("its points have no three coordinates")
    if corners.dtype.kind not in "iu":
        raise InputError("the node numbers of its tetrahedra are no integers")
    if corners.min() < 0 or corners.max() >= len(numbers):
        raise InputError("a tetrahedron names a node that is not there")
    if not numpy.isfinite(numbers[numpy.unique(corners)]).all():
        raise InputError("a coordinate is not finite")
    return numbers


def are_inverted(points: numpy.ndarray, corners: numpy.ndarray) -> numpy.ndarray:
    """(M) whether the volume is negative."""
    return tetrahedron_volumes(points, corners) < 0.0


def tetrahedra_of(mesh: Any) -> Tetrahedra:
    """The tetrahedra of a meshio.Mesh: without middles of edges and nodes that none uses, and none inverted. Raises
    InputError with a sentence in which the mesh is not named."""
    try:
        remarks = refuse_other_cells(mesh) + getattr(mesh, "remarks", [])
        blocks = [numpy.asarray(block.data)[:, :4] for block in mesh.cells if block.type in TETRAHEDRA]
        if sum(map(len, blocks)) == 0:
            raise InputError("there are no tetrahedra; mesh the volume, not only the surface")
        joined = numpy.concatenate(blocks)
        all_points = checked_points(mesh.points, joined)
        region, names, of_groups = groups_of(mesh, TETRAHEDRA, 3)
        if region.shape != (len(joined),):
            raise InputError("its groups are of another number of tetrahedra than it has")
    except InputError:
        raise
    except MemoryError:
        raise InputError("it takes more memory than there is") from None
    except Exception as error:  # whatever is wrong inside
        raise InputError(f"its points, cells and groups do not go together ({_one_line(error)}); make them again") from error
    used, corners = numpy.unique(joined, return_inverse=True)
    corners, points = corners.reshape(-1, 4), all_points[used]
    inverted = are_inverted(points, corners)
    corners[inverted] = corners[inverted][:, [0, 1, 3, 2]]
    return Tetrahedra(points, corners, region, {number: name for number, name in names.items() if number in region},
                      remarks + of_groups)


def _one_line(error: Any) -> str:
    words = str(error).strip() or type(error).__name__
    return words.splitlines()[-1][:LONGEST_REASON]


def _refuse(path: str, why: str) -> None:
    """In the words of the program."""
    raise InputError(f"{path}: it cannot be read ({why}), so it is damaged or not what its name says; export it again")


def read_apart(path: Any) -> Tetrahedra:
    """The tetrahedra of a file, which another process reads: a file that makes a reader crash, hang or fill the memory
    ends that process alone. Raises FileNotFoundError if there is none, and InputError."""
    name = plain_file(path, "give a mesh")
    if not sys.executable:
        raise RuntimeError("this program has Python in it, but no interpreter that could read a file in a process of its own; "
                           "give the mesh that meshio.read() returns")
    seconds, num_bytes = limits_of(name)
    # The modules that this process finds, and none of the working directory.
    folders = [str(pathlib.Path(__file__).resolve().parents[2])] + [folder for folder in sys.path if os.path.isabs(folder)]
    program = ("import sys; sys.path[:] = sys.argv[3:]; from livermark.convert.mesh_files import main; "
               "sys.exit(main(*sys.argv[1:3]))")
    with tempfile.TemporaryDirectory(prefix="livermark-") as scratch:
        target = os.path.join(scratch, "mesh.npz")
        try:
            ended = subprocess.run([sys.executable, "-c", program, name, target, *folders], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, errors="replace",
                                   timeout=30 + 3 * seconds)
        except subprocess.TimeoutExpired:
            _refuse(name, f"it takes more than {30 + 3 * seconds} s")
        if ended.returncode == REFUSED:
            raise InputError(f"{name}: {_one_line(ended.stderr)}")
        if ended.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
            _refuse(name, f"it takes more than {seconds} s or {num_bytes >> 20} MB")
        if ended.returncode < 0:
            _refuse(name, f"a library has broken off with {signal.strsignal(-ended.returncode)}")
        if ended.returncode > 0:
            raise RuntimeError(f"{name}: the process that reads it has failed: {_one_line(ended.stderr)}")
        with numpy.load(target, allow_pickle=False) as found:
            words = json.loads(str(found["words"]))
            return Tetrahedra(found["points"], found["corners"], found["region"],
                              {number: text for number, text in words["names"]}, words["remarks"])


def main(path: str, target: str) -> int:
    """What the other process does."""
    put_limits(path)
    try:
        found = tetrahedra_of(read(path))
        words = {"names": list(found.names.items()), "remarks": found.remarks}
        numpy.savez(target, points=found.points, corners=found.corners, region=found.region, words=json.dumps(words))
    except InputError as error:
        print(error, file=sys.stderr)
        return REFUSED
    except MemoryError:
        print("it takes more memory than there is for a file", file=sys.stderr)
        return REFUSED
    return 0
