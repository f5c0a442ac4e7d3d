#include "studies/cutting/growing_cut.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/processor_time.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "meshes/cutting/cut.hpp"
#include "meshes/io/mesh_checks.hpp"

namespace livermark::studies {

namespace {

double wound_area(const core::TetraMesh &mesh) {
    double area = 0.0;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == meshes::wound_patch)
            area += core::area_vector(mesh, f).norm();
    return area;
}

/// Nodes of the wound that are in one place at rest.
std::vector<std::array<int, 2>> parted_nodes(const core::TetraMesh &mesh) {
    std::map<std::array<double, 3>, std::vector<int>> at_place;
    std::vector<bool> is_seen(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == meshes::wound_patch)
            for (const int node : mesh.boundary_triangles[f])
                if (!is_seen[node]) {
                    is_seen[node] = true;
                    const auto &point = mesh.points[node];
                    at_place[{point.x(), point.y(), point.z()}].push_back(node);
                }
    std::vector<std::array<int, 2>> pairs;
    for (const auto &[place, nodes] : at_place)
        for (std::size_t k = 1; k < nodes.size(); ++k)
            pairs.push_back({nodes[0], nodes[k]});
    return pairs;
}

/// Edges behind the blade's edge at which a body that has moved is still cut: a face that could not be parted while the
/// cut ended at it is parted later. Further behind the wound is open, and the blade may be where other tissue is now.
constexpr double edges_behind = 2.0;

/// The body cut where it is now, and back at rest: along facets, corners keep their order.
meshes::CutBody cut_where_it_is(const core::Body &body, const std::vector<core::Vector3> &displacement,
                                const meshes::Cut &cut) {
    auto moved = body;
    for (std::size_t i = 0; i < displacement.size(); ++i)
        moved.mesh.points[i] += displacement[i];
    auto result = meshes::cut(moved, cut);
    auto &mesh = result.body.mesh;
    const auto &parents = result.parents.front();
    for (std::size_t t = 0; t < parents.size(); ++t)
        for (std::size_t k = 0; k < 4; ++k)
            mesh.points[mesh.tetrahedra[t][k]] = body.mesh.points[body.mesh.tetrahedra[parents[t]][k]];
    return result;
}

} // namespace

double BladeWay::depth() const {
    return 0.5 * (corners[3] + corners[2] - corners[0] - corners[1]).norm();
}

std::array<core::Vector3, 4> BladeWay::swept(double from, double to) const {
    const auto at = [&](int begin, int end, double part) -> core::Vector3 {
        return (1.0 - part) * corners[begin] + part * corners[end];
    };
    return {at(0, 3, from), at(1, 2, from), at(1, 2, to), at(0, 3, to)};
}

std::vector<CutStage> grow_cut(std::shared_ptr<const core::Body> body, const BladeWay &way,
                               const DisplacementOf &displacement_of) {
    const double before = wound_area(body->mesh); // of cuts that were there
    const double behind = edges_behind * meshes::mesh_figures(body->mesh).mean_edge / way.depth();
    std::vector<CutStage> stages{{.body = std::move(body)}};
    for (int step = 0; step < way.num_steps; ++step) {
        const auto &last = stages.back();
        const double from = displacement_of ? std::max(0.0, double(step) / way.num_steps - behind) : 0.0;
        const meshes::Cut cut{.tool = meshes::BladeCut{way.swept(from, double(step + 1) / way.num_steps)},
                              .place = "the blade"};
        auto next = last;
        next.parents.clear();
        next.depth = way.depth() * (step + 1) / way.num_steps;
        const auto displacement = displacement_of ? displacement_of(last) : std::vector<core::Vector3>{};
        const double start = core::processor_seconds();
        try {
            auto result = cut_where_it_is(*last.body, displacement, cut);
            next.parents = std::move(result.parents.front());
            next.body = std::make_shared<const core::Body>(std::move(result.body));
        } catch (const meshes::CutMissesBody &) {
            // nothing to part in this step
        } catch (const meshes::CutNotOnBody &error) {
            throw meshes::CutNotOnBody(fmt::format("the blade, {:.3g} mm deep", 1e3 * next.depth), error.reason(),
                                       "let it end before that, or go in elsewhere");
        }
        next.seconds = core::processor_seconds() - start;
        if (next.body != last.body) {
            next.area = 0.5 * (wound_area(next.body->mesh) - before);
            next.parted = parted_nodes(next.body->mesh);
        }
        stages.push_back(std::move(next));
    }
    if (stages.back().area == 0.0)
        throw meshes::CutMissesBody("the blade", "it parts no face of a tetrahedron on its way",
                                    "let it go through the body, and where that is not cut yet");
    return stages;
}

CutStage cut_exactly(const core::Body &body, const BladeWay &way) {
    auto result = meshes::cut(
        body, {.tool = meshes::BladeCut{way.corners}, .way = meshes::CutWay::exact, .place = "the blade, exactly"});
    const auto &mesh = result.body.mesh;
    CutStage stage{.body = {},
                   .depth = way.depth(),
                   .area = 0.5 * (wound_area(mesh) - wound_area(body.mesh)),
                   .parted = parted_nodes(mesh)};
    stage.body = std::make_shared<const core::Body>(std::move(result.body));
    return stage;
}

double opening(const CutStage &stage, const std::vector<core::Vector3> &displacement) {
    double widest = 0.0;
    for (const auto &[one, other] : stage.parted)
        widest = std::max(widest, (displacement[one] - displacement[other]).norm());
    return widest;
}

double stiffness_at_first_tool(const core::Problem &problem, const core::Solution &solution) {
    const auto &mesh = problem.body->mesh;
    const auto places = core::tool_places(mesh, problem.load_case);
    return places.empty() ? std::numeric_limits<double>::quiet_NaN()
                          : core::stiffness_at(mesh, problem.load_case, places, 0, solution);
}

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
