#pragma once

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/tool_motion.hpp"

namespace livermark::core {

/// How far a motion under a tool is from another one.
struct ToolErrors {
    /// sqrt(sum_k sum_i V_i |u_ki - r_ki|^2 / sum_k sum_i V_i |r_ki|^2) over the fields k and nodes i, V_i barycentric
    /// nodal volume: as long as the tool has hold, and from then on.
    double contact = 0.0, after = 0.0;
    double force = 0.0; ///< sqrt(sum_k |F_k - R_k|^2 / sum_k |R_k|^2) over the records as long as the tool has hold
    std::vector<double> over_time; ///< (F) of each field, over the largest size of a field of the reference

    bool operator==(const ToolErrors &) const = default;
};

/// Compares a motion with the reference. What is not finite gives errors that are not finite.
/// @param mesh  nodes of both
/// @throws std::invalid_argument if they do not have the same records and nodes
ToolErrors compare(const TetraMesh &mesh, const ToolMotion &motion, const ToolHistory &history,
                   const ToolHistory &reference);

} // namespace livermark::core
