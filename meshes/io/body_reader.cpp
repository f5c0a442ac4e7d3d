#include "meshes/io/body_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/anatomy/liver_patches.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/io/mesh_checks.hpp"
#include "meshes/io/mesh_files.hpp"
#include "meshes/io/vessel_files.hpp"

namespace livermark::meshes {

namespace {

/// Beyond them nothing is known, and squares of frequencies leave double precision.
constexpr double heaviest = 1e5;  // [kg/m^3] metals have 2e4
constexpr double stiffest = 1e13; // [Pa] diamond has 1e12
constexpr double lightest = 1e-6, softest = 1e-6;

/// Refuses what no material has.
/// @param place  where it is from, for messages
/// @throws support::InputError for a density or Young's modulus that is not positive, a Poisson's ratio outside (-1,
/// 0.5)
///   or too close to 0.5
void check_material(const core::Material &material, const std::string &place) {
    if (!(material.density > 0.0))
        throw support::InputError("{}: the density is {} kg/m^3; it has to be positive", place, material.density);
    if (!(material.young_modulus > 0.0))
        throw support::InputError("{}: Young's modulus is {} Pa; it has to be positive", place, material.young_modulus);
    if (!(material.density >= lightest && material.density <= heaviest))
        throw support::InputError(
            "{}: the density is {:g} kg/m^3, which no matter has; give one from {:g} to {:g} kg/m^3", place,
            material.density, lightest, heaviest);
    if (!(material.young_modulus >= softest && material.young_modulus <= stiffest))
        throw support::InputError("{}: Young's modulus is {:g} Pa, which no matter has; give one from {:g} to {:g} Pa",
                                  place, material.young_modulus, softest, stiffest);
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
        throw support::InputError("{}: Poisson's ratio is {}; it has to lie between -1 and 0.5, both excluded", place,
                                  material.poisson_ratio);
    if (material.poisson_ratio > core::largest_poisson_ratio)
        throw support::InputError("{}: Poisson's ratio is {:.12g}, so close to 0.5 that its equations have no solution "
                                  "in double precision; take {} at most",
                                  place, material.poisson_ratio, core::largest_poisson_ratio);
}

/// @throws support::InputError for a key that no material has
void refuse_unknown_material_keys(const toml::table &table, std::string_view further_key = "source") {
    support::refuse_unknown_keys(table, {"density", "young_modulus", "poisson_ratio", "source", further_key});
}

} // namespace

core::Material read_material(const toml::table &table, std::string_view further_key) {
    refuse_unknown_material_keys(table, further_key);
    if (table.contains("source"))
        support::required_string(table, "source");
    core::Material material{.density = support::required_number(table, "density"),
                            .young_modulus = support::required_number(table, "young_modulus"),
                            .poisson_ratio = support::required_number(table, "poisson_ratio")};
    check_material(material, support::place_of(table));
    return material;
}

namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 3> material_keys{
    {{"density", "kg/m^3"}, {"young_modulus", "Pa"}, {"poisson_ratio", "-"}}};

/// Says all at once that materials lack; one thing alone is refused by who reads it.
void refuse_missing_materials(const toml::table &body, const core::TetraMesh &mesh) {
    const auto *regions = body["regions"].as_table();
    std::vector<std::string> missing;
    for (const auto &name : mesh.region_names) {
        const auto *region = regions ? (*regions)[name].as_table() : nullptr;
        if (region)
            refuse_unknown_material_keys(*region);
        if (!region)
            missing.push_back(fmt::format("[regions.{}] with density [kg/m^3], young_modulus [Pa] and poisson_ratio",
                                          support::shown(name)));
        else
            for (const auto &[key, unit] : material_keys)
                if (!region->contains(key))
                    missing.push_back(fmt::format("'{}' [{}] in [regions.{}]", key, unit, support::shown(name)));
    }
    if (missing.size() > 1 || !regions)
        support::refuse(body, "missing is {}; add it", fmt::join(missing, "; "));
}

void check_patches(const toml::table &body, const core::TetraMesh &mesh) {
    if (!body.contains("patches"))
        return;
    for (const auto &[name, patch] : support::required_table(body, "patches")) {
        if (const auto known = core::patches_of(mesh); std::ranges::find(known, name.str()) == known.end())
            support::refuse(patch, "the mesh has no patch '{}'; it has {}", name.str(), fmt::join(known, ", "));
        if (!patch.is_table())
            support::refuse(patch, "patch '{}' has to be a table with a description", name.str());
        support::refuse_unknown_keys(*patch.as_table(), {"description"});
        support::required_string(*patch.as_table(), "description");
    }
}

std::vector<core::Material> read_materials(const toml::table &body, const core::TetraMesh &mesh) {
    const auto &regions = support::required_table(body, "regions");
    for (const auto &[name, region] : regions)
        if (std::ranges::find(mesh.region_names, name.str()) == mesh.region_names.end())
            support::refuse(region, "the mesh has no region '{}'; it has {}", name.str(),
                            fmt::join(mesh.region_names, ", "));
    std::vector<core::Material> materials;
    for (const auto &name : mesh.region_names) {
        if (!regions.contains(name))
            support::refuse(regions, "region '{}' of the mesh has no material; add [regions.{}]", name, name);
        materials.push_back(read_material(support::required_table(regions, name)));
    }
    return materials;
}

/// Beyond them nothing is a capsule: Glisson's has 10 to 100 um, and metal foil is thinner.
constexpr double thinnest = 1e-9, thickest = 0.01; // [m]

std::optional<core::Capsule> read_capsule(const toml::table &body) {
    if (!body.contains("capsule"))
        return std::nullopt;
    const auto &table = support::required_table(body, "capsule");
    support::refuse_unknown_keys(table, {"thickness", "young_modulus", "source"});
    if (table.contains("source"))
        support::required_string(table, "source");
    const core::Capsule capsule{.thickness = support::required_number(table, "thickness"),
                                .young_modulus = support::required_number(table, "young_modulus")};
    if (!(capsule.thickness >= thinnest && capsule.thickness <= thickest))
        support::refuse(table, "'thickness' is {:g} m; give that of a membrane, from {:g} to {:g} m", capsule.thickness,
                        thinnest, thickest);
    if (!(capsule.young_modulus >= softest && capsule.young_modulus <= stiffest))
        support::refuse(table, "'young_modulus' is {:g} Pa; give one from {:g} to {:g} Pa", capsule.young_modulus,
                        softest, stiffest);
    return capsule;
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
    auto table = support::parse_toml(support::read_text(toml_file), toml_file);
    support::refuse_unknown_keys(table, {"title", "mesh", "unit", "axes", "find_patches", "generator", "regions",
                                         "patches", "image", "cut", "capsule", "vessels", "stiffness_map"});
    return table;
}

void scale(core::TetraMesh &mesh, double factor) {
    if (factor != 1.0)
        for (auto &point : mesh.points)
            point *= factor;
}

/// Remarks on the image that a body was made of; the rest of [image] is for people.
void append_remarks(const toml::table &image, std::vector<std::string> &assumptions) {
    const auto spacing = support::required_vector(image, "spacing");
    assumptions.push_back(fmt::format("made of the segmentation {} with voxels of {:.3g} x {:.3g} x {:.3g} mm",
                                      support::required_string(image, "name"), 1e3 * spacing.x(), 1e3 * spacing.y(),
                                      1e3 * spacing.z()));
    if (const auto *remarks = image.get("remarks"); remarks && !(remarks->is_array() && remarks->as_array()->empty()))
        std::ranges::move(support::required_strings(image, "remarks"), std::back_inserter(assumptions));
}

/// Whether the file of a mesh says how the patient lies, by the remarks of its reader.
bool is_lps_by_header(const std::vector<std::string> &remarks) {
    return std::ranges::any_of(remarks, [](const std::string &remark) {
        return remark.starts_with("it says that it is in ") && remark.ends_with("LPS");
    });
}

/// Gives a body its patches and axes; finds the patches where that is asked for.
/// @return remarks on both
std::vector<std::string> orient(core::Body &body, bool has_to_find, const SaidAxes &said) {
    std::vector<std::string> remarks;
    const auto found = has_to_find ? find_anatomical_patches(body.mesh, said.from_lps) : std::nullopt;
    if (found) {
        remarks.push_back(found->remark);
        body.patch_confidence = found->confidence;
    }
    body.axes = body_axes(body.mesh, found, said, remarks);
    std::ranges::copy(remarks, std::back_inserter(body.assumptions));
    return remarks;
}

/// Young's modulus of each tetrahedron [Pa] of a file, a line each; nan where nothing is known.
std::vector<double> read_moduli(const std::filesystem::path &file, std::size_t num_tetrahedra) {
    std::istringstream text(support::read_text(file));
    std::vector<double> moduli;
    std::size_t number = 0;
    for (std::string line; std::getline(text, line);) {
        ++number;
        if (line.ends_with('\r'))
            line.pop_back();
        if (line.empty() || line.starts_with('#'))
            continue;
        char *end = nullptr;
        const double modulus = std::strtod(line.c_str(), &end);
        if (*end != '\0' || !(std::isnan(modulus) || (modulus > 0.0 && std::isfinite(modulus))))
            throw support::InputError("{}: line {} is '{}'; give a Young's modulus above 0 Pa, or nan where it is not "
                                      "known",
                                      file.string(), number, support::shown(line));
        moduli.push_back(modulus);
    }
    if (moduli.size() != num_tetrahedra)
        throw support::InputError(
            "{}: it has {} values, and the mesh {} tetrahedra; give one for each, in the order of "
            "the mesh, or make it again with `livermark mesh stiffness`",
            file.string(), moduli.size(), num_tetrahedra);
    return moduli;
}

/// Median Young's modulus that is believed [Pa].
constexpr double softest_tissue = 100.0, stiffest_tissue = 1e6;

/// Gives each tetrahedron a modulus of its own, and each region the mean of its own. What has none gets that of its
/// region as it was.
void apply_stiffness_map(const std::filesystem::path &body_file, const toml::table &table, core::Body &body) {
    support::refuse_unknown_keys(table, {"file", "source"});
    const auto file = body_file.parent_path() / support::required_string(table, "file");
    auto modulus = read_moduli(file, body.mesh.tetrahedra.size());
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    std::vector<double> known;
    std::ranges::copy_if(modulus, std::back_inserter(known), [](double value) { return !std::isnan(value); });
    if (known.empty())
        throw support::InputError("{}: no tetrahedron has a modulus; leave [stiffness_map] out", file.string());
    std::ranges::nth_element(known, known.begin() + std::ssize(known) / 2);
    if (const double median = known[known.size() / 2]; !(median >= softest_tissue && median <= stiffest_tissue))
        throw support::InputError(
            "{}: half of the moduli are below {:.3g} Pa, which is no soft tissue; give them in Pa", file.string(),
            median);
    const auto num_regions = body.materials.size();
    std::vector<double> volume(num_regions, 0.0), sum(num_regions, 0.0);
    double filled = 0.0, whole = 0.0;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const int region = body.mesh.region[t];
        if (std::isnan(modulus[t])) {
            modulus[t] = body.materials[region].young_modulus;
            filled += volumes[t];
        }
        whole += volumes[t];
        volume[region] += volumes[t];
        sum[region] += volumes[t] * modulus[t];
    }
    for (std::size_t r = 0; r < num_regions; ++r)
        if (volume[r] > 0.0)
            body.materials[r].young_modulus = sum[r] / volume[r];
    for (std::size_t t = 0; t < volumes.size(); ++t)
        body.modulus_factor.push_back(modulus[t] / body.materials[body.mesh.region[t]].young_modulus);
    const auto [least, largest] = std::ranges::minmax(modulus);
    body.assumptions.push_back(
        fmt::format("Young's modulus is that of {}, {:.0f} to {:.0f} Pa{}", file.filename().string(), least, largest,
                    filled > 0.0 ? fmt::format("; {:.2g} % of the body has none there and gets that of "
                                               "its region",
                                               100.0 * filled / whole)
                                 : ""));
}

