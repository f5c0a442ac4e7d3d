#pragma once

#include <array>
#include <optional>
#include <vector>

#include "msm/elastic_body.hpp"

namespace livermark::msm {

/// What springs that are coupled around nodes or edges resist with: forces in proportion to elongations, or the
/// neo-Hookean energy of squared lengths (coupled_springs.hpp).
enum class CoupledEnergy { elongations, neo_hookean };

/// What fast kernels know how to move: springs, springs coupled around nodes or around edges, the
/// volume around nodes or of tetrahedra, and the guard against inversion, as plain arrays. Empty arrays stand for a
/// part that is not there.
struct StepParts {
    std::vector<std::array<int, 2>> edges; ///< (S) node numbers
    std::vector<double> stiffness;         ///< (S) [N/m]
    std::vector<double> rest_length;       ///< (S) [m]

    std::vector<std::array<int, 4>> tetrahedra; ///< (M) node numbers, of all that follows
    /// (M) pressure of a tetrahedron for each m^3 that it has gained [Pa/m^3]
    std::vector<double> tetrahedron_stiffness;
    /// (C) node in the middle of each control volume, to which every tetrahedron in it gives a quarter of its own
    std::vector<int> centre;
    std::vector<double> volume_stiffness;          ///< (C) pressure for each m^3 that it has gained [Pa/m^3]
    std::vector<std::array<int, 4>> corner_volume; ///< (M) control volume around each corner
    /// Whether volumes are resisted by their logarithms, see logarithm_of_volume(); only beside neo-Hookean springs.
    bool has_logarithmic_volume = false;
    /// Whether relative changes of volumes are averaged, see mean_volumes_around_nodes(); beside springs around edges,
    /// and only there.
    bool has_mean_volumes = false;
    CoupledEnergy coupled_energy = CoupledEnergy::elongations; ///< of what follows
    /// Whether neo-Hookean springs around nodes or edges take C of the mean of F, and not the mean of C.
    bool has_gradient_means = false;
    /// (C) shear modulus of the springs that are coupled in each control volume [Pa]
    std::vector<double> coupled_modulus;
    /// (E) shear modulus of the springs that are coupled around each edge, in each of the materials there [Pa]; in
    /// place of coupled_modulus
    std::vector<double> edge_modulus;
    std::vector<std::array<int, 6>> edge_part; ///< (M) which of them, in the order of core::tetrahedron_edges
    std::vector<double> inner_modulus;         ///< (M) of those that stay inside each tetrahedron [Pa]
    std::vector<double> least_volume;          ///< (M) [m^3] below which a tetrahedron is pushed back
    std::vector<double> guard_stiffness;       ///< (M) pressure for each m^3 that it then lacks [Pa/m^3]
    std::vector<double> watched_volume;        ///< (M) see FastStepOptions [m^3]
    /// (M) tetrahedra that a cut has taken away and that are still in their places here, empty if none are: see
    /// cutting/cut_parts.hpp. They have no volume and no stiffness.
    std::vector<char> is_removed;
    bool is_there(std::size_t tetrahedron) const { return is_removed.empty() || is_removed[tetrahedron] == 0; }
};

/// Puts down where control volumes around nodes are.
/// @return false if another term has already put down others
bool describe_volumes(const std::vector<int> &centre, const std::vector<std::array<int, 4>> &corner_volume,
                      StepParts &parts);

/// @return nothing if the body has a part that fast kernels do not know
std::optional<StepParts> step_parts(const ElasticBody &body);

} // namespace livermark::msm
