#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/model.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// The longest stable step of an integrator [s]: infinity if every step is stable, 0 if none is.
struct StepLimit {
    double predicted = 0.0;
    double observed = std::numeric_limits<double>::quiet_NaN(); ///< NaN if nobody looked

    /// There is a step to look for.
    bool has_number() const { return predicted > 0.0 && predicted < std::numeric_limits<double>::infinity(); }
    /// Difference of the observed step from the predicted one, relative; NaN if nobody looked.
    double difference() const { return observed / predicted - 1.0; }
};

struct IntegratorLimits {
    std::string integrator;
    StepLimit undamped;
    StepLimit damped;
};

/// The steps that the springs of a body can bear.
struct Stability {
    Provenance provenance;
    std::string body;
    std::string spring_law; ///< empty if the springs are those of a model
    std::string model{};    ///< of the suite; empty if the springs are those of a law
    std::string load_case;  ///< says where the body is constrained
    core::RayleighDamping damping;
    double lowest_frequency = 0.0;        ///< [rad/s]
    double largest_frequency = 0.0;       ///< [rad/s]
    double largest_frequency_bound = 0.0; ///< Gershgorin's [rad/s]
    double element_time_step = 0.0;       ///< mean edge over the speed of sound of the first region [s]
    std::vector<IntegratorLimits> limits; ///< in the order asked for

    /// Name of a spring law or a model.
    const std::string &springs() const { return model.empty() ? spring_law : model; }
};

/// The "Stability files" of results/schema.md; errors as of write_result() and read_result().
void write_stability(const std::filesystem::path &path, const Stability &stability);
Stability read_stability(const std::filesystem::path &path);

/// One row per integrator: the longest stable step without and with damping, predicted and observed [ms], and the
/// difference of the observed from the predicted one [%]. "none" where no step is stable, "any" where every one is,
/// "not observed" where nobody looked or nobody could see.
Layout stability_table(const Stability &stability);

/// Advice on the step: "box, nodal_neo_hookean: take 0.72 ms, 0.8 of the longest stable step of symplectic_euler; with
/// this damping 0.31 ms". Of symplectic Euler, or if it is not there, of the first integrator with a longest step;
/// "take any step" where none has one.
/// @param part  of the longest stable step that is predicted
std::string step_advice(const Stability &stability, double part);

/// Springs fitted to the solutions of another model, and how well.
struct Calibration {
    Provenance provenance;
    std::string body;
    std::string spring_law;      ///< the stiffnesses that it started from
    std::string volume_term;     ///< what was beside the springs
    std::string reference;       ///< the model whose solutions they were fitted to
    std::string constrained;     ///< the patch where the body was constrained
    std::int64_t seed = 0;       ///< of the random loads
    std::int64_t iterations = 0; ///< so far
    double penalty = 0.0;        ///< weight of the change of the stiffnesses
    core::CalibratedSprings springs;
    std::vector<double> start_stiffness; ///< (S) [N/m]
    std::vector<std::uint8_t> held_out;  ///< (L) 1 for a load that had no part in the fit, else 0
    std::vector<double> error_before;    ///< (L) relative L2 error of each load's solution
    std::vector<double> error_after;     ///< (L)
};

/// The "Calibration files" of results/schema.md; errors as of write_result() and read_result(). Those of users are
/// written by python/livermark/calibration/; its test compares the two.
void write_calibration(const std::filesystem::path &path, const Calibration &calibration);
Calibration read_calibration(const std::filesystem::path &path);

} // namespace livermark::results
