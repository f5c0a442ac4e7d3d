#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

/// What Python calls a Problem: a body with its loads, scaled, and what a user should know of the input.
struct LoadedBody {
    core::Problem problem;
    std::vector<std::string> notes;
};

/// Adds the class Problem, and the function that reads one.
void add_problem(py::module_ &module);

/// Adds the class Solution and Problem.solve().
void add_solve(py::module_ &module, py::class_<LoadedBody> &problem);

/// Adds the class Score and Problem.score().
void add_score(py::module_ &module, py::class_<LoadedBody> &problem);

/// Adds the class CutBody, and the function that cuts one.
void add_cut(py::module_ &module);

/// Adds the functions behind livermark.advise().
void add_advise(py::module_ &module);

/// Adds the names of bodies, load cases and models.
void add_catalogue(py::module_ &module);

} // namespace livermark::python
