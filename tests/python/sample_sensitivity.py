"""Five patients of a jelly, three parameters in two groups, two outputs and one model. The numbers are made up.

sample_sensitivity.py FOLDER writes sample_sensitivity.h5 there, and adds the statistics to sample_cohort.h5.
"""
import math
import pathlib
import sys

from livermark.studies import cohort
from livermark.studies.sensitivity.ranges import Parameter
from livermark.studies.sensitivity.record import Budget, Output, Sensitivity, write

PROVENANCE = {"software_version": "1", "git_commit": "0123abc", "created": "2026-11-01T00:00:00Z",
              "command": "livermark sensitivity jelly", "cpu": "a spoon", "compiler": "a cook", "build_type": "Release", "threads": 1}


def sample_sensitivity() -> Sensitivity:
    parameters = [Parameter("young_modulus", "Pa", "parameters", 4000.0, 6000.0, False, "a cook"),
                  Parameter("poisson_ratio", "", "parameters", 0.45, 0.49, False, "another cook"),
                  Parameter("support_stiffness", "Pa/m", "support", 1e5, 1e7, True, "the plate")]

    def output(name, unit):
        return Output(name, unit, nominal=101.0, mean=100.0, deviation=20.0, lower=70.0, upper=130.0, unexplained=0.01,
                      first=[0.75, 0.1, 0.1], first_lower=[0.7, 0.05, 0.05], first_upper=[0.8, 0.15, 0.15],
                      total=[0.8, 0.1, 0.15], total_lower=[0.75, 0.05, 0.1], total_upper=[0.85, 0.15, 0.2],
                      group_total=[0.9, 0.15])
    return Sensitivity(PROVENANCE, "jelly", "spoon", "A spoon on a jelly", "elements", "0123456789abcdef", parameters,
                       points=[[4000.0 + 400.0 * s, 0.45 + 0.01 * s, 1e5 * (1.0 + s)] for s in range(5)],
                       values=[[100.0 + s, 0.002] for s in range(5)],
                       outputs=[output("stiffness_at_tool", "N/m"), output("peak_displacement", "m")],
                       budget=Budget("elements_refined", mesh=[0.002, 0.003], law=[-0.035, math.nan],
                                     measurement=[math.nan, 0.1], models={"springs": [0.04, -0.05]}))


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    write(folder / "sample_sensitivity.h5", sample_sensitivity())
    cohort.finish(folder / "sample_cohort.h5")
