#include "studies/arena/arena_mesh.hpp"

#include <array>
#include <memory>
#include <set>
#include <utility>

#include "core/mesh/local_refinement.hpp"
#include "core/mesh/refinement.hpp"

namespace livermark::studies {

namespace {

constexpr int mesh_as_it_is = 1, bisected = 2, cut_into_eight = 3;

std::set<std::array<int, 2>> longest_edges(const core::TetraMesh &mesh) {
    std::set<std::array<int, 2>> edges;
    for (const auto &nodes : mesh.tetrahedra) {
        std::array<int, 2> longest{};
        double length = 0.0;
        for (std::size_t a = 0; a < 4; ++a)
            for (std::size_t b = a + 1; b < 4; ++b) {
                const std::array<int, 2> edge{std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])};
                const double here = (mesh.points[edge[0]] - mesh.points[edge[1]]).norm();
                if (here > length) {
                    length = here;
                    longest = edge;
                }
            }
        edges.insert(longest);
    }
    return edges;
}

} // namespace

core::Problem on_arena_mesh(const core::Problem &problem, int mesh) {
    if (mesh == mesh_as_it_is)
        return problem;
    if (mesh == cut_into_eight)
        return core::refine(problem);
    auto parts = core::bisect(*problem.body, longest_edges(problem.body->mesh));
    auto load_case = core::on_parts(problem.load_case, parts);
    return {std::make_shared<const core::Body>(std::move(parts.body)), std::move(load_case)};
}

} // namespace livermark::studies
