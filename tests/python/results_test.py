"""Result files as numpy arrays, tables and grids, without any compiled module."""
import os
import pathlib
import shutil
import subprocess
import sys

import h5py
import livermark
import numpy
import pytest
from conftest import RUNS

SOURCE = pathlib.Path(__file__).resolve().parents[2]
SAMPLES = pathlib.Path(os.environ["LIVERMARK_SAMPLES"])
BENDING = RUNS / "beam" / "beam_bend.h5"
RELEASE = RUNS / "beam" / "beam_release.h5"


def test_arrays_are_those_of_the_file():
    with livermark.open(BENDING) as result, h5py.File(BENDING) as file:
        assert (result.body, result.load_case) == ("beam", "beam_bend")
        assert result.constraint_names == ["x_min"] and result.region_names == ["solid"]
        for name in ("points", "tetrahedra", "region"):
            assert numpy.array_equal(getattr(result, name), file["mesh"][name][:]), name
        lloyd, theirs = result["lloyd"], file["solutions/lloyd"]
        assert numpy.array_equal(result.boundary_triangles, file["mesh/boundary_triangles"][:])
        assert result.materials.keys() == {"density", "young_modulus", "poisson_ratio"}
        assert result.load_case_attributes["title"] == file["load_case"].attrs["title"].decode()
        assert not result.has_motion and result.path_of_loads is None and result.assumptions == []
        assert lloyd.status == "ok" and lloyd.moves_in_steps
        assert numpy.array_equal(lloyd.displacement, theirs["displacement"][:])
        assert numpy.array_equal(lloyd.reaction, theirs["reaction"][:])
        assert numpy.array_equal(lloyd.error, file["comparisons/lloyd/error"][:])
        assert lloyd.springs.keys() == {"edges", "stiffness", "rest_length", "node_mass"}
        assert result["fem_p1"].springs is None and not result["fem_p1"].moves_in_steps
        assert result["fem_p2p1"].error is None and result["fem_p2p1"].comparison is None
        assert lloyd.frames is None and result.reference is None
        assert result.compared_with == "fem_p2p1" and result.reference_on_mesh


def test_models_are_in_the_order_in_which_they_were_run():
    listed = [line.split()[0] for line in
              subprocess.run([os.environ["LIVERMARK_BINARY"], "list", "models"], check=True, capture_output=True,
                             text=True).stdout.splitlines()]
    with livermark.open(BENDING) as result:
        assert result.models == [name for name in listed if name in result.models]
        assert len(result.models) == 11


def test_errors_are_a_table_with_a_row_for_each_model():
    with livermark.open(BENDING) as result:
        errors = result.errors()
        assert list(errors.index) == result.models
        for model in result.models:
            comparison = result[model].comparison
            if comparison is None:
                assert numpy.isnan(errors.loc[model, "relative_l2"])
            else:
                assert errors.loc[model, "relative_l2"] == comparison["relative_l2"]
                assert errors.loc[model, "reference"] == "fem_p2p1"
        # what is in the table is what the fields say
        weighted = result["lloyd"].error
        assert errors.loc["lloyd", "max_error"] == pytest.approx(numpy.linalg.norm(weighted, axis=1).max(), rel=1e-12)


def test_history_is_a_table_over_time():
    with livermark.open(RELEASE) as result, h5py.File(RELEASE) as file:
        table = result["lloyd"].history()
        theirs = file["solutions/lloyd/history"]
        assert list(table.columns) == ["end x", "end y", "end z", "kinetic_energy", "strain_energy"]
        assert numpy.array_equal(table.index, theirs["time"][:])
        assert numpy.array_equal(table[["end x", "end y", "end z"]].to_numpy(), theirs["displacement"][:, 0])
        frames = result["lloyd"].frames
        assert frames.shape == (11, len(result.points), 3) and frames.dtype == numpy.float32
        probe = file["load_case/release/probe"][0]
        assert frames[:, probe] == pytest.approx(theirs["displacement"][:, 0], rel=1e-6, abs=1e-9)
        with pytest.raises(livermark.InputError, match="^fem_p2p1 has no motion; "):
            result["fem_p2p1"].history()


