#include "meshes/body_reader.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "core/input_error.hpp"
#include "core/toml_input.hpp"
#include "meshes/msh_reader.hpp"

namespace livermark::meshes {

namespace {

void check_material(const core::Material &material, const std::string &place) {
    if (!(material.density > 0.0))
        throw core::InputError(
            fmt::format("{}: the density is {} kg/m^3; it has to be positive", place, material.density));
    if (!(material.young_modulus > 0.0))
        throw core::InputError(
            fmt::format("{}: Young's modulus is {} Pa; it has to be positive", place, material.young_modulus));
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
        throw core::InputError(fmt::format("{}: Poisson's ratio is {}; it has to lie between -1 and 0.5, both excluded",
                                           place, material.poisson_ratio));
}

core::Material read_material(const toml::table &table) {
    core::refuse_unknown_keys(table, {"density", "young_modulus", "poisson_ratio", "source"});
    core::required_string(table, "source");
    const core::Material material{.density = core::required_number(table, "density"),
                                  .young_modulus = core::required_number(table, "young_modulus"),
                                  .poisson_ratio = core::required_number(table, "poisson_ratio")};
    check_material(material, core::place_of(table));
    return material;
}

void check_patches(const toml::table &body, const core::TetraMesh &mesh) {
    if (!body.contains("patches"))
        return;
    for (const auto &[name, patch] : core::required_table(body, "patches")) {
        if (std::ranges::find(mesh.patch_names, name.str()) == mesh.patch_names.end())
            throw core::InputError(fmt::format("{}: the mesh has no patch '{}'; it has {}", core::place_of(patch),
                                               name.str(), fmt::join(mesh.patch_names, ", ")));
        if (!patch.is_table())
            throw core::InputError(
                fmt::format("{}: patch '{}' has to be a table with a description", core::place_of(patch), name.str()));
        core::refuse_unknown_keys(*patch.as_table(), {"description"});
        core::required_string(*patch.as_table(), "description");
    }
}

std::vector<core::Material> read_materials(const toml::table &body, const core::TetraMesh &mesh) {
    const auto &regions = core::required_table(body, "regions");
    for (const auto &[name, region] : regions)
        if (std::ranges::find(mesh.region_names, name.str()) == mesh.region_names.end())
            throw core::InputError(fmt::format("{}: the mesh has no region '{}'; it has {}", core::place_of(region),
                                               name.str(), fmt::join(mesh.region_names, ", ")));
    std::vector<core::Material> materials;
    for (const auto &name : mesh.region_names) {
        if (!regions.contains(name))
            throw core::InputError(fmt::format("{}: region '{}' of the mesh has no material; add [regions.{}]",
                                               core::place_of(regions), name, name));
        materials.push_back(read_material(core::required_table(regions, name)));
    }
    return materials;
}

void apply(const MaterialOverride &override_with, std::vector<core::Material> &materials) {
    const double first = materials.front().young_modulus;
    for (auto &material : materials) {
        if (override_with.young_modulus)
            material.young_modulus *= *override_with.young_modulus / first;
        if (override_with.poisson_ratio)
            material.poisson_ratio = *override_with.poisson_ratio;
        check_material(material, "--young and --poisson");
    }
}

toml::table read_table(const std::filesystem::path &toml_file) {
    auto table = core::parse_toml(core::read_text(toml_file), toml_file);
    core::refuse_unknown_keys(table, {"title", "mesh", "generator", "regions", "patches"});
    return table;
}

} // namespace

std::string body_title(const std::filesystem::path &toml_file) {
    return core::required_string(read_table(toml_file), "title");
}

core::Body read_body(const std::filesystem::path &toml_file, const MaterialOverride &override_with) {
    const auto table = read_table(toml_file);
    core::required_string(table, "title");
    core::Body body;
    body.name = toml_file.stem().string();
    body.mesh = read_msh(toml_file.parent_path() / core::required_string(table, "mesh"));
    body.materials = read_materials(table, body.mesh);
    check_patches(table, body.mesh);
    apply(override_with, body.materials);
    return body;
}

} // namespace livermark::meshes
