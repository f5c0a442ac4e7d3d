#pragma once

#include <filesystem>

#include "experiments/experiment.hpp"

namespace livermark::experiments {

/// Reads an experiment of a .toml file and a table of markers beside it (see read_markers()):
///
///     title = "A cylinder of gelatine under its own weight"
///     source = "who measured it, and where the data are"
///     assumptions = ["the base does not slide"]  # sentences on what was not measured; may be left out
///     markers = "markers.csv"
///     unit = "mm"                                # of the markers: "m", "cm", "mm" or a number of metres
///     noise = 0.0003                             # [m], root mean square length of the error of the displacement of a
///                                                # marker; may be left out
///     fit_degree = 2                             # of the polynomials that driven places move by; may be left out
///     [body]                                     # one of
///     box = { size = [0.08, 0.08, 0.06], edge_length = 0.01, corner = [0.0, 0.0, 0.0] }
///     cylinder = { radius = 0.03, height = 0.08, edge_length = 0.008, base = [0.0, 0.0, 0.0] } # along z
///     file = "body.toml"                         # or a mesh, as livermark run takes them; has its own materials
///     [material]                                 # of a box or cylinder
///     density = 1000.0                           # [kg/m^3]
///     young_modulus = 5000.0                     # [Pa]
///     poisson_ratio = 0.49
///     source = "where they are from"
///     [[state]]                                  # one or more, with the keys of a load case and
///     name = "standing"                          # the state of the table of markers
///     acceleration = [0.0, 0.0, -9.81]
///     [[state.condition]]
///     patch = "z_min"
///     displacement = [0.0, 0.0, 0.0]
///
/// The regime of a state is "large" if it says nothing.
/// @throws support::InputError with file, line and remedy
Experiment read_experiment(const std::filesystem::path &toml_file);

} // namespace livermark::experiments
