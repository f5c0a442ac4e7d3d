#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/problem.hpp"
#include "core/support/toml_input.hpp"

namespace livermark::meshes {

/// Reads density [kg/m^3], young_modulus [Pa], poisson_ratio and, where it is there, source of a table.
/// @param further_key  one that its caller reads
/// @throws support::InputError for a missing or unknown key, or as check_material()
core::Material read_material(const toml::table &table, std::string_view further_key = "source");

/// The one-line title of a body; the name of its file where it gives none.
/// @throws support::InputError
std::string body_title(const std::filesystem::path &toml_file);

/// Elastic constants to use for every region instead of the body's own.
struct MaterialOverride {
    std::optional<double> young_modulus; ///< [Pa]; regions keep their ratio to the first one
    std::optional<double> poisson_ratio;
};

/// Reads a body: its .toml, and the mesh that it names, relative to itself. It needs 'mesh', and of every region of
/// that [regions.<name>] with density, young_modulus and poisson_ratio; what is missing is said at once. Or a mesh
/// alone, whose unit is guessed from its size, whose regions are soft liver, and on which the patches of a liver are
/// looked for: see Body::assumptions. A [[cut]] of the .toml (cutting/cut_reader.hpp) cuts the mesh; materials and
/// patches of the .toml are those before. How the
/// body lies is Body::axes: see body_axes().
/// @throws support::InputError for a fault of either, a region without material or a material without region, a density
///         or Young's modulus that is not positive, a Poisson's ratio outside (-1, 0.5)
core::Body read_body(const std::filesystem::path &file, const MaterialOverride &override_with = {});

/// The sentences of Body::assumptions on how the body lies: its patches and axes, if they were found or set.
/// @throws support::InputError as read_body()
std::vector<std::string> orientation_remarks(const std::filesystem::path &file);
std::vector<std::string> orientation_remarks(core::TetraMesh mesh); ///< of a mesh alone [m]

} // namespace livermark::meshes
