#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/cutting/cut_changes.hpp"
#include "msm/dynamics/step_parts.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// Where the stiffness of springs comes from: factor times what a law makes of a body.
struct SpringSource {
    SpringLaw law;
    core::Body body;     ///< as the law sees it: Young's moduli of springs_beside_volume() are others
    double factor = 1.0; ///< of all springs
};

/// What fast kernels know of a body from which tetrahedra are taken away, one cut after the other. Nodes, springs and
/// tetrahedra keep their numbers. What a cut changes is found around it alone: the stiffness of springs as sums over
/// the tetrahedra that are left around an edge, masses and volumes of nodes likewise, in the order in which a set-up
/// from nothing sums, so the numbers are those of the cut body set up anew, to the bit. Laws that look at the whole
/// body (uniform, patch) are asked again.
class CutParts {
  public:
    /// @param body     at rest, with the materials that its terms have; the tetrahedra of the elastic body are its own
    /// @param elastic  springs, coupled springs, volumes around nodes or of tetrahedra, and the guard
    /// @param springs  where the stiffness of springs comes from; nothing if there are none
    /// @return nothing if fast kernels do not know a part of the body
    static std::optional<CutParts> prepare(const core::Body &body, const ElasticBody &elastic,
                                           std::optional<SpringSource> springs);

    /// Takes tetrahedra away. What is to float, or to hang on a node or an edge, is the caller's to prevent: see
    /// meshes::cut().
    /// @param tetrahedra  numbers, each once, of some that are there
    /// @return what has changed, until the next call
    const CutChanges &remove(std::span<const int> tetrahedra);

    const StepParts &parts() const { return parts_; }
    const std::vector<double> &node_mass() const { return node_mass_; } ///< (N) [kg]; 0 of nodes that are gone

  private:
    CutParts() = default;
    void set_spring(int spring);
    void ask_law_again();
    void set_volumes(std::span<const int> volumes);
    template <std::size_t n> std::vector<int> of_removed(const std::vector<std::array<int, n>> &numbers);

    /// Lists of tetrahedra, ascending, behind each other.
    struct Around {
        std::vector<int> start, tetrahedra;
        std::span<const int> of(int number) const {
            return std::span(tetrahedra).subspan(start[number], start[number + 1] - start[number]);
        }
    };
    template <std::size_t n> static Around around(const std::vector<std::array<int, n>> &numbers, std::size_t count);

    StepParts parts_;
    std::vector<double> node_mass_;
    std::optional<SpringSource> source_;
    core::EdgeTable edges_;
    std::vector<std::array<int, 4>> tetrahedra_;
    Around of_node_, of_spring_, of_volume_;
    std::vector<double> mass_share_;              // (M) of each corner [kg]
    std::vector<std::array<double, 6>> of_edges_; // (M) what each adds to its springs [N/m]
    Eigen::VectorXd volume_;                      // (M) as VolumePenalty has it [m^3]
    std::vector<double> volume_modulus_;          // (C) [Pa]
    std::vector<char> is_seen_;                   // room for marks, 0 but in of_removed()
    CutChanges changes_;
};

} // namespace livermark::msm
