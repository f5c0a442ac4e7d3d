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
    /// Error of the affine map that fits the markers best; NaN where they do not determine it.
    double affine_map = std::numeric_limits<double>::quiet_NaN();
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
    std::string message{};                 ///< why it is not ok
    double error = 0.0, worst_error = 0.0; ///< root mean square, and largest distance from the measurement [m]
    /// (3) root mean square of each component [m]; NaN where it is not known, here and below
    std::vector<double> component_error = std::vector<double>(3, std::numeric_limits<double>::quiet_NaN());
    /// (3) error less that of the reference, and the ends of its interval of 95 % over markers [m]; 0 of the reference
    std::vector<double> beyond_reference = std::vector<double>(3, std::numeric_limits<double>::quiet_NaN());
    double seconds = 0.0;                      ///< set-up and solving
    std::vector<core::Vector3> displacement{}; ///< (K) of the markers [m]
    bool operator==(const ExperimentRun &) const = default;
};

/// A model on one mesh, whose force along the way was found.
struct ForceRun {
    std::string model;
    int tetrahedra = 0; ///< of the mesh
    core::SolutionStatus status = core::SolutionStatus::ok;
    std::string message{};       ///< why it is not ok
    std::vector<double> force{}; ///< (J) [N]; NaN beyond the end of its path
    double seconds = 0.0;        ///< set-up and solving, of all states
};

/// Force along the way of a state, as it was measured, and of every model. A force in proportion to Young's modulus
/// tells nothing as long as that is not known, so each model has the modulus with which it is right at the first way.
struct ForceResult {
    std::string state, place;
    std::vector<double> way;       ///< (J) [m]
    std::vector<double> force;     ///< (J) mean of the tests [N]
    std::vector<double> deviation; ///< (J) standard deviation of the tests [N]
    double young_modulus = 0.0;    ///< that models were solved with [Pa]
    /// (J) of a uniform body without a mesh, for that modulus times its cross-section of 1 [N]; empty where the body is
    /// not uniform.
    std::vector<double> uniform{};
    std::vector<ForceRun> runs{};
};

/// Error of a force at each way when it is multiplied so that it is right at the first one.
/// @param force  shape (J)
/// @return shape (J - 1), relative, positive where it is too large
std::vector<double> errors_of_shape(const ForceResult &measured, const std::vector<double> &force);

/// The material with which a model is nearest to the markers of all states, one constant at a time. Errors are root
/// mean squares over states and markers [m]. NaN where no value of the constant is better than the given one.
struct FittedMaterial {
    std::string model;
    double error = 0.0;                                              ///< with the material of the experiment
    double young_modulus = std::numeric_limits<double>::quiet_NaN(); ///< [Pa]
    double error_of_modulus = std::numeric_limits<double>::quiet_NaN();
    double poisson_ratio = std::numeric_limits<double>::quiet_NaN();
    double error_of_ratio = std::numeric_limits<double>::quiet_NaN();
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
    std::vector<ForceResult> forces{};          ///< of the states whose force was measured
    std::vector<FittedMaterial> fits{};         ///< none where nobody asked for them
    std::vector<RingDownResult> ring_downs{};   ///< none where nothing was let go
    std::string damping_from{};                 ///< the state of that on which damping is fitted

    bool is_compared(std::size_t marker) const { return drives[marker].empty(); }
    bool has_compared_markers() const;
};

/// Root mean square and largest distance between displacements and the measured ones, over the markers that are
/// compared and were seen.
struct MarkerError {
    double root_mean_square = 0.0, worst = 0.0; ///< [m]
    std::vector<double> component;              ///< (3) root mean square of each component [m]
};
MarkerError marker_error(const ExperimentResult &result, const std::vector<core::Vector3> &displacement,
                         const std::vector<core::Vector3> &measured);

/// Finds ExperimentRun::beyond_reference of all runs, paired by markers: the reference is the last run of each state.
/// Intervals are from 2.5 to 97.5 % of 2000 samples of the markers with replacement (Efron 1979, Ann. Stat. 7(1)), the
/// same samples for all.
void compare_with_reference(ExperimentResult &result);

/// The "Experiment files" of results/schema.md; errors as of write_result() and read_result().
void write_experiment(const std::filesystem::path &path, const ExperimentResult &result);
ExperimentResult read_experiment(const std::filesystem::path &path);

/// Root mean square errors in millimetres, a column for each state: first what stands without a model (the noise of the
/// measurement, a body that does not move, the rigid motion that fits best, the straight line between driven places),
/// then the reference on the refined mesh with its own uncertainty, then the models on the mesh, the best first, with
/// the time of all states. A model without a solution has the word for its status behind the error.
Layout experiment_table(const ExperimentResult &result);

/// A length in millimetres; "-" where it is not known.
std::string length_cell(double length, int decimals = 2);

/// Errors of the components of each model in each state, in millimetres, and how far its error is beyond that of the
/// reference, with the interval of 95 % over markers; in brackets where it contains zero, so that markers do not tell
/// the two apart.
Layout marker_table(const ExperimentResult &result);

/// Forces of an experiment: for each state and way the error of every model in percent of the mean force, in a row for
/// each model, the smallest mean error first, below the standard deviation of the tests and what needs no mesh; the
/// modulus with which it is right at the first way; and the one with which it is nearest at all, with the root mean
/// square of the relative errors then.
Layout force_table(const ExperimentResult &result);

/// Materials that were fitted: a row for each model.
Layout fit_table(const ExperimentResult &result);

/// Sentences on what is nearer to the measurement than a model though it knows no mechanics.
std::vector<std::string> notes_on_nulls(const ExperimentResult &result);

/// Ring-downs of an experiment: for each the measured frequency and damping ratio with their uncertainty, the
/// noise, what stands without a model, and a row for each model, the smallest error of the markers first.
Layout ring_down_table(const ExperimentResult &result);

/// Sentence on the state that damping was fitted on, and what all models were given for it; the last run is of the
/// reference.
std::string ring_down_note(const ExperimentResult &result);

} // namespace livermark::results
