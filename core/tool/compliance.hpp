#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace livermark::core {

/// How a body at rest gives way inside: C, the displacement of each of K places for one newton on each, linearised.
/// Component i of place k has number 3 k + i.
struct Compliance {
    Eigen::MatrixXd matrix;                  ///< C, shape (3 K, 3 K) [m/N], symmetric but for what solvers leave
    std::vector<Eigen::MatrixXd> on_coarser; ///< the same of the meshes before, of models that refine; coarsest first
    std::int64_t degrees_of_freedom = 0;     ///< unknowns, constrained ones included
    double seconds = 0.0;                    ///< for all of it
};

} // namespace livermark::core
