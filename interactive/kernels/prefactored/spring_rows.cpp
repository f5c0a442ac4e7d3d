#include "interactive/kernels/prefactored/spring_rows.hpp"

#include <algorithm>

#include "interactive/cutting/orders.hpp"

namespace livermark::interactive::kernels {

namespace {

struct SpringAtNode {
    std::size_t spring;
    int other;
};

/// What fills up: of some length.
constexpr float numbers_of_no_spring[numbers_of_spring] = {1.0F, 0.0F, 0.0F, 1.0F, 0.0F};

} // namespace

SpringRows spring_rows(const Scene &scene, const Springs &springs) {
    const auto &mesh = scene.body->mesh;
    std::vector<std::vector<SpringAtNode>> at_node(mesh.points.size());
    std::vector<int> num_springs(mesh.points.size(), 0);
    for (std::size_t s = 0; s < springs.edges.size(); ++s)
        for (std::size_t end = 0; end < 2; ++end) {
            at_node[springs.edges[s][end]].push_back({s, springs.edges[s][1 - end]});
            ++num_springs[springs.edges[s][end]];
        }
    SpringRows rows;
    const bool has_order = scene.orders && scene.orders->rows.size() == mesh.points.size();
    const auto order = has_order ? scene.orders->rows : order_of_nodes(mesh.tetrahedra, {}, num_springs);
    rows.place(scene, order);
    rows.force.assign(4 * rows.num_rows, 0.0F);
    for (std::size_t row = 0; row < rows.num_rows; ++row)
        rows.self.push_back(static_cast<std::int32_t>(4 * row));
    rows.item_start.assign(1, 0);
    for (std::size_t first = 0; first < rows.num_rows; first += slice_size) {
        const std::size_t last = std::min(first + slice_size, order.size());
        std::size_t most = 0;
        for (std::size_t row = first; row < last; ++row)
            most = std::max(most, at_node[order[row]].size());
        for (std::size_t k = 0; k < most; ++k) {
            const std::size_t at = rows.numbers.size();
            rows.numbers.resize(at + numbers_of_spring * slice_size);
            for (std::size_t lane = 0; lane < slice_size; ++lane) {
                const std::size_t row = first + lane;
                const auto put = [&](const auto &numbers) {
                    for (std::size_t n = 0; n < numbers_of_spring; ++n)
                        rows.numbers[at + n * slice_size + lane] = static_cast<float>(numbers[n]);
                };
                if (row >= last || k >= at_node[order[row]].size()) {
                    rows.other.push_back(rows.self[row]);
                    put(numbers_of_no_spring);
                    continue;
                }
                const auto [spring, other] = at_node[order[row]][k];
                const core::Vector3 to_other = mesh.points[other] - mesh.points[order[row]];
                rows.other.push_back(4 * rows.row_of_node[other]);
                put(std::array{to_other.x(), to_other.y(), to_other.z(), springs.rest_length[spring],
                               springs.stiffness[spring]});
            }
        }
        rows.item_start.push_back(rows.item_start.back() + most);
    }
    return rows;
}

} // namespace livermark::interactive::kernels