def test_a_diverged_model_is_a_row_like_any_other():
    with livermark.open(SAMPLES / "sample_result.h5") as result:
        errors = result.errors()
        assert errors.loc["blown_up", "status"] == "diverged"
        assert errors.loc["springs", "relative_l2"] == pytest.approx(0.2, rel=1e-3)
        assert result.reference["model"] in result.models
        assert result.compared_with == result.reference["model"] and result.reference_on_mesh


def test_a_reference_on_refined_meshes_is_known_as_such(tmp_path):
    path = tmp_path / "refined.h5"
    shutil.copy(SAMPLES / "sample_result.h5", path)
    with h5py.File(path, "r+") as file:
        file["reference"].attrs["refined_model"] = file["reference"].attrs["model"]
    with livermark.open(path) as result:
        assert not result.reference_on_mesh


def test_stiffness_at_the_tool_has_its_places_and_its_path():
    with livermark.open(SAMPLES / "path_result.h5") as result:
        tools = result.tools
        assert tools["places"] == ["x_max", "z_max"]
        assert tools["drive"].tolist() == [0, 2]
        assert tools["middle"].shape == (2, 3)
        assert tools["radius_in_edges"] == pytest.approx((tools["radius"] / tools["edge_length"]).min(), rel=1e-15)
        tool = result["springs"].at_tool
        assert tool["places"] == tools["places"]
        assert tool["path"].shape == (len(result.path_of_loads), 2)
        comparison = result["springs"].comparison
        assert abs(comparison["stiffness_at_tool"]) == numpy.abs(tool["stiffness"]).max()
        assert abs(comparison["worst_stiffness_at_tool"]) >= numpy.abs(tool["path"]).max()
        assert result.errors().loc["springs", "stiffness_at_tool"] == comparison["stiffness_at_tool"]
        assert result["fem_p2"].at_tool is None
        assert result.reference["stiffness_uncertainty"] == 0.008


def test_what_lies_on_and_in_a_body_is_read():
    with livermark.open(SAMPLES / "with_jaws_result.h5") as result:
        assert result.capsule == {"thickness": 2e-4, "young_modulus": 4e5}
        vessels = result.vessels
        assert vessels["points"].shape == (16, 3) and vessels["segments"].tolist() == [[p, p + 1] for p in range(15)]
        assert set(vessels["radius"]) == {0.01} and vessels["wall_ratio"] == 0.1 and vessels["wall_modulus"] == 0.62e6
        assert result.foundation["facet"].tolist() == [0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11]
        assert set(result.foundation["stiffness"]) == {1e6 / 7.0} and set(result.foundation["normal_only"]) == {1}
    with livermark.open(BENDING) as result:
        assert result.capsule is None and result.vessels is None and result.foundation is None


def test_a_path_of_loads_has_frames():
    with livermark.open(SAMPLES / "path_result.h5") as result:
        model = next(result[name] for name in result.models if result[name].frames is not None)
        assert model.frames.shape[1:] == (len(result.points), 3)


def test_grid_of_vtk_has_the_fields_of_the_file():
    numpy_support = pytest.importorskip("vtkmodules.util.numpy_support")
    with livermark.open(BENDING) as result:
        grid = result.to_vtk()
        assert grid.GetNumberOfCells() == len(result.tetrahedra)
        assert grid.GetNumberOfPoints() == len(result.points)
        assert grid.GetCellType(0) == 10
        corners = grid.GetCell(17).GetPointIds()
        assert [corners.GetId(c) for c in range(4)] == result.tetrahedra[17].tolist()
        field = numpy_support.vtk_to_numpy(grid.GetPointData().GetArray("displacement_lloyd"))
        assert numpy.array_equal(field, result["lloyd"].displacement)
        error = numpy_support.vtk_to_numpy(grid.GetPointData().GetArray("error_lloyd"))
        assert numpy.array_equal(error, result["lloyd"].error)
        assert grid.GetPointData().GetArray("error_fem_p2p1") is None
        region = numpy_support.vtk_to_numpy(grid.GetCellData().GetArray("region"))
        assert numpy.array_equal(region, result.region)
    del result
    assert numpy_support.vtk_to_numpy(grid.GetPoints().GetData()).shape == (1142, 3)  # of its own


