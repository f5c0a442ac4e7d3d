#pragma once

#include <filesystem>
#include <string>

#include "core/load_case.hpp"

namespace livermark::load_cases {

/// The one-line title of a load case.
/// @throws core::InputError
std::string load_case_title(const std::filesystem::path &toml_file);

/// Reads a load case and puts it on a mesh.
///
///     title = "what a surgeon or engineer recognises"
///     target_peak_displacement = 0.002        # [m]
///     acceleration = [0.0, 0.0, 0.0]          # [m/s^2], may be left out
///     [[condition]]                           # where: patch = "..." or disc = { patch = "...", radius = r }
///     patch = "posterior"                     # what: displacement = [x, y, z] with "free" components,
///     displacement = [0.0, 0.0, 0.0]          #       traction = [x, y, z] or pressure = p (pushes inwards), [Pa]
///
/// A time-dependent load case starts from the static answer to all this; at t = 0 its tractions and pressures are let
/// go:
///
///     [release]
///     duration = 1.2                          # [s], a whole number of
///     output_interval = 0.004                 # [s]
///     damping_ratio = 0.05                    # at these two frequencies [Hz], less between them and more outside;
///     damping_frequencies = [1.7, 10.0]       # or instead alpha [1/s] and beta [s] of D = alpha M + beta K
///     [[probe]]                               # one or more
///     name = "tip"
///     patch = "left_lobe_tip"                 # the node in the middle of it
///
/// A disc lies around the middle of its patch: the facets whose centroid is within the radius of the facet nearest to
/// the area centroid of the patch, and that face the same way. Their area is not that of the disc, so tractions are
/// multiplied by the ratio of the two: the resultant is the same on every mesh.
/// @throws core::InputError with file, line and remedy: not TOML, unknown keys, a place that no facet is in, two
///         conditions on one facet, prescribed displacements that contradict each other at a node, nothing held, a
///         release without tractions or probes, a probe that is held
core::LoadCase read_load_case(const std::filesystem::path &toml_file, const core::TetraMesh &mesh);

/// The same from text. The file gives the name of the load case, and the place in messages.
core::LoadCase parse_load_case(const std::string &text, const std::filesystem::path &file, const core::TetraMesh &mesh);

} // namespace livermark::load_cases
