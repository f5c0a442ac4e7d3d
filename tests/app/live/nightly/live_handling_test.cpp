#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "app/live/scene.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"

namespace livermark::live {
namespace {

using core::Vector3;

constexpr int num_handlings = 150;
/// Times in which a tool touches, leaves the body alone after that, and leaves it alone in the end [s].
constexpr double touch = 0.06, pause = 0.015, at_rest_after = 1.2;

/// A node that can be touched, and where its outside is.
struct Place {
    int node = 0;
    Vector3 point, normal;
};

/// Facets that a load case holds still.
std::vector<bool> constrained_facets(const core::LoadCase &load_case) {
    std::vector<bool> constrained;
    for (int f = 0; f < load_case.num_facets(); ++f)
        constrained.push_back(load_case.is_constrained(f) && load_case.value[f].isZero(0.0));
    return constrained;
}

std::vector<Place> places(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained) {
    std::vector<Vector3> normal(mesh.points.size(), Vector3::Zero());
    std::vector<char> can_move(mesh.points.size(), 1);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const auto [a, b, c] = mesh.boundary_triangles[f];
        const auto &x = mesh.points;
        for (const int node : {a, b, c}) {
            normal[node] += (x[b] - x[a]).cross(x[c] - x[a]);
            if (is_constrained[f])
                can_move[node] = 0;
        }
    }
    std::vector<Place> found;
    for (int i = 0; i < mesh.num_nodes(); ++i)
        if (can_move[i] != 0 && !normal[i].isZero(0.0))
            found.push_back({i, mesh.points[i], normal[i].normalized()});
    return found;
}

/// A poke up to 40 mm deep, or a pull of 60 mm, that begins as a jump.
Tool random_tool(const std::vector<Place> &all, std::mt19937 &random) {
    const auto number = [&](double least, double most) {
        return std::uniform_real_distribution<double>(least, most)(random);
    };
    const auto &place = all[random() % all.size()];
    Tool tool{
        .kind = random() % 5 < 3 ? ToolKind::probe : ToolKind::pull, .radius = number(0.004, 0.02), .node = place.node};
    const double along = tool.kind == ToolKind::probe ? tool.radius - number(0.0, 0.04) : number(-0.02, 0.06);
    const Vector3 aside(number(-0.015, 0.015), number(-0.015, 0.015), number(-0.015, 0.015));
    tool.target = place.point + along * place.normal + aside;
    return tool;
}

/// The longest step that is offered bears rough hands: nothing leaves all bounds, and what was turned inside out on the
/// way has turned back.
void expect_sound(const std::string &name, const Settings &settings) {
    const auto body = meshes::read_body(std::string(LIVERMARK_SOURCE_DIR "/meshes/") + name + ".toml");
    const auto constrained =
        constrained_facets(load_cases::read_load_case(LIVERMARK_SOURCE_DIR "/load_cases/palpation.toml", body.mesh));
    Scene scene(body, constrained);
    const auto chosen = scene.choose(settings);
    const auto all = places(body.mesh, constrained);
    std::mt19937 random(7);
    double strongest = 0.0;
    for (int i = 0; i < num_handlings; ++i) {
        const auto touched = scene.move(random_tool(all, random), static_cast<int>(touch / chosen.time_step));
        strongest = std::max(strongest, touched.force.norm());
        EXPECT_EQ(scene.move({}, static_cast<int>(pause / chosen.time_step)).restarts, 0);
    }
    EXPECT_GT(strongest, 0.5) << "the hand was a rough one [N]";
    for (double left = at_rest_after; left > 0.0; left -= 0.1)
        scene.move({}, static_cast<int>(0.1 / chosen.time_step));
    const auto rest = scene.move({}, 0);
    EXPECT_GT(rest.smallest_volume, 0.9);
    for (const auto &u : rest.displacement)
        EXPECT_LT(u.norm(), 0.01);
}

Settings patch_with(double poisson_ratio) {
    return {.young_modulus = 5e3, .poisson_ratio = poisson_ratio};
}

TEST(LiveHandling, LeavesTheHealthyLiverSound) {
    expect_sound("liver_healthy", patch_with(0.45));
}

TEST(LiveHandling, LeavesTheLiverWithTumoursSound) {
    expect_sound("liver_tumours", patch_with(0.49));
}

Settings springs_around_nodes(const std::string &name, double poisson_ratio) {
    return {.springs = name, .young_modulus = 5e3, .poisson_ratio = poisson_ratio};
}

TEST(LiveHandling, LeavesNodalSpringsSound) {
    expect_sound("liver_healthy", springs_around_nodes("nodal_springs", 0.45));
}

TEST(LiveHandling, LeavesTheHealthyLiverOfNeoHookeanSpringsSound) {
    expect_sound("liver_healthy", springs_around_nodes("nodal_neo_hookean", 0.45));
}

TEST(LiveHandling, LeavesTheLiverWithTumoursOfNeoHookeanSpringsSound) {
    expect_sound("liver_tumours", springs_around_nodes("nodal_neo_hookean", 0.49));
}

TEST(LiveHandling, LeavesSpringsAloneSound) {
    Settings settings = patch_with(0.25);
    settings.springs = "lloyd";
    settings.keeps_volume = false;
    expect_sound("liver_tumours", settings);
}

} // namespace
} // namespace livermark::live
