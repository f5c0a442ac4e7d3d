#include "msm/cutting/part_of_body.hpp"

namespace livermark::msm {

PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions) {
    const auto &mesh = body.mesh;
    PartOfBody part{.body = {.name = body.name, .mesh = {}, .materials = body.materials}, .node = {}, .conditions = {}};
    auto &of_part = part.body.mesh;
    of_part.region_names = mesh.region_names;
    std::vector<int> number(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        if (is_in[t] == 0)
            continue;
        for (const int node : of_part.tetrahedra.emplace_back(mesh.tetrahedra[t]))
            number[node] = 0;
        of_part.region.push_back(mesh.region[t]);
    }
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = of_part.num_nodes();
            part.node.push_back(static_cast<int>(i));
            of_part.points.push_back(mesh.points[i]);
            part.conditions.displacement.push_back(conditions.displacement[i]);
            part.conditions.force.emplace_back(core::Vector3::Zero());
            part.conditions.constraint.push_back({-1, -1, -1});
        }
    for (auto &tetrahedron : of_part.tetrahedra)
        for (int &node : tetrahedron)
            node = number[node];
    return part;
}

} // namespace livermark::msm
