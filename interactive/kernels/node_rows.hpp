#pragma once

#include <boost/align/aligned_allocator.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "interactive/method.hpp"

namespace livermark::interactive {

namespace kernels {

/// Fans or nodes side by side: as many as the widest vectors have lanes. Narrower ones take them in several goes, so
/// that one layout serves every machine.
inline constexpr std::size_t slice_size = 16;

/// Nodes whose forces are summed side by side, as rows of four numbers.
inline constexpr std::size_t nodes_at_once = 4;

/// Starts at a cache line.
template <class T> using Aligned = std::vector<T, boost::alignment::aligned_allocator<T, 64>>;

/// A number, filled up to whole slices.
constexpr std::size_t filled_up(std::size_t count) {
    return (count + slice_size - 1) / slice_size * slice_size;
}

template <class... Arrays> std::size_t bytes_of(const Arrays &...arrays) {
    return ((arrays.size() * sizeof(arrays[0])) + ...);
}

/// Nodes of a scene in an order of their own, and their state. A row is four numbers of a node, the last one zero.
struct NodeRows {
    std::vector<int> row_of_node; ///< (N)
    std::size_t num_rows = 0;     ///< N, filled up to whole slices

    Aligned<float> displacement; ///< [m]; the last number is the pressure around the node [Pa] where there is one
    Aligned<float> velocity;     ///< [m/s]
    Aligned<float> external;     ///< [N]
    Aligned<float> inverse_mass; ///< [1/kg], three times the same; zero where constrained

    /// @param order  shape (N) nodes as rows come
    void place(const Scene &scene, const std::vector<int> &order);

    /// @return (N) nodes as rows come
    std::vector<int> order() const;

    /// Constrained nodes begin where they are, without what single precision has lost on the way there, and have the
    /// velocities that take them to their targets.
    /// @param rest, x  shape (3, N) at rest and now [m]
    /// @param targets  shape (3, C) [m]
    void aim_constrained(const Scene &scene, const Field &rest, const Field &x, const Field &targets, double time_step);

    std::size_t bytes() const { return bytes_of(displacement, velocity, external, inverse_mass); } ///< of the state
};

/// Nodes in reverse Cuthill-McKee order of a mesh, those of a scene's own in the middle between their ends, and sorted
/// by a number that they have within windows, the larger first: side by side they have about the same one.
/// @param ends       of the own nodes
/// @param num_items  (N)
/// @param corners    nodes of the mesh in an order that is known already; empty to find one
/// @return (N) nodes
std::vector<int> order_of_nodes(const std::vector<std::array<int, 4>> &tetrahedra,
                                const std::vector<std::array<int, 2>> &ends, const std::vector<int> &num_items,
                                const std::vector<int> &corners = {});

} // namespace kernels

/// The three numbers of a node in rows of four.
inline Eigen::Map<Eigen::Vector3f> in_row(kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}
inline Eigen::Map<const Eigen::Vector3f> in_row(const kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<const Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}

/// A row in single precision, and where it is measured from, as one vector in double precision.
class FineRow {
  public:
    FineRow(core::Vector3 origin, const Eigen::Map<Eigen::Vector3f> &row) : origin_(std::move(origin)), row_(row) {}
    operator core::Vector3() const { return origin_ + row_.cast<double>(); } // NOLINT(google-explicit-constructor)
    void operator+=(const core::Vector3 &change) { row_ = (row_.cast<double>() + change).cast<float>(); }

  private:
    core::Vector3 origin_;
    Eigen::Map<Eigen::Vector3f> row_;
};

/// A method whose state is rows of nodes, in single precision: positions and velocities are these rows after each step.
class SimulationInRows : public Simulation {
  public:
    void set_state(const Field &positions, const Field &velocities) override;
    void set_external_forces(const Field &forces) override;
    bool touch(const std::shared_ptr<core::BallContact> &ball) override;

  protected:
    explicit SimulationInRows(Scene given) : Simulation(std::move(given)), rest_(positions()) {}
    virtual kernels::NodeRows &rows() = 0;

    int row_of(int node) { return rows().row_of_node[node]; }
    /// Position of a node in its row [m].
    FineRow row_position(int node) { return {rest_.col(node), in_row(rows().displacement, row_of(node))}; }
    /// Ends a step: positions and velocities are those of the rows, constrained nodes are at their targets to the last
    /// bit.
    void take_state_from_rows();
    /// @param bytes  of the body and its state
    Cost cost_of(double element_passes, std::size_t bytes) const;

    const Field rest_;
    std::shared_ptr<core::BallContact> ball_; ///< that touches; null if none does
};

} // namespace livermark::interactive
