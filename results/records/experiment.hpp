#pragma once

#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "core/relaxation.hpp"
#include "core/solution.hpp"
#include "results/records/result.hpp"
#include "results/tables/table_layout.hpp"

namespace livermark::results {

/// Number of swings of a ring-down that are compared.
inline constexpr int num_swings = 4;

/// A model that rings down, on one mesh. What was measured of the real body is measured of the model in the same way.
struct RingDownRun {
    std::string model;
    int tetrahedra = 0; ///< of the mesh
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message{};                                           ///< why it is not ok
    std::string integrator{};                                        ///< the rule that took the steps
    core::RayleighDamping damping{};                                 ///< that the model was given
    double time_step = std::numeric_limits<double>::quiet_NaN();     ///< [s]
    double frequency = std::numeric_limits<double>::quiet_NaN();     ///< [Hz]
    double damping_ratio = std::numeric_limits<double>::quiet_NaN(); ///< of the decay
    std::vector<double> swings{};                                    ///< (num_swings) [m]
    double swing_error = std::numeric_limits<double>::quiet_NaN();   ///< root mean square, over the swings [m]
    double error = std::numeric_limits<double>::quiet_NaN();         ///< of markers, over records and markers [m]
    double start_error = std::numeric_limits<double>::quiet_NaN();   ///< of markers at t = 0 [m]
    double seconds = 0.0;                                            ///< of everything
    std::vector<core::Vector3> displacement{};                       ///< (J, K) of the markers [m]
};

/// The ring-down of a body, as it was measured, and what can be said without a model. Errors are root mean square
/// distances over records and markers [m].
struct RingDownResult {
    std::string state;
    double interval = 0.0;                               ///< between records [s]
    std::vector<core::Vector3> displacement;             ///< (J, K) mean of all repeats [m]
    double frequency = 0.0, frequency_uncertainty = 0.0; ///< [Hz]
    double damping_ratio = 0.0, damping_uncertainty = 0.0;
    std::vector<double> swings; ///< (num_swings) [m]
    double swing_noise = 0.0;   ///< root mean square of half of how far repeats differ; 0 of one [m]
    double noise = 0.0;         ///< half of how far repeats differ; 0 of one
    double no_motion = 0.0;     ///< error of a body that stays at the mean place of each marker
    double rigid_motion = 0.0;  ///< of the rigid motion that fits best in each record; NaN of fewer than three markers
    std::vector<RingDownRun> runs;

    int num_records(std::size_t num_markers) const { return static_cast<int>(displacement.size() / num_markers); }
};

/// Root of the mean squared distance between two sets of displacements.
double root_mean_square_distance(const std::vector<core::Vector3> &a, const std::vector<core::Vector3> &b);

/// A body in one state, as it was measured, and what can be said of it without a model. Errors are root mean square
/// distances over the markers that are compared and were seen [m].
struct ExperimentState {
    std::string name;
    std::vector<core::Vector3> displacement{}; ///< (K) measured [m]; NaN of a marker that was not seen
    double noise = 0.0;                        ///< of the measurement [m]; 0 where nobody says
    double no_motion = 0.0;                    ///< error of a body that does not move
    double rigid_motion = 0.0;                 ///< of the rigid motion that fits best; NaN of fewer than three markers
    /// Error of the straight line between two places that markers drive; NaN where there are not two.
    double straight_line = std::numeric_limits<double>::quiet_NaN();
    double fit_residual = 0.0; ///< root mean square distance between driving markers and the places that they drive
    /// Root mean square difference between the reference on the mesh and on the refined one, over the markers that are
    /// compared; NaN where one of them has no solution.
    double reference_uncertainty = std::numeric_limits<double>::quiet_NaN();
    std::vector<core::Vector3> deformed{}; ///< (N) displacement of the body's nodes in the refined reference [m]
    bool operator==(const ExperimentState &) const = default;
};

/// A model in one state on one mesh.
struct ExperimentRun {
    std::string model;
    int state = 0;      ///< index
    int tetrahedra = 0; ///< of the mesh
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message{};                     ///< why it is not ok
    double error = 0.0, worst_error = 0.0;     ///< root mean square, and largest distance from the measurement [m]
    double seconds = 0.0;                      ///< set-up and solving
    std::vector<core::Vector3> displacement{}; ///< (K) of the markers [m]
    bool operator==(const ExperimentRun &) const = default;
};

/// All that is known about models beside one experiment: the content of one experiment file.
struct ExperimentResult {
    Provenance provenance;
    std::string name, title, source;
    std::vector<std::string> assumptions;
    std::string reference;                      ///< the model whose solution is also found on the refined mesh
    std::vector<std::string> markers, drives;   ///< (K) names, and the patch that a marker drives or nothing
    std::vector<core::Vector3> positions;       ///< (K) at rest [m]
    std::vector<ExperimentState> states;        ///< (S)
    std::vector<ExperimentRun> runs;            ///< (R) model by model, those of the refined reference last
    std::vector<core::Vector3> points;          ///< (N) of the mesh [m]
    std::vector<std::array<int, 3>> boundary{}; ///< (T) its boundary triangles
    std::vector<RingDownResult> ring_downs{};   ///< none where nothing was let go
    std::string damping_from{};                 ///< the state of that on which damping is fitted

    bool is_compared(std::size_t marker) const { return drives[marker].empty(); }
};

/// Root mean square and largest distance between displacements and the measured ones, over the markers that are
/// compared and were seen.
struct MarkerError {
    double root_mean_square = 0.0, worst = 0.0; ///< [m]
};
MarkerError marker_error(const ExperimentResult &result, const std::vector<core::Vector3> &displacement,
                         const std::vector<core::Vector3> &measured);

/// The "Experiment files" of results/schema.md; errors as of write_result() and read_result().
void write_experiment(const std::filesystem::path &path, const ExperimentResult &result);
ExperimentResult read_experiment(const std::filesystem::path &path);

/// Root mean square errors in millimetres, a column for each state: first what stands without a model (the noise of the
/// measurement, a body that does not move, the rigid motion that fits best, the straight line between driven places),
/// then the reference on the refined mesh with its own uncertainty, then the models on the mesh, the best first, with
/// the time of all states. A model without a solution has the word for its status behind the error.
Layout experiment_table(const ExperimentResult &result);

/// Ring-downs of an experiment: for each the measured frequency and damping ratio with their uncertainty, the
/// noise, what stands without a model, and a row for each model, the smallest error of the markers first.
Layout ring_down_table(const ExperimentResult &result);

/// Sentence on the state that damping was fitted on, and what all models were given for it; the last run is of the
/// reference.
std::string ring_down_note(const ExperimentResult &result);

} // namespace livermark::results
