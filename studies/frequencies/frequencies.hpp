#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "results/records/result.hpp"
#include "results/records/springs.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

inline constexpr int most_modes = 1000;

/// Bodies, models and numbers of modes.
struct ModesOptions {
    std::vector<std::string> bodies; ///< names or paths; all that ship if there are none
    std::string load_case;           ///< that gives the constraints; empty: see read_constrained_problems()
    std::vector<std::string> models{models::baseline_name(), models::moving_reference(core::Regime::small).on_mesh,
                                    "lloyd"};
    int count = 20; ///< 1 to most_modes
    meshes::MaterialOverride material;
    std::string output; ///< folder for <body>/modes.<load case>.h5
};

/// Finds the lowest modes of bodies constrained as in a load case, and writes a result file for each body.
/// @param command_line  kept in the files
/// @throws support::InputError for names that there are not, and where a file cannot be written
Found<results::Result> find_modes(const ModesOptions &options, const std::string &command_line,
                                  const ProgressReport &report);

/// By how much prediction and observation may differ, relative.
inline constexpr double largest_difference = 0.02;

/// Which bodies, springs and integrators, and how they are damped.
struct StabilityOptions {
    std::vector<std::string> bodies;
    std::string law = "lloyd";       ///< where no model is named
    std::vector<std::string> models; ///< of the suite, whose springs are taken
    std::string load_case;           ///< that gives the constraints; empty: see read_constrained_problems()
    std::vector<std::string> integrators;
    meshes::MaterialOverride material;
    double damping_ratio = 0.05;                          ///< as load_cases/release.toml
    std::array<double, 2> damping_frequencies{1.7, 10.0}; ///< [Hz]
    std::string output;                                   ///< folder for <body>/stability.<law or model>.h5
    bool no_observed = false;
};

/// Predicts the longest stable step of each integrator from the largest frequency of the springs, observes it in runs
/// unless told not to, and writes a stability file for each body and model.
/// @param command_line  kept in the files
/// @throws support::InputError for names that there are not, for a model without springs, and where a file cannot be
/// written
Found<results::Stability> find_stability(const StabilityOptions &options, const std::string &command_line,
                                         const ProgressReport &report);

/// Whether all that was observed differs from what was predicted by no more than largest_difference.
bool is_as_predicted(const results::Stability &stability);

/// Number of the lowest frequencies that are compared.
inline constexpr int num_compared_modes = 20;

/// Limits of the explicit steps of some springs, and these steps with selective mass scaling of stiff parts (a tumour,
/// say). Symplectic Euler, without damping, on one core.
struct ScaledSteps {
    std::string body, model;
    /// Nodes whose bound of the frequency (msm::nodal_frequency_bounds(), times what makes the largest bound the
    /// largest frequency) asks for one step, two, four, or eight and more in a step that the soft tissue bears.
    std::array<std::size_t, 4> nodes_of_rate{};
    /// Parts of all tetrahedra: those at a node of a stiff part, and those with a neighbour of such a tetrahedron. With
    /// local steps the first at least, for springs around nodes the second, would take several steps in one.
    double tetrahedra_at_stiff_nodes = 0.0, tetrahedra_with_a_ring = 0.0;
    std::size_t num_scaled_nodes = 0;
    double largest_factor = 1.0; ///< of the mass against deformation
    double critical_time_step = 0.0, scaled_critical_time_step = 0.0;
    double critical_time_step_of_rest = 0.0;                      ///< with the stiff parts constrained [s]
    double seconds_per_step = 0.0, scaled_seconds_per_step = 0.0; ///< of processor time, by turns in one run
    /// By how much lower the scaled frequencies are, relative: of the first, and the largest of all that were compared.
    double first_change = 0.0, largest_change = 0.0;

    /// Processor time of a simulated second, with a safe part of the critical step.
    double cost() const;
    double scaled_cost() const;
};

/// Steps of the springs of the arena on each body.
/// @param options  bodies, load case and material
std::vector<ScaledSteps> find_scaled_steps(const StabilityOptions &options, const ProgressReport &report);

} // namespace livermark::studies
