#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/problem.hpp"

namespace livermark::core {

/// Stiffnesses of springs that were fitted to the solutions of another model, and what they hold for.
struct CalibratedSprings {
    std::string origin;                    ///< the file that they come from, for messages
    std::vector<Material> materials;       ///< (R) that they were fitted for
    std::vector<std::array<int, 2>> edges; ///< (S) as in the EdgeTable of the mesh
    std::vector<double> rest_length;       ///< (S) [m]
    std::vector<double> stiffness;         ///< (S) [N/m], > 0
};

/// @throws InputError if they were fitted for a mesh with other edges or lengths, or for other elastic constants, than
///         the body has; the density has no part in them
void check_fit(const CalibratedSprings &springs, const Body &body);

} // namespace livermark::core
