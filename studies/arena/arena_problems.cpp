#include "studies/arena/arena_problems.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <set>
#include <utility>

#include "core/mesh/refinement.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "studies/files.hpp"

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

std::vector<std::string> moving_load_cases() {
    const auto folder = support::root_folder() / moving_load_cases_folder;
    std::error_code nobody_cares; // a tree of somebody's own has none
    return std::filesystem::is_directory(folder, nobody_cares) ? support::list_toml(folder)
                                                               : std::vector<std::string>{};
}

bool moves_tool(const std::string &load_case) {
    const auto known = moving_load_cases();
    if (std::ranges::find(known, load_case) != known.end())
        return true;
    std::error_code nobody_cares; // reading says it
    return load_case.ends_with(".toml") && std::filesystem::exists(load_case, nobody_cares) &&
           load_cases::load_case_kind(load_case).is_for("arena");
}

ProblemSet read_arena_problems(const std::vector<std::string> &bodies, const std::string &load_case,
                               const meshes::MaterialOverride &material) {
    const auto file = find_toml_files({load_case}, moving_load_cases_folder, "load case").front();
    return read_moving_problems(bodies, file.string(), material);
}

core::Problem on_arena_mesh(const core::Problem &problem, int mesh) {
    if (mesh == mesh_as_it_is)
        return problem;
    if (mesh == cut_into_eight)
        return core::refine(problem);
    auto parts = core::bisect(*problem.body, longest_edges(problem.body->mesh));
    auto load_case = core::on_parts(problem.load_case, parts);
    return {std::make_shared<const core::Body>(std::move(parts.body)), std::move(load_case)};
}

void refuse_single_components(const core::LoadCase &load_case) {
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_constrained(f) && load_case.value[f].array().isNaN().any())
            throw support::InputError(
                fmt::format("load case {}: '{}' leaves a component of the displacement free, and interactive methods "
                            "constrain whole nodes; give all three components, or choose another load case",
                            load_case.name, load_case.on(f)->place));
}

} // namespace livermark::studies
