#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "app/live/springs.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/spring_energy.hpp"
#include "msm/springs/coupled_springs.hpp"
#include "msm/springs/spring_network.hpp"
#include "msm/statics/equilibrium.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

/// What differs is the small part of a motion that damping has left, how finely a disc is summed, and single precision.
constexpr double margin = 0.01;
/// Volume of the smallest tetrahedron, as a part of that at rest, below which the guard against inversion is at work,
/// which models of the comparison do not have.
constexpr double guarded = 0.5;

/// What a model of the comparison says to the load case that does what a tool does here: a round tool of the same
/// radius around the same place, which presses along the same way as deep.
/// @param has_guard  gives the model the guard that springs have here
/// @return the force on the body [N]
double force_in_load_case(const core::Body &body, const Frame &frame, bool has_guard) {
    const Vector3 way = -frame.indentation / frame.force.norm() * frame.force;
    const auto &[middle, radius] = frame.load.shape;
    const auto text = fmt::format(R"(title = "Live"
regime = "large"
target_peak_displacement = 0.01
[[condition]]
patch = "posterior"
displacement = [0.0, 0.0, 0.0]
[[condition]]
disc = {{ point = [{:.16e}, {:.16e}, {:.16e}], radius = {:.16e}, profile = "round" }}
press_along = [{:.16e}, {:.16e}, {:.16e}]
)",
                                  middle.x(), middle.y(), middle.z(), radius, way.x(), way.y(), way.z());
    const core::Problem problem{.body = std::make_shared<core::Body>(body),
                                .load_case = load_cases::parse_load_case(text, "live.toml", body.mesh)};
    auto model = msm::coupled_springs_with_volume(body, msm::find_coupled_springs("nodal_neo_hookean"));
    if (has_guard)
        model.terms.push_back(msm::inversion_guard(with_material_of_guard(body)));
    const auto conditions = msm::nodal_conditions(problem, model.node_mass);
    const auto rest = msm::find_equilibrium(model, body.mesh.points, conditions);
    EXPECT_EQ(rest.status, core::SolutionStatus::ok) << rest.message;
    return rest.press;
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
Frame pressed(Scene &scene, const Chosen &chosen, const Vector3 &place, const Vector3 &outwards, double depth,
              double radius) {
    constexpr double interval = 0.02, speed = 0.05, until = 1.5; // [s], [m/s], [s]
    Frame frame;
    for (double time = 0.0; time < until; time += interval) {
        const double now = std::min(depth, speed * time);
        const Tool tool{.kind = ToolKind::probe, .target = place + (radius - now) * outwards, .radius = radius};
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
                const auto [place, outwards] = place_on_front(body.mesh, part, is_at_node);
                const auto frame = pressed(scene, chosen, place, outwards, depth, radius);
                EXPECT_GT(frame.indentation, 0.6 * depth);
                EXPECT_EQ(frame.load.shape.radius, radius);
                EXPECT_LT((frame.load.shape.middle - place).norm(), 0.5 * depth) << "it slides off no slope here";
                const bool is_guarded = frame.smallest_volume < guarded;
                num_guarded += is_guarded ? 1 : 0;
                const double expected = force_in_load_case(body, frame, is_guarded);
                EXPECT_NEAR(frame.force.norm(), expected, margin * expected)
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
