#include "benchmarks/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "benchmarks/limits.hpp"
#include "core/mesh/refinement.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/springs/spring_network.hpp"

namespace livermark::benchmarks {

namespace {

struct Recipe {
    std::string file; ///< stem of the .toml
    int num_refinements;
};

const std::array<std::string, 4> names{"liver_healthy", "liver_tumours", "liver_refined_once", "liver_refined_twice"};
const std::array<Recipe, names.size()> recipes{
    {{"liver_healthy", 0}, {"liver_tumours", 0}, {"liver_healthy", 1}, {"liver_healthy", 2}}};

const Recipe &find_recipe(const std::string &name) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end())
        throw support::InputError(
            fmt::format("there is no body {} for benchmarks; take {}", name, fmt::join(names, ", ")));
    return recipes[found - names.begin()];
}

/// The same body with its nodes in another order.
/// @param order  shape (N), the old number of each new node
core::Body renumbered(core::Body body, std::span<const int> order) {
    auto &mesh = body.mesh;
    std::vector<int> number(order.size());
    std::vector<core::Vector3> points(order.size());
    for (std::size_t i = 0; i < order.size(); ++i) {
        number[order[i]] = static_cast<int>(i);
        points[i] = mesh.points[order[i]];
    }
    mesh.points = std::move(points);
    for (auto &tetrahedron : mesh.tetrahedra)
        for (auto &node : tetrahedron)
            node = number[node];
    for (auto &triangle : mesh.boundary_triangles)
        for (auto &node : triangle)
            node = number[node];
    return body;
}

core::LoadCase constrained_at_back(const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto patch = std::ranges::find(mesh.patch_names, "posterior");
    if (patch == mesh.patch_names.end())
        throw support::InputError(fmt::format("{} has no patch 'posterior' to constrain", body.name));
    std::vector<int> facets;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == patch - mesh.patch_names.begin())
            facets.push_back(f);
    auto load_case = core::with_free_surface({}, mesh);
    load_case.name = "constrained";
    load_case.title = "Constrained at the back, no loads";
    load_case.put({*patch}, facets, core::Vector3::Zero());
    return load_case;
}

constexpr double stretch = 0.01;

double largest_frequency(const Scene &scene) {
    return msm::largest_angular_frequency(scene.springs, scene.problem.body->mesh.points, scene.conditions);
}

} // namespace

std::span<const std::string> body_names() {
    return names;
}

std::shared_ptr<const core::Body> make_body(const std::string &name) {
    const auto &recipe = find_recipe(name);
    auto body = meshes::read_body(support::root_folder() / "meshes" / (recipe.file + ".toml"));
    for (int r = 0; r < recipe.num_refinements; ++r)
        body = core::refine(body);
    if (recipe.num_refinements > 0) {
        const auto edges = core::edge_table(body.mesh.tetrahedra).edges;
        const auto order = msm::reverse_cuthill_mckee(edges, body.mesh.num_nodes());
        body = renumbered(std::move(body), order);
    }
    body.name = name;
    return std::make_shared<const core::Body>(std::move(body));
}

int num_refinements(const std::string &name) {
    return find_recipe(name).num_refinements;
}

Scene make_scene(std::shared_ptr<const core::Body> body) {
    Scene scene;
    scene.problem = {.body = std::move(body), .load_case = {}};
    scene.problem.load_case = constrained_at_back(*scene.problem.body);
    scene.springs = msm::spring_network(*scene.problem.body, msm::all_spring_laws().front());
    scene.conditions = msm::nodal_conditions(scene.problem, scene.springs.node_mass);
    for (const auto &displacement : scene.conditions.displacement)
        scene.is_constrained.push_back(!std::isnan(displacement.x()));
    scene.start = scene.problem.body->mesh.points;
    for (auto &x : scene.start)
        x.x() *= 1.0 + stretch;
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

Scene with_mean_stiffness(Scene scene) {
    auto &stiffness = scene.springs.stiffness;
    const double sum = std::accumulate(stiffness.begin(), stiffness.end(), 0.0);
    stiffness.assign(stiffness.size(), sum / static_cast<double>(stiffness.size()));
    scene.largest_angular_frequency = largest_frequency(scene);
    return scene;
}

double critical_time_step(const Scene &scene, const std::string &integrator) {
    const double highest = scene.largest_angular_frequency;
    return msm::critical_time_step(msm::find_integrator(integrator), {}, highest, highest);
}

} // namespace livermark::benchmarks