def test_grid_of_pyvista_is_that_of_vtk_or_says_what_to_install():
    with livermark.open(BENDING) as result:
        try:
            import pyvista  # noqa: F401
        except ImportError:
            with pytest.raises(ImportError, match="^this needs pyvista; install pyvista from PyPI, which Debian 12"):
                result.to_pyvista()
        else:
            assert numpy.array_equal(result.to_pyvista()["displacement_lloyd"], result["lloyd"].displacement)


@pytest.mark.parametrize("make, sentence", [
    (lambda path: path.write_text("text"), "this is no HDF5 file, or it is damaged; make it again"),
    (lambda path: h5py.File(path, "w").close(), "the schema version is None, and 1 is read here"),
    (lambda path: path.write_bytes((SAMPLES / "sample_stability.h5").read_bytes()),
     "this is no result file of `livermark run`, it has no solutions")])
def test_other_files_are_refused_with_a_sentence(tmp_path, make, sentence):
    path = tmp_path / "file.h5"
    make(path)
    with pytest.raises(livermark.InputError, match=sentence):
        livermark.open(path)


def test_unknown_models_and_missing_files_are_refused(tmp_path):
    with livermark.open(BENDING) as result:
        with pytest.raises(livermark.InputError, match="there is no model 'loyd'; it has .*fem_p1, "):
            result["loyd"]
        with pytest.raises(livermark.InputError, match="there are no modes of 'lloyd'"):
            result.modes("lloyd")
    with pytest.raises(FileNotFoundError, match="there is no such file"):
        livermark.open(tmp_path / "nothing.h5")


def test_result_files_are_read_without_the_compiled_module(tmp_path):
    package = tmp_path / "livermark"
    shutil.copytree(pathlib.Path(livermark.__file__).parent, package, ignore=shutil.ignore_patterns("*.so"))
    code = f"""import livermark
assert livermark.__file__.startswith({str(tmp_path)!r})
assert len(livermark.open({str(BENDING)!r}).models) == 11
try:
    livermark.springs
except ImportError as error:
    assert "compiled" in str(error)
else:
    raise AssertionError
"""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(tmp_path)})


@pytest.mark.parametrize("place", ["mesh", "mesh/points", "solutions/lloyd"])
@pytest.mark.parametrize("kind", ["external link", "soft link", "external data", "virtual"])
def test_nothing_outside_of_a_file_is_opened(tmp_path, place, kind):
    path, pipe = tmp_path / "result.h5", tmp_path / "pipe"
    os.mkfifo(pipe)  # which would keep whoever opens it waiting
    path.write_bytes(BENDING.read_bytes())
    with h5py.File(path, "r+") as file:
        del file[place]
        if kind == "external link":
            file[place] = h5py.ExternalLink(str(pipe), "/")
        elif kind == "soft link":
            file[place] = h5py.SoftLink("/materials")
        elif kind == "external data":
            file.create_dataset(place, (4,), "f8", external=[(str(pipe), 0, h5py.h5f.UNLIMITED)])
        else:
            layout = h5py.VirtualLayout((3,), "f8")
            layout[:] = h5py.VirtualSource(str(pipe), "x", (3,))
            file.create_virtual_dataset(place, layout)
    with pytest.raises(livermark.InputError, match=f"/{place} is (a link to another place|kept in another file)"):
        livermark.open(path)
    with pytest.raises(livermark.InputError, match="this is not a plain file"):
        livermark.open(pipe)


