#include "msm/cutting/rest_scaling.hpp"

#include "msm/cutting/part_of_body.hpp"

namespace livermark::msm {

MassScaling scale_masses_of_rest(const core::Body &body, const std::vector<char> &is_removed,
                                 const std::function<ElasticBody(const core::Body &)> &make,
                                 const NodalConditions &conditions) {
    std::vector<char> is_there;
    for (const char each : is_removed)
        is_there.push_back(each == 0 ? 1 : 0);
    const auto rest = part_of_body(body, is_there, conditions);
    if (rest.node.empty())
        return {};
    auto scaling = scale_masses(rest.body, make(rest.body), rest.conditions);
    for (auto &part : scaling.parts)
        for (int &node : part.nodes)
            node = rest.node[node];
    return scaling;
}

} // namespace livermark::msm
