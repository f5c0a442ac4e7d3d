#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"

namespace livermark::msm {

/// Room for as much and what some cuts add. Memory is not touched before it is needed.
constexpr std::size_t with_room(std::size_t size) {
    return size + size / 4;
}

/// Lists of numbers behind each other, of each node its tetrahedra, say. A list that becomes another one goes to the
/// end, so that to change a few costs no more than these.
class NumberLists {
  public:
    NumberLists() = default;

    /// The things that have each number, ascending.
    /// @param numbers  shape (things), of each thing the numbers that it has, below count
    template <std::size_t n> NumberLists(const std::vector<std::array<int, n>> &numbers, std::size_t count) {
        start_.assign(count, 0);
        size_.assign(count, 0);
        for (const auto &those : numbers)
            for (const int number : those)
                ++size_[number];
        for (std::size_t i = 1; i < count; ++i)
            start_[i] = start_[i - 1] + size_[i - 1];
        entries_.resize(n * numbers.size());
        auto next = start_;
        for (std::size_t thing = 0; thing < numbers.size(); ++thing)
            for (const int number : numbers[thing])
                entries_[next[number]++] = static_cast<int>(thing);
    }

    std::size_t size() const { return start_.size(); } ///< how many lists there are
    std::span<const int> of(int number) const { return std::span(entries_).subspan(start_[number], size_[number]); }

    /// @param list  not a part of these lists, unless it is no longer than the one that it replaces
    void set(int number, std::span<const int> list) {
        if (list.size() > size_[number]) {
            start_[number] = entries_.size();
            entries_.insert(entries_.end(), list.begin(), list.end());
        } else {
            std::copy(list.begin(), list.end(), entries_.begin() + static_cast<std::ptrdiff_t>(start_[number]));
        }
        size_[number] = list.size();
    }

    /// Room for lists that become others, without moving those that are there.
    void leave_room() { entries_.reserve(with_room(entries_.size())); }

    /// Adds empty lists until there are so many.
    void resize(std::size_t count) {
        start_.resize(count, 0);
        size_.resize(count, 0);
    }

  private:
    std::vector<std::size_t> start_, size_;
    std::vector<int> entries_;
};

/// Lists of new things, which get their entries in turn.
class NewLists {
  public:
    void add(int number, int entry) { of_[number].push_back(entry); }
    void put_into(NumberLists &lists) const {
        for (const auto &[number, list] : of_)
            lists.set(number, list);
    }

  private:
    std::map<int, std::vector<int>> of_;
};

/// Leaves those things in a list that still have its number.
/// @param numbers  shape (things), of each thing the numbers that it has
template <std::size_t n>
void leave_owners(int number, const std::vector<std::array<int, n>> &numbers, NumberLists &lists) {
    std::vector<int> left;
    for (const int thing : lists.of(number))
        if (std::ranges::find(numbers[thing], number) != numbers[thing].end())
            left.push_back(thing);
    lists.set(number, left);
}

/// Numbers of what a cut has changed, as in StepParts, each ascending and once.
struct CutChanges {
    std::vector<int> tetrahedra; ///< that are gone
    std::vector<int> nodes;      ///< corners of these: their masses
    std::vector<int> springs;    ///< edges of these: their stiffness
    std::vector<int> volumes;    ///< control volumes that have lost some of their volume
    std::vector<int> edge_parts; ///< means around edges that have lost tetrahedra
};

/// Changes that a blade without thickness makes: all tetrahedra stay, and some have other nodes, which are in the
/// places of those before.
struct Parting {
    std::vector<int> tetrahedra;           ///< that have other nodes, ascending
    std::vector<std::array<int, 4>> nodes; ///< all nodes of these from now on; new ones are numbered from N on
    std::vector<int> parent_node;          ///< of each new node, the one before from which it is parted
};

/// Numbers of what a parting has changed, as in StepParts, each ascending and once. What is new is numbered behind what
/// was there.
struct PartingChanges {
    std::vector<int> tetrahedra;   ///< that have other nodes
    std::vector<int> parent_node;  ///< of each new node
    std::vector<int> nodes;        ///< parents, and new nodes: their masses
    std::vector<int> springs;      ///< edges that have lost tetrahedra, and new ones; of laws that look at the whole
                                   ///< body, all
    std::vector<int> gone_springs; ///< of these, those that have lost the last one
    int first_new_spring = 0;
    std::vector<int> volumes;    ///< control volumes around a node of these tetrahedra, before or now
    std::vector<int> edge_parts; ///< means around an edge of these tetrahedra, before or now
};

/// Source of the stiffness of springs: factor times that of a law.
struct SpringSource {
    SpringLaw law;
    core::Body body;     ///< as the law sees it: Young's moduli of springs_beside_volume() are others
    double factor = 1.0; ///< of all springs
};

/// Parts that fast kernels know of a body from which tetrahedra are taken away, or that is parted, one cut after the
/// other. Nodes, springs and tetrahedra keep their numbers; new ones are numbered behind them. What a cut changes is
/// found around it alone: the stiffness of springs as sums over the tetrahedra that are left around an edge, masses and
/// volumes of nodes likewise, in the order in which a set-up from nothing sums, so the numbers are those of the cut
/// body set up anew, to the bit. Laws that look at the whole body (uniform, patch) are asked again. Tetrahedra keep
/// their factors of a map of stiffness, springs along the surface lose what the capsule adds with its facets, and terms
/// beside the kernels are the caller's: ElasticTerm::after_cut().
class CutParts {
  public:
    /// @param body     at rest, with the materials that its terms have; the tetrahedra of the elastic body are its own
    /// @param elastic  springs, coupled springs, volumes around nodes or of tetrahedra, and the guard; terms beside the
    ///                 kernels do not matter here
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
    /// (M) by the numbers that nodes keep, those that are gone included.
    const std::vector<std::array<int, 4>> &tetrahedra() const { return tetrahedra_; }
    const std::vector<double> &node_mass() const { return node_mass_; } ///< (N) [kg]; 0 of nodes that are gone

