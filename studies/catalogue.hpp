#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace livermark::studies {

/// Where bodies and load cases stand below the root.
inline constexpr const char *bodies_folder = "meshes";
inline constexpr const char *load_cases_folder = "load_cases";
inline constexpr const char *moving_load_cases_folder = "load_cases/moving";  ///< in which a tool moves
inline constexpr const char *needle_load_cases_folder = "load_cases/needles"; ///< in which a needle is driven in
inline constexpr const char *slow_load_cases_folder = "load_cases/slow";      ///< in which time passes in the material

/// A .toml file, or of a body also a mesh file, for each name or path that was asked for; all that ship if none was.
/// @param folder  one of these
/// @param word    "body" or "load case", for messages
/// @throws support::InputError for a name that does not ship, with the nearest one that does
std::vector<std::filesystem::path> find_toml_files(const std::vector<std::string> &wanted, const char *folder,
                                                   const char *word);

} // namespace livermark::studies
