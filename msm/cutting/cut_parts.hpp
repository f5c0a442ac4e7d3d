#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/cutting/cut_changes.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// Where the stiffness of springs comes from: factor times what a law makes of a body.
struct SpringSource {
    SpringLaw law;
    core::Body body;     ///< as the law sees it: Young's moduli of springs_beside_volume() are others
    double factor = 1.0; ///< of all springs
};

/// What fast kernels know of a body from which tetrahedra are taken away, or that is parted, one cut after the other.
/// Nodes, springs and tetrahedra keep their numbers; new ones are numbered behind them. What a cut changes is found
/// around it alone: the stiffness of springs as sums over the tetrahedra that are left around an edge, masses and
/// volumes of nodes likewise, in the order in which a set-up from nothing sums, so the numbers are those of the cut
/// body set up anew, to the bit. Laws that look at the whole body (uniform, patch) are asked again.
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

    /// Parts the body: some tetrahedra get other nodes. Which faces may part is the caller's to know: see
    /// meshes::cut().
    /// @param parting  of tetrahedra that are there; each new node has some of those of its parent
    /// @return what has changed, until the next call
    const PartingChanges &part(const Parting &parting);

    const StepParts &parts() const { return parts_; }
    const std::vector<double> &node_mass() const { return node_mass_; } ///< (N) [kg]; 0 of nodes that are gone

  private:
    CutParts() = default;
    void set_spring(int spring);
    /// @return springs whose stiffness may have changed: all
    std::vector<int> ask_law_again();
    void set_volumes(std::span<const int> volumes);
    void set_mass(int node);
    template <std::size_t n>
    std::vector<int> once(const std::vector<std::array<int, n>> &numbers, std::span<const int> tetrahedra);

    void part_nodes(const Parting &parting);
    void part_springs(const Parting &parting);
    void put_in_order(std::size_t first_new);
    void part_volumes(const Parting &parting);
    void part_edges(const Parting &parting);

    StepParts parts_;
    std::vector<double> node_mass_;
    std::optional<SpringSource> source_;
    core::EdgeTable edges_;
    std::vector<std::array<int, 4>> tetrahedra_;
    std::vector<int> spring_order_; // (S) in lexicographic order of edges; kept for laws that look at the whole body
    NumberLists of_node_, of_spring_, of_volume_; // tetrahedra of each, ascending
    std::vector<double> mass_share_;              // (M) of each corner [kg]
    std::vector<std::array<double, 6>> of_edges_; // (M) what each adds to its springs [N/m]
    Eigen::VectorXd volume_;                      // (M) as VolumePenalty has it [m^3]
    std::vector<double> volume_modulus_;          // (C) [Pa]
    std::vector<char> is_seen_;                   // room for marks, 0 but in once()
    CutChanges changes_;
    PartingChanges parted_;
};

} // namespace livermark::msm
