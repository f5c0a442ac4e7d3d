"""livermark.advise() says what the program says."""
import json
import subprocess
import types

import livermark
import pytest
from conftest import BINARY

BODY = "beam"  # the smallest that ships


@pytest.fixture(scope="module")
def advice():
    return livermark.advise(BODY, tool_radius=0.02)


def test_is_the_json_of_the_program_but_for_times(advice):
    text = subprocess.run([BINARY, "advise", BODY, "--tool-radius", "0.02", "--json"], check=True, capture_output=True,
                          text=True).stdout
    theirs = json.loads(text)
    assert advice["body"] == theirs["body"] and advice["evidence"] == theirs["evidence"]
    for ranking in ("touch", "position"):
        assert [model["model"] for model in advice[ranking]] == [model["model"] for model in theirs[ranking]]
        for ours, of_program in zip(advice[ranking], theirs[ranking]):
            assert ours["critical_time_step"] == of_program["critical_time_step"]
            assert 0.0 < ours["time_step"] < ours["critical_time_step"]
    assert [caveat["text"] for caveat in advice["caveats"]] == [caveat["text"] for caveat in theirs["caveats"]]
    assert len(advice["touch"]) == len(advice["position"]) == len(advice["caveats"]) == 3


def test_of_arrays_is_that_of_the_body(advice):
    problem = livermark.problem(BODY, "beam_bend")
    mesh = types.SimpleNamespace(points=problem.points, tetrahedra=problem.tetrahedra)
    ours = livermark.advise(mesh, problem.young_modulus, problem.poisson_ratio, problem.density, tool_radius=0.02)
    for number in ("tetrahedra", "nodes", "volume", "surface_edge", "tool_radius_in_edges"):
        assert ours["body"][number] == advice["body"][number]
    assert ours["touch"][0]["critical_time_step"] == pytest.approx(advice["touch"][0]["critical_time_step"], rel=1e-9)
    assumed = livermark.advise(mesh, tool_radius=0.02)
    assert "material" in [caveat["about"] for caveat in assumed["caveats"]]


def test_leaves_out_what_takes_too_long(advice):
    dearest = max(model["seconds_per_frame"] for model in advice["touch"])
    some = livermark.advise(BODY, tool_radius=0.02, budget=dearest / 4.0)
    assert some["over_budget"] and some["budget"] == dearest / 4.0


@pytest.mark.parametrize("arguments, fault", [
    ({"tool_radius": 12.0}, "tool_radius"), ({"tool_radius": "12 mm"}, "tool_radius"), ({"budget": 0.0}, "budget"),
    ({"budget": 1e-12}, "every model takes longer"), ({"density": 1000.0}, "a file has its own")])
def test_refuses_what_is_wrong(arguments, fault):
    with pytest.raises(livermark.InputError, match=fault):
        livermark.advise(BODY, **arguments)


def test_refuses_what_is_no_body():
    with pytest.raises(livermark.InputError, match="no name, no path"):
        livermark.advise(42)
    with pytest.raises(livermark.InputError, match="there is no body 'liver_helthy'"):
        livermark.advise("liver_helthy")
