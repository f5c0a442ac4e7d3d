#include <algorithm>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/live/parameters.hpp"
#include "app/live/scene.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/springs.hpp"
#include "msm/statics/load_path.hpp"
#include "tests/app/live/box_scene.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

/// Differences are the small part of a motion that damping has left, and single precision.
constexpr double margin = 0.01;
/// Volume of the smallest tetrahedron, as a part of that at rest, below which the guard against inversion is at work,
/// which models of the comparison do not have.
constexpr double guarded = 0.5;

/// Answer of a model of the comparison to a ball that goes straight to where the one here is.
/// @param has_guard  gives the model the guard that springs have here
/// @return the force on the body [N]
Vector3 force_in_load_case(const core::Body &body, const std::vector<bool> &is_constrained, const Tool &tool,
                           const Vector3 &start, const Vector3 &end, bool has_guard) {
    const auto problem = touched_by_ball(body, is_constrained, tool, start, end - start);
    auto model = msm::coupled_springs_with_volume(body, msm::find_coupled_springs("nodal_neo_hookean"));
    if (has_guard)
        model.terms.push_back(msm::inversion_guard(with_material_of_guard(body)));
    const auto conditions = msm::nodal_conditions(problem, model.node_mass);
    const msm::RestStiffness rest(model, body.mesh.points, conditions.displacement);
    const auto path = msm::follow_path(model, problem, model.node_mass, rest);
    EXPECT_EQ(path.end.status, core::SolutionStatus::ok) << path.end.message;
    return path.points.back().reaction[1];
}

std::vector<bool> constrained_at_the_back(const core::TetraMesh &mesh) {
    std::vector<bool> constrained;
    for (const int patch : mesh.boundary_patch)
        constrained.push_back(mesh.patch_names[patch] == "posterior");
    return constrained;
}

/// A place on the front, in the middle of a triangle or at a node of it, and its normal.
std::pair<Vector3, Vector3> place_on_front(const core::TetraMesh &mesh, double part, bool is_at_node) {
    std::vector<int> front;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.patch_names[mesh.boundary_patch[f]] == "anterior" && area_vector(mesh, f).normalized().y() < -0.9)
            front.push_back(f);
    const int facet = front[static_cast<std::size_t>(part * static_cast<double>(front.size()))];
    const auto [a, b, c] = mesh.boundary_triangles[facet];
    const auto &x = mesh.points;
    return {is_at_node ? x[a] : Vector3((x[a] + x[b] + x[c]) / 3.0), area_vector(mesh, facet).normalized()};
}

/// Presses at the speed of a hand, and lets it come to rest.
Frame pressed(Scene &scene, const Chosen &chosen, Tool tool, const Vector3 &place, const Vector3 &outwards,
              double depth) {
    constexpr double interval = 0.02, speed = 0.05, until = 1.5; // [s], [m/s], [s]
    Frame frame;
    for (double time = 0.0; time < until; time += interval) {
        const double now = std::min(depth, speed * time);
        tool.target = place + (tool.radius - now) * outwards;
        frame = scene.move(tool, static_cast<int>(interval / chosen.time_step));
    }
    return frame;
}

void expect_as_in_load_cases(const std::string &name) {
    const auto body = meshes::read_body(std::string(LIVERMARK_SOURCE_DIR "/meshes/") + name + ".toml");
    int num_guarded = 0;
    for (const double part : {0.3, 0.7})
        for (const bool is_at_node : {true, false})
            for (const auto &[depth, radius] : {std::pair(0.005, 0.012), {0.012, 0.02}, {0.016, 0.012}}) {
                Scene scene(body, constrained_at_the_back(body.mesh));
                const auto chosen = scene.choose({.young_modulus = body.materials[0].young_modulus,
                                                  .poisson_ratio = body.materials[0].poisson_ratio,
                                                  .damping = {40.0, 0.0}});
                // Without friction, with which there are many equilibria.
                const Tool tool{.kind = ToolKind::probe, .radius = radius, .friction = 0.0};
                const auto [place, outwards] = place_on_front(body.mesh, part, is_at_node);
                const auto frame = pressed(scene, chosen, tool, place, outwards, depth);
                EXPECT_GT(frame.indentation, 0.3 * depth);
                const bool is_guarded = frame.smallest_volume < guarded;
                num_guarded += is_guarded ? 1 : 0;
                const Vector3 expected = force_in_load_case(body, constrained_at_the_back(body.mesh), tool,
                                                            place + radius * outwards, frame.tool, is_guarded);
                EXPECT_LT((frame.force + expected).norm(), margin * expected.norm())
                    << name << ", part " << part << (is_at_node ? ", node, " : ", facet, ") << depth << " m deep";
            }
    EXPECT_LE(num_guarded, 4) << "the guard is at work where 12 mm of finger go 16 mm deep alone";
}

TEST(LiveAtRest, PressesTheHealthyLiverAsTheLoadCaseOfItsToolDoes) {
    expect_as_in_load_cases("liver_healthy");
}

TEST(LiveAtRest, PressesTheLiverWithTumoursAsTheLoadCaseOfItsToolDoes) {
    expect_as_in_load_cases("liver_tumours");
}

} // namespace
} // namespace livermark::live
