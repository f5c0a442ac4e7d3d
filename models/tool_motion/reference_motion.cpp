#include "models/tool_motion/reference_motion.hpp"

#include <algorithm>
#include <utility>

#include "core/mesh/local_refinement.hpp"
#include "fem_reference/hyperelastic/motion/tool_motion.hpp"

namespace livermark::models {

core::ToolHistory reference_motion(const core::Problem &problem, int level, int steps_per_frame) {
    const auto refined = core::refine_at_rims(problem, level);
    auto history = hyperelastic::move_tool(refined, hyperelastic::material_law("neo_hookean"), 2, steps_per_frame);
    const auto num_nodes = static_cast<std::ptrdiff_t>(problem.body->mesh.points.size());
    const auto num_refined = static_cast<std::ptrdiff_t>(refined.body->mesh.points.size());
    std::vector<Eigen::Vector3f> of_mesh; // whose nodes come first
    for (auto field = history.displacement.begin(); field != history.displacement.end(); field += num_refined)
        of_mesh.insert(of_mesh.end(), field, field + num_nodes);
    history.displacement = std::move(of_mesh);
    return history;
}

} // namespace livermark::models
