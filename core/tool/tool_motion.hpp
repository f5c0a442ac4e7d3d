#pragma once

#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"

namespace livermark::core {

/// 0 before a time and 1 from another one on, with velocity and acceleration continuous between: 10 s^3 - 15 s^4 +
/// 6 s^5.
double smooth_step(double time, double from, double until);

/// Position of the tool: parts of its depth and of its slide.
struct ToolPosition {
    double pressed = 0.0, slid = 0.0;
};
ToolPosition tool_position(const ToolMotion &motion, double time);

/// (K) of the records [s]
std::vector<double> record_times(const ToolMotion &motion);

/// The last record at which the tool has hold of the place: frames from there on begin without it.
int last_record_held(const ToolMotion &motion);

/// The load case with its place free: what holds once the tool has let go.
LoadCase let_go(LoadCase load_case);

/// The load case with the slide of the tool in place of its depth, the same at all nodes of the place. Displacements
/// of the place are pressed times those of the load case plus slid times these.
LoadCase with_slide(LoadCase load_case);

/// A body that a tool moves: a record at t = 0 and after each frame, K in all.
struct ToolHistory {
    std::vector<double> time;                  ///< (K) [s]
    std::vector<Vector3> force;                ///< (K) elastic, of the body on the tool [N]; zero once it has let go
    std::vector<Eigen::Vector3f> displacement; ///< (F, N) [m] of records 0, f, 2 f, ... with f frames_per_field

    static constexpr int frames_per_field = 4;
    static bool has_field(int record) { return record % frames_per_field == 0; }
    static std::size_t num_fields(int num_records) {
        return (static_cast<std::size_t>(num_records) - 1) / frames_per_field + 1;
    }
};

/// Distance of a motion under a tool from another one.
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
