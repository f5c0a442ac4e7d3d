#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "results/records/result.hpp"
#include "results/records/ring_down.hpp"

namespace livermark::results {

/// A body in one state, as it was measured, and what can be said of it without a model. Errors are root mean square
/// distances over the markers that are compared and were seen [m].
struct ExperimentState {
    std::string name;
    std::vector<core::Vector3> displacement{}; ///< (K) measured [m]; NaN of a marker that was not seen
    double noise = 0.0;                        ///< of the measurement [m]; 0 where nobody says
    double no_motion = 0.0;                    ///< error of a body that does not move
    double rigid_motion = 0.0;                 ///< of the rigid motion that fits the markers best
    /// Of the straight line between two places that markers drive; NaN where there are not two.
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

} // namespace livermark::results