def read_all(result):
    for name in ("provenance", "body", "load_case", "materials", "points", "tetrahedra", "region", "region_names", "models",
                 "boundary_triangles", "constraint_names", "tools", "reference", "compared_with", "path_of_loads"):
        getattr(result, name)
    result.errors()
    for name in result.models:
        model = result[name]
        for part in ("attributes", "displacement", "reaction", "springs", "comparison", "at_tool", "error", "frames"):
            getattr(model, part)
        if model.has_history:
            model.history()


@pytest.mark.parametrize("place", ["mesh/points", "solutions/lloyd/displacement", "load_case/constraint", "materials"])
def test_what_is_missing_in_a_file_is_said_in_words_of_ours(tmp_path, place):
    path = tmp_path / "result.h5"
    path.write_bytes(BENDING.read_bytes())
    with h5py.File(path, "r+") as file:
        del file[place]
    with livermark.open(path) as result, pytest.raises(livermark.InputError, match="^" + str(path) + ": it cannot be read"):
        read_all(result)


def test_a_dataset_that_cannot_be_in_the_file_is_refused(tmp_path):
    path = tmp_path / "result.h5"
    path.write_bytes(BENDING.read_bytes())
    with h5py.File(path, "r+") as file:
        del file["mesh/points"]
        file.create_dataset("mesh/points", (10**12, 3), "f8", chunks=(1000, 3))
    with pytest.raises(livermark.InputError, match="/mesh/points is said to have 22888183 MB, which is not in the file"):
        livermark.open(path)


def test_damaged_files_are_read_or_refused_in_words_of_ours(tmp_path):
    """In a process of its own, because HDF5 itself may crash on such a file."""
    code = f"""
import livermark, numpy, sys
sys.path.insert(0, {str(pathlib.Path(__file__).parent)!r})
from results_test import read_all
whole = open({str(BENDING)!r}, "rb").read()
generator = numpy.random.default_rng(5)
refused = 0
for trial in range(60):
    damaged = bytearray(whole)
    where = generator.integers(0, len(whole) if trial % 2 else 20000, 1 + trial // 4)
    for at in where.tolist():
        damaged[at] = generator.integers(256)
    open("damaged.h5", "wb").write(damaged[:len(whole) - generator.integers(0, 2) * trial * 1000])
    try:
        with livermark.open("damaged.h5") as result:
            read_all(result)
    except livermark.InputError as error:
        assert str(error).startswith("damaged.h5: ") and "\\n" not in str(error), error
        refused += 1
assert 10 < refused, refused
"""
    subprocess.run([sys.executable, "-c", code], check=True, cwd=tmp_path, timeout=300)


def test_a_file_that_is_closed_says_so():
    result = livermark.open(BENDING)
    lloyd = result["lloyd"]
    result.close()
    assert not result.is_open and not lloyd.is_open
    for read in (lambda: result.points, lambda: lloyd.displacement, lambda: result["lloyd"]):
        with pytest.raises(livermark.InputError, match="the file is closed; open it again"):
            read()


def words_of_a_start(code, **environment):
    """The last line of an interpreter that has the sources of the package, and none of its compiled parts."""
    started = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True,
                             env={**os.environ, "PYTHONPATH": str(SOURCE / "python"), **environment})
    assert started.returncode == 1, started.stdout
    return started.stderr.splitlines()[-1]


def test_an_interpreter_without_numpy_is_told_so():
    said = words_of_a_start("import sys; sys.modules['numpy'] = None; import livermark")
    assert said.startswith(f"ModuleNotFoundError: livermark needs numpy, which {sys.executable} does not have; start /usr/bin/python3")


@pytest.mark.parametrize("name", ["springs", "bodies()"])
def test_a_package_without_its_compiled_part_names_the_command_that_makes_it(name):
    said = words_of_a_start(f"import livermark; livermark.{name}")
    assert said.startswith("ImportError: ") and "run scripts/bootstrap --program" in said
