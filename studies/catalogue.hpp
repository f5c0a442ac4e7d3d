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
inline constexpr const char *touching_load_cases_folder = "load_cases/touching"; ///< that run where they are named

/// A .toml file, or of a body also a mesh file, for each name or path that was asked for; all that ship if none was.
/// Among load cases those of touching_load_cases_folder are known by name too.
/// @param folder  one of these
/// @param word    "body" or "load case", for messages
/// @throws support::InputError for a name that does not ship, with the nearest one that does; for a load case of
/// another
///   folder with the command that takes it
std::vector<std::filesystem::path> find_toml_files(const std::vector<std::string> &wanted, const char *folder,
                                                   const char *word);

} // namespace livermark::studies