/// @param orientation  gets the sentences on patches and axes, which are in its assumptions too
core::Body body_of_table(const std::filesystem::path &file, std::vector<std::string> &orientation) {
    const auto table = read_table(file);
    if (table.contains("title"))
        support::required_string(table, "title");
    core::Body body;
    body.mesh = read_mesh(file.parent_path() / support::required_string(table, "mesh"), body.assumptions);
    auto axes = read_axes(table);
    axes.is_lps_by_header = axes.is_lps_by_header || is_lps_by_header(body.assumptions);
    scale(body.mesh, support::metres_per_unit(table));
    if (table.contains("image"))
        append_remarks(support::required_table(table, "image"), body.assumptions);
    std::ranges::move(core::doubts_about_unit(body.mesh.points), std::back_inserter(body.assumptions));
    const bool is_liver = support::optional_flag(table, "find_patches");
    if (is_liver)
        std::ranges::move(core::doubts_about_liver(body.mesh), std::back_inserter(body.assumptions));
    orientation = orient(body, is_liver, axes);
    if (const auto *regions = table.get("regions"); !regions || regions->is_table())
        refuse_missing_materials(table, body.mesh);
    body.materials = read_materials(table, body.mesh);
    body.capsule = read_capsule(table);
    if (body.capsule)
        body.assumptions.push_back(fmt::format("a capsule of {:.3g} um and {:.3g} MPa covers it",
                                               1e6 * body.capsule->thickness, 1e-6 * body.capsule->young_modulus));
    if (table.contains("stiffness_map"))
        apply_stiffness_map(file, support::required_table(table, "stiffness_map"), body);
    if (table.contains("vessels"))
        read_vessels(file, support::required_table(table, "vessels"), support::metres_per_unit(table), body);
    check_patches(table, body.mesh);
    return cut(std::move(body), read_cuts(table));
}

