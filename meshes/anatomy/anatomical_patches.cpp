#include "meshes/anatomy/anatomical_patches.hpp"

#include <algorithm>
#include <fmt/ranges.h>
#include <map>
#include <numbers>
#include <string_view>

#include "core/mesh/patches.hpp"
#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/anatomy/liver_registration.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

namespace {

/// Below this another orientation fits about as well (docs/studies/segmentation.md).
constexpr double doubtful = 0.06;

/// Patches that no facet has any more lose their names.
void drop_empty_patches(core::TetraMesh &mesh) {
    std::vector<int> new_number(mesh.patch_names.size(), -1);
    std::vector<std::string> names;
    for (std::size_t patch = 0; patch < mesh.patch_names.size(); ++patch)
        if (std::ranges::find(mesh.boundary_patch, static_cast<int>(patch)) != mesh.boundary_patch.end()) {
            new_number[patch] = static_cast<int>(names.size());
            names.push_back(mesh.patch_names[patch]);
        }
    for (int &patch : mesh.boundary_patch)
        patch = new_number[patch];
    mesh.patch_names = std::move(names);
}

/// Whether a name is one that meshes get where nobody has named a part of the surface.
bool says_nothing(std::string_view name) {
    constexpr std::string_view numbered = "patch_";
    const auto number = name.substr(std::min(name.size(), numbered.size()));
    return name == "surface" || name == "unnamed" ||
           (name.starts_with(numbered) && !number.empty() &&
            number.find_first_not_of("0123456789") == std::string_view::npos);
}

std::string quoted(const std::vector<std::string> &names) {
    return fmt::format("'{}'", fmt::join(names, "', '"));
}

} // namespace

bool FoundPatches::is_doubtful() const {
    return confidence < doubtful;
}

std::optional<FoundPatches> find_anatomical_patches(core::TetraMesh &mesh,
                                                    const std::optional<Eigen::Matrix3d> &from_lps) {
    const auto fit = fit_liver(mesh, from_lps);
    auto liver = mesh;
    assign_liver_patches(liver, fit);
    const auto of_file = mesh.patch_names;
    const auto is_there = [](const std::vector<std::string> &names, const std::string &name) {
        return std::ranges::find(names, name) != names.end();
    };
    std::map<std::string, int> number; // of what is new
    std::vector<double> area(liver.patch_names.size(), 0.0);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f) {
        const int found = liver.boundary_patch[f];
        const auto &own = of_file[mesh.boundary_patch[f]], &name = liver.patch_names[found];
        if (own == wound_patch || is_there(liver.patch_names, own) || is_there(of_file, name))
            continue;
        const auto [entry, is_new] =
            number.emplace(says_nothing(own) ? name : fmt::format("{}{}{}", own, core::patch_joint, name),
                           std::ssize(mesh.patch_names));
        if (is_new)
            mesh.patch_names.push_back(entry->first);
        mesh.boundary_patch[f] = entry->second;
        area[found] += core::area_vector(mesh, f).norm();
    }
    drop_empty_patches(mesh);
    std::vector<std::string> kept, clashes;
    for (const auto &name : of_file)
        if (is_there(liver.patch_names, name))
            clashes.push_back(name);
        else if (!says_nothing(name))
            kept.push_back(name);
    const auto on_own = (kept.empty() ? "" : fmt::format("; {} of the mesh stand beside them", quoted(kept))) +
                        (clashes.empty() ? ""
                                         : fmt::format("; {} are as the mesh has them, because it has patches of these "
                                                       "names itself",
                                                       quoted(clashes)));
    constexpr double square_centimetres = 1e4, millimetres = 1e3;
    std::vector<std::string> places;
    for (std::size_t patch = 0; patch < area.size(); ++patch)
        if (area[patch] > 0.0)
            places.push_back(fmt::format("{} {:.0f} cm^2", liver.patch_names[patch], square_centimetres * area[patch]));
    if (places.empty())
        return std::nullopt;
    FoundPatches found{fit.confidence(), {}, fit.from_lps()};
    found.remark =
        fmt::format("patches are those of the liver that ships, deformed onto this body; it is {:.1f} mm off, "
                    "and {:.1f} mm in the next best orientation, so the confidence is {:.2f}{}: {}{}",
                    millimetres * fit.distance, millimetres * fit.next_distance, found.confidence,
                    found.is_doubtful() ? ", which is low: look at them with `livermark mesh check --picture`" : "",
                    fmt::join(places, ", "), on_own);
    return found;
}

} // namespace livermark::meshes
