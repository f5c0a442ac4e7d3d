#include "models/tool_motion/tool_place.hpp"

namespace livermark::models {

ToolPlace tool_place(const core::Problem &problem, const std::vector<double> &node_mass) {
    const auto conditions_of = [&](const core::LoadCase &load_case) {
        return msm::nodal_conditions({problem.body, load_case}, node_mass);
    };
    ToolPlace place;
    place.motion = problem.load_case.tool.value();
    place.while_held = conditions_of(problem.load_case);
    place.let_go = conditions_of(core::let_go(problem.load_case));
    const auto slid = conditions_of(core::with_slide(problem.load_case));
    for (std::size_t node = 0; node < node_mass.size(); ++node) {
        const int constraint = place.while_held.constraint[node][0];
        if (constraint == place.motion.constraint) {
            place.nodes.push_back(static_cast<int>(node));
            place.pressed.push_back(place.while_held.displacement[node]);
            place.slid.push_back(slid.displacement[node]);
        } else if (constraint >= 0) {
            place.held.push_back(static_cast<int>(node));
        }
    }
    return place;
}

} // namespace livermark::models
