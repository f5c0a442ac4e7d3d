#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/modes.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// A deformable model in the contest.
struct Model {
    std::string name;    ///< on the command line, in the result file, in the tests
    std::string summary; ///< one line
    std::string source;  ///< literature reference
    /// Static answer, and the history of a time-dependent load case; throws only for what is not the load's fault.
    std::function<Solution(const Problem &)> solve;
    /// Static answers to several problems of one body, which take less time together than one by one, as many as
    /// most_together at once; empty if nothing is gained.
    std::function<std::vector<Solution>(std::span<const Problem>)> solve_together{};
    std::size_t most_together = 1;
    /// Told of a body before the first of its problems is solved: a problem that holds what many others of them hold
    /// too, maybe among more. A factor of it may serve them all; answers change by rounding only. Empty if nothing is
    /// gained.
    std::function<void(const Problem &)> begin_with{};
    /// Lets go of what it keeps of a body, if anything, so that there is room for others; empty if it keeps nothing.
    std::function<void()> forget{};
    /// Its lowest modes, as many as asked for, with the constraints of the load case; empty if it cannot tell. Throws
    /// InputError if the body is free to move or has too few.
    std::function<Modes(const Problem &, int)> modes{};
    /// Whether it can do what its user asked for on a problem; throws InputError if not. Called for every problem
    /// before the first one is solved. Empty if nothing can be wrong.
    std::function<void(const Problem &)> check{};
    bool is_collective = false; ///< of several MPI ranks all have to call solve, and all get the answer
};

} // namespace livermark::core
