#include "benchmarks/kernels/node_order.hpp"

#include <numeric>

#include "msm/kernels/layout/sliced_body.hpp"

namespace livermark::benchmarks {

namespace {

std::vector<int> inverse(std::span<const int> order) {
    std::vector<int> number(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        number[order[i]] = static_cast<int>(i);
    return number;
}

} // namespace

core::Body renumbered(core::Body body, std::span<const int> order) {
    const auto number = inverse(order);
    auto &mesh = body.mesh;
    std::vector<core::Vector3> points(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        points[i] = mesh.points[order[i]];
    mesh.points = std::move(points);
    for (auto &tetrahedron : mesh.tetrahedra)
        for (auto &node : tetrahedron)
            node = number[node];
    for (auto &triangle : mesh.boundary_triangles)
        for (auto &node : triangle)
            node = number[node];
    return body;
}

Neighbours neighbours(std::span<const std::array<int, 2>> edges, int num_nodes) {
    const auto number = inverse(msm::reverse_cuthill_mckee(edges, num_nodes));
    Neighbours result{.start = std::vector<int>(num_nodes + 1, 0), .neighbour = std::vector<int>(2 * edges.size())};
    for (const auto &edge : edges)
        for (const int node : edge)
            ++result.start[number[node] + 1];
    std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
    auto place = result.start;
    for (const auto &[i, j] : edges) {
        result.neighbour[place[number[i]]++] = number[j];
        result.neighbour[place[number[j]]++] = number[i];
    }
    return result;
}

} // namespace livermark::benchmarks
