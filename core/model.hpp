#pragma once

#include <functional>
#include <string>

#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::core {

/// A deformable model in the contest.
struct Model {
    std::string name;                               ///< on the command line, in the result file, in the tests
    std::string summary;                            ///< one line
    std::string source;                             ///< literature reference
    std::function<Solution(const Problem &)> solve; ///< static answer; throws only for what is not the load's fault
    bool is_collective = false; ///< of several MPI ranks all have to call solve, and all get the answer
};

} // namespace livermark::core
