"""The parts of a report, a file each with section(data), which returns a parts.Section, or None where it has no place.

To add one, write its file and name it in this list, in the order of the page.
"""
from livermark.report.sections import (arena, cards, cohort, cost, errors, experiments, large, needles, numbers, pictures,
                                       poisson, refinement, relaxation, sensitivity, steps, timings)

SECTIONS = (errors, large, relaxation, experiments, needles, sensitivity, arena, cards, cohort, pictures, cost, poisson, refinement,
            steps, timings, numbers)
