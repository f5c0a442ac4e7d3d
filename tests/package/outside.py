"""A program of somebody else that uses the installed Python package, and nothing of the source tree."""
import os
import sys

import livermark
import numpy

assert livermark.__file__.startswith(sys.argv[1]), livermark.__file__
points = 0.01 * numpy.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
tetrahedra = [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]]
springs = livermark.springs(points, tetrahedra, young_modulus=5000.0, poisson_ratio=0.45)
step = 0.8 * livermark.critical_time_step(springs, fixed=range(4))
simulation = livermark.Simulation(springs, step, fixed=range(4), forces=numpy.full((8, 3), [1e-3, 0, 0]))
simulation.step(1000)
print(f"{len(springs.stiffness)} springs, 1000 steps of {1e3 * step:.3g} ms, "
      f"{1e3 * numpy.linalg.norm(simulation.displacement[7]):.3g} mm")
assert 0.0 < abs(simulation.displacement).max() < 0.01

if os.path.exists(os.path.join(os.path.dirname(livermark.__file__), "data")):
    assert "liver_healthy" in livermark.bodies() and "palpation" in livermark.load_cases()
    assert os.environ["LIVERMARK_ROOT"].startswith(sys.argv[1])
    solution = livermark.solve("beam", "beam_bend", "lloyd")
    print(f"the beam bends by {1e3 * numpy.linalg.norm(solution.displacement, axis=1).max():.3g} mm")

# The report comes with its templates.
from livermark.report import page  # noqa: E402
from livermark.report.data import ReportData  # noqa: E402

of_files = {name: [] for name in ("faults", "others", "results", "large", "arenas", "cohorts", "experiments", "needles", "stability",
                                  "timings", "large_bodies", "slow", "large_slow", "sensitivities", "brief", "large_brief")}
html = page.make(ReportData({"folder": "runs", "command": "livermark report runs", "tables": {}, **of_files,
                             "smallest_felt_difference": 0.07, "reference": "", "large_reference": "", "tool_legend": "",
                             "large_legend": "", "slow_legend": "",
                             "standings": {"rest": [], "motion": []}}))
assert html.startswith("<!DOCTYPE html>") and "What else a report can show" in html