  private:
    CutParts() = default;
    void set_spring(int spring);
    double capsule_spring(int spring) const;
    double mean_over(std::span<const int> tetrahedra, std::span<const double> values, int num_places) const;
    void set_moduli(std::span<const int> volumes, std::span<const int> edge_parts);
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
    NumberLists node_lists_, spring_lists_, volume_lists_; // tetrahedra of each, ascending
    NumberLists edge_part_lists_;                          // the same; kept where each tetrahedron has its own modulus
    std::vector<double> modulus_factor_, volume_in_means_; // (M) of a map of stiffness, and [m^3]; empty without one
    std::vector<std::array<bool, 4>> is_covered_;          // (M) faces opposite of corners; kept for springs on edges
    double stiffness_of_facet_ = 0.0;                      // that the capsule adds to springs along it [N/m]
    std::vector<double> mass_share_;                       // (M) of each corner [kg]
    std::vector<std::array<double, 6>> edge_stiffness_;    // (M) what each adds to its springs [N/m]
    Eigen::VectorXd volume_;                               // (M) as VolumePenalty has it [m^3]
    std::vector<double> volume_modulus_;                   // (C) [Pa]
    std::vector<char> is_seen_;                            // room for marks, 0 but in once()
    CutChanges changes_;
    PartingChanges parted_;
};

/// Some tetrahedra of a body as a body of their own, with its capsule, vessels and map of stiffness. It has no boundary
/// triangles but those that the capsule covers.
struct PartOfBody {
    core::Body body;
    std::vector<int> node;        ///< of each node of the part: its number in the whole body, ascending
    std::vector<int> tetrahedron; ///< (M) which of the whole body these are, ascending
    NodalConditions conditions;   ///< of its nodes; no loads
};

/// @param is_in       shape (M) which tetrahedra
/// @param conditions  of the whole body
PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions);

/// A term beside the kernels of a part, from that of the whole body. It cannot be cut: its tetrahedra are numbered as
/// those of the whole body.
/// @param num_tetrahedra  of the whole body
std::shared_ptr<const ElasticTerm> term_of_part(const ElasticTerm &whole, const PartOfBody &part,
                                                std::size_t num_tetrahedra);

/// The highest frequency of what is around a wound, with all else constrained: of the tetrahedra that are left within
/// some rings of tetrahedra around its nodes, set up as a small body of their own. What is constrained more has no
/// higher frequency (Cauchy's interlacing), so that of the whole body is no lower. A mode at the wound does not reach
/// far, and elsewhere nothing has changed: the larger of this and of the frequency before the cut is that of the whole
/// cut body, where the mode before is not at the wound itself.
/// @param body        before the cut, at rest
/// @param is_removed  shape (M) what is gone
/// @param nodes       that have lost tetrahedra
/// @param make        the springs of a part of the body
/// @param conditions  of the nodes of the body
/// @param tolerance   of Lanczos's method, relative
/// @return [rad/s]; zero if nothing there can move
double frequency_around(const core::Body &body, const std::vector<char> &is_removed, std::span<const int> nodes,
                        const std::function<ElasticBody(const PartOfBody &)> &make, const NodalConditions &conditions,
                        double tolerance);

/// Numbers after a cut along facets, in a body whose nodes and tetrahedra keep their numbers.
struct FacetCut {
    std::vector<int> removed; ///< tetrahedra, ascending
    Parting parting;          ///< of those that are left; nothing if no node is parted
};

/// The numbers that CutParts and FastSteps keep, from those of the bodies that meshes::cut() makes one after the other.
class KeptNumbers {
  public:
    /// @param mesh  before any cut
    explicit KeptNumbers(const core::TetraMesh &mesh);

    /// Goes on to what a cut has left of the body. Of the nodes in the place of a node, the first keeps its number.
    /// @param after              after the cut
    /// @param parent_tetrahedron shape (M') that each tetrahedron was in the body before the cut, ascending; corners
    ///                           keep their order
    FacetCut follow(const core::TetraMesh &after, const std::vector<int> &parent_tetrahedron);

    const std::vector<int> &nodes() const { return node_; } ///< (N') number of each node of the body now
    int num_nodes() const { return num_nodes_; }            ///< of all, gone ones included

  private:
    std::vector<std::array<int, 4>> tetrahedra_; // (M) by their nodes' numbers
    std::vector<int> node_, tetrahedron_;        // (N'), (M') of the body now: numbers
    int num_nodes_;
};

} // namespace livermark::msm
