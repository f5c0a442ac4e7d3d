#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/support/toml_input.hpp"
#include "meshes/cutting/cut.hpp"

namespace livermark::meshes {

/// Reads the cuts of a body or of a load case, in the order in which they are made at rest:
///
///     [[cut]]
///     region = "tumour_1"        # one of: a region with a
///     margin = 0.005             # [m] around it, 0 if it is left out
///     half_space = { point = [0.02, 0.0, 0.0], normal = [1.0, 0.0, 0.0] }    # what the normal points to goes
///     blade = { corners = [[...], [...], [...], [...]], thickness = 0.002 }  # the sweep of a straight blade [m];
///                                # a thickness of 0, as without it, parts
///     way = "facets"             # along whole tetrahedra, or "exact"
///     small_pieces = "refuse"    # or "remove"; all but the largest that the cut leaves
///
/// @param table  of which [[cut]] may be a key
/// @return empty if there is none
/// @throws support::InputError with file, line and remedy
std::vector<Cut> read_cuts(const toml::table &table);

/// The cuts of a load case, whose lengths are in its 'unit'.
/// @throws support::InputError if it cannot be read
std::vector<Cut> cuts_of_file(const std::filesystem::path &toml_file);

/// A cut as somebody writes it: one of the three tools.
struct CutWords {
    std::optional<std::string> region{};
    std::optional<double> margin{};      ///< [m]
    std::vector<double> half_space{};    ///< point and normal, six numbers [m]
    std::vector<double> blade{};         ///< four corners, twelve numbers [m]
    std::optional<double> thickness{};   ///< of the blade [m]
    std::string way = "facets";          ///< or "exact"
    std::string small_pieces = "refuse"; ///< or "remove" or "keep"
};

/// @param place  where the words stand, for messages
/// @throws support::InputError for no tool or several, wrong words, and numbers that are too many or too few
Cut cut_of(const CutWords &words, const std::string &place);

/// Writes <stem>.msh, and <stem>.toml beside it with the materials that the body has; small pieces that are kept as
/// <stem>_piece_2.msh and .toml and so on.
/// @param mesh_file  ends in .msh
/// @param command    that makes it again
/// @return the .toml files, that of the body first
/// @throws support::InputError if the place cannot be written to, or the name has another ending
std::vector<std::filesystem::path> write_cut_body(const std::filesystem::path &mesh_file, const CutBody &cut,
                                                  const std::string &command);

} // namespace livermark::meshes