/// A mesh that comes alone: all that is missing is assumed, and said.
core::Body body_of_mesh(const std::filesystem::path &file, std::vector<std::string> &orientation) {
    core::Body body;
    body.mesh = read_mesh(file, body.assumptions);
    const bool says_axes = is_lps_by_header(body.assumptions);
    const auto unit = guess_unit(body.mesh.points, mesh_figures(body.mesh).volume, file.string());
    scale(body.mesh, unit.metres);
    std::ranges::move(core::doubts_about_lesions(body.mesh),
                      std::back_inserter(body.assumptions)); // the volume is said
    body.assumptions.push_back(
        fmt::format("coordinates are assumed to be in {}, {}; 'unit' in a body .toml sets it", unit.unit, unit.remark));
    // As the parenchyma of the livers that ship.
    body.materials.assign(body.mesh.region_names.size(), {1060.0, 5000.0, 0.45});
    const auto num_regions = body.mesh.region_names.size();
    body.assumptions.push_back(
        fmt::format("{} assumed to have 1060 kg/m^3, 5000 Pa and Poisson's ratio 0.45; a body .toml sets the material "
                    "of each region",
                    num_regions == 1 ? "the body is" : fmt::format("all {} regions are", num_regions)));
    orientation = orient(body, true, {.is_lps_by_header = says_axes});
    return body;
}

core::Body body_of_file(const std::filesystem::path &file, std::vector<std::string> &orientation) {
    return support::file_ending(file) == ".toml" ? body_of_table(file, orientation) : body_of_mesh(file, orientation);
}

} // namespace

std::string body_title(const std::filesystem::path &toml_file) {
    const auto table = read_table(toml_file);
    return table.contains("title") ? support::required_string(table, "title") : toml_file.stem().string();
}

std::vector<std::string> orientation_remarks(const std::filesystem::path &file) {
    std::vector<std::string> orientation;
    body_of_file(file, orientation);
    return orientation;
}

std::vector<std::string> orientation_remarks(core::TetraMesh mesh) {
    core::Body body{.name = {}, .mesh = std::move(mesh), .materials = {}};
    return orient(body, true, {});
}

core::Body read_body(const std::filesystem::path &file, const MaterialOverride &override_with) {
    std::vector<std::string> orientation;
    auto body = body_of_file(file, orientation);
    body.name = file.stem().string();
    apply(override_with, body.materials);
    std::ranges::move(core::doubts_about_materials(body.materials, body.mesh.region_names),
                      std::back_inserter(body.assumptions));
    return body;
}

} // namespace livermark::meshes
