#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/model.hpp"
#include "core/relaxation.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "results/records/experiment.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

/// Which forces damp.
enum class DampingForces {
    rayleigh, ///< of mass and stiffness, with one ratio at the lowest and the highest measured frequency
    mass,     ///< alpha M alone
    stiffness ///< beta K alone
};

/// Damping that has the measured ratio at the measured frequency of one ring-down.
/// @param ratio           zeta, > 0
/// @param frequency       there [Hz]
/// @param lowest, highest of all ring-downs [Hz]; both `frequency` where there is one
core::RayleighDamping fitted_damping(DampingForces kind, double ratio, double frequency, double lowest, double highest);

/// A measured ring-down without a model.
/// @param positions  of the markers at rest [m]
/// @param markers    that are compared
results::RingDownResult measured_ring_down(const experiments::RingDown &ring_down,
                                           std::span<const core::Vector3> positions, std::span<const int> markers);

/// A model that rings down. It starts at rest under what holds the body, with that multiplied so that the markers are
/// as near to where they were measured at t = 0 as one factor can bring them.
/// @param measured      its `runs` are not read
/// @param at_frequency  where interactive methods, which damp by the mass alone, have the same ratio [Hz]
/// @return no run of a model that does not move in time
std::vector<results::RingDownRun> ring_down_of_model(const core::Model &model, const experiments::RingDown &ring_down,
                                                     const results::RingDownResult &measured, double edge_length,
                                                     const core::RayleighDamping &damping, double at_frequency,
                                                     std::span<const core::Vector3> positions,
                                                     std::span<const int> markers);

/// The material with which a model is nearest to the measurement, one constant at a time: Young's modulus between a
/// quarter and four times the given one, by its logarithm, and Poisson's ratio from 0.25 to 0.4999, by the logarithm of
/// 1/2 less it, both to a hundredth, by golden sections (Kiefer 1953, Proc. Am. Math. Soc. 4(3)).
/// @param error            of a material [m]; infinite where there is no solution
/// @param modulus_matters  whether the modulus has an effect, as it has none where all that is given are displacements
results::FittedMaterial fit_material(const std::string &model, const core::Material &given, bool modulus_matters,
                                     const std::function<double(const core::Material &)> &error);

/// Options of `livermark experiment`.
struct ExperimentOptions {
    std::vector<std::string> names;    ///< of public experiments, or paths of .toml files; all whose data are there
    std::string data;                  ///< folder of public data that is looked in first; see data_folders()
    std::vector<std::string> models;   ///< beside the reference; all that take part if there are none
    bool with_methods = false;         ///< also interactive methods, where no model is named
    std::optional<double> edge_length; ///< in place of that of the experiment [m]
    bool refines_reference = true;     ///< solves the reference also with each tetrahedron cut into eight
    bool rings_down = true;            ///< also lets go where that was measured
    bool fits_materials = false;       ///< also finds the material with which each model is nearest to the markers
    DampingForces damping = DampingForces::rayleigh;
    std::string output; ///< folder for <name>.h5
};

struct ExperimentResults {
    std::vector<results::ExperimentResult> records;
    std::vector<std::string> files; ///< of each
    std::vector<std::string> notes; ///< what a user should know, a sentence each
};

/// Puts models beside one experiment.
/// @throws support::InputError for a model that is not known, or an edge length of a body that has a mesh of its own
results::ExperimentResult evaluate_experiment(const experiments::Experiment &experiment,
                                              const ExperimentOptions &options, const std::string &command_line,
                                              const ProgressReport &report);

/// Reads experiments, puts models beside them, and writes <output>/<name>.h5.
/// @throws support::InputError for bad input, where data are not there, and where a file cannot be written
ExperimentResults run_experiments(const ExperimentOptions &options, const std::string &command_line,
                                  const ProgressReport &report);

} // namespace livermark::studies
