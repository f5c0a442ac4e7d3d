#include "studies/cutting/wound_reference.hpp"

#include <algorithm>
#include <array>
#include <map>

#include "core/mesh/refinement.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::studies {

namespace {

/// Along the way of the edge's middle, mean of the nodes at the rim [m].
double rim_depth(const core::TetraMesh &mesh, const BladeWay &way) {
    const auto &[a, b, c, d] = way.corners;
    const core::Vector3 start = 0.5 * (a + b), along = (c + d - a - b).normalized();
    const auto is_rim = wound_rim_nodes(mesh);
    double sum = 0.0;
    int count = 0;
    for (std::size_t i = 0; i < is_rim.size(); ++i)
        if (is_rim[i]) {
            sum += (mesh.points[i] - start).dot(along);
            ++count;
        }
    return sum / count;
}

} // namespace

std::vector<bool> wound_rim_nodes(const core::TetraMesh &mesh) {
    constexpr double folded = -1.0 + 1e-9; // cosine between the outward normals of the two sides
    std::map<std::array<int, 2>, core::Vector3> normal_at;
    std::vector<bool> is_rim(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        if (mesh.patch_names[mesh.boundary_patch[f]] != meshes::wound_patch)
            continue;
        const core::Vector3 normal = core::area_vector(mesh, f).normalized();
        const auto &nodes = mesh.boundary_triangles[f];
        for (std::size_t k = 0; k < 3; ++k) {
            const int a = nodes[k], b = nodes[(k + 1) % 3];
            const auto [other, is_first] = normal_at.try_emplace({std::min(a, b), std::max(a, b)}, normal);
            if (!is_first && normal.dot(other->second) < folded)
                is_rim[a] = is_rim[b] = true;
        }
    }
    return is_rim;
}

std::vector<results::CutLevel> solve_finer_at_wound(const core::Model &model, const BladeWay &way,
                                                    const std::string &cut, const CutStage &stage,
                                                    const core::Problem &problem, int times,
                                                    const std::function<void()> &begins, std::string &failure) {
    std::vector<results::CutLevel> levels;
    auto refined = problem;
    const double depth = rim_depth(stage.body->mesh, way);
    for (int level = 0; level <= times; ++level) {
        begins();
        if (level > 0)
            refined = core::refine_at_rims_and(refined, wound_rim_nodes(refined.body->mesh)).problem;
        const auto solution = model.solve(refined);
        if (solution.status != core::SolutionStatus::ok) {
            failure = solution.message;
            break;
        }
        levels.push_back({.way = cut,
                          .tetrahedra = refined.body->mesh.num_tetrahedra(),
                          .area = stage.area,
                          .depth = depth,
                          .opening = opening(stage, solution.displacement),
                          .tool_stiffness = stiffness_at_first_tool(refined, solution),
                          .solve_seconds = solution.setup_seconds + solution.solve_seconds});
    }
    return levels;
}

} // namespace livermark::studies
