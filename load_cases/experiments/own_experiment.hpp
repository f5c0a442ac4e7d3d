#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "load_cases/experiments/experiment.hpp"

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
///     [state.ring_down]                          # how the body rang after it was let go; may be left out
///     motions = ["a.csv", "b.csv"]               # one or more of the same, see read_motion()
///     held = { patch = "z_max", force = [0.1, 0.0, 0.0] } # what held it: a condition of a load case with a force or a
///                                                # traction about as large
///     added_mass = { mass = 0.05, low = [-0.01, -0.01, 0.07], high = [0.01, 0.01, 0.08] } # of what hangs at it, in
///                                                # the tetrahedra whose middle is in this box; may be left out
///     damping_from = true                        # damping is fitted on this one; on the first if it stands nowhere
///
/// The regime of a state is "large" if it says nothing.
/// @param say  is told how many tetrahedra are expected before any is made; may be empty
/// @throws support::InputError with file, line and remedy
Experiment read_experiment(const std::filesystem::path &toml_file,
                           const std::function<void(const std::string &)> &say = {});

} // namespace livermark::experiments
