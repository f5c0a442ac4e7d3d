#include "benchmarks/bodies.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

#include "benchmarks/kernels/node_order.hpp"
#include "core/mesh/refinement.hpp"
#include "meshes/io/body_reader.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "support/input_error.hpp"
#include "support/root_folder.hpp"

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

core::LoadCase constrained(const core::Body &body) {
    const auto &mesh = body.mesh;
    const auto patch = std::ranges::find(mesh.patch_names, "posterior");
    if (patch == mesh.patch_names.end())
        throw support::InputError(fmt::format("{} has no patch 'posterior' to constrain", body.name));
    std::vector<int> held;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == patch - mesh.patch_names.begin())
            held.push_back(f);
    auto load_case = core::with_free_surface({}, mesh);
    load_case.name = "held";
    load_case.title = "Constrained at the back, no loads";
    load_case.put({*patch}, held, core::Vector3::Zero());
    return load_case;
}

} // namespace livermark::benchmarks
