#pragma once

#include <boost/align/aligned_allocator.hpp>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "interactive/scene.hpp"

namespace livermark::interactive::kernels {

/// Fans or nodes side by side: as many as the widest vectors have lanes. Narrower ones take them in several goes, so
/// that one layout serves every machine.
inline constexpr std::size_t slice_size = 16;

/// Nodes whose forces are summed side by side, as rows of four numbers.
inline constexpr std::size_t nodes_at_once = 4;

/// Starts at a cache line.
template <class T> using Aligned = std::vector<T, boost::alignment::aligned_allocator<T, 64>>;

/// Where the pressure of a neo-Hookean tetrahedron comes from.
enum class Pressure : std::uint8_t {
    of_tetrahedra, ///< its own J
    around_nodes   ///< the mean of those of its nodes, which have the mean J around them (NodalPressureEnergy)
};

/// Numbers of a tetrahedron: gradients of the shape functions of its nodes but the first of the axis, three each, then
/// V mu, then V lambda, or V / 4 where pressures are those around nodes.
inline constexpr std::size_t numbers_of_tetrahedron = 11;

/// A body and its state for vector units, in single precision. Nodes stand in reverse Cuthill-McKee order, sorted by
/// their number of slots within windows; a row is four numbers of a node. Tetrahedra stand in fans, 16 side by side,
/// filled up with tetrahedra of no volume, so that one new node is fetched for each tetrahedron, not four. A fan puts
/// the force on each of its corners, summed over its tetrahedra, into a slot of its own. A node sums its slots, always
/// in the same order: the same steps give the same bits, on vectors of any width that multiply and add at once.
struct ExplicitRows {
    Pressure pressure = Pressure::of_tetrahedra;
    std::vector<int> row_of_node; ///< (N)
    std::size_t num_rows = 0;     ///< N, filled up to whole slices

    std::vector<std::size_t> line_start; ///< (slices + 1) of fans: their first line of tetrahedra
    /// A line for each end of the axis, then one for each node of the rim: 16 times four times the row of a node.
    Aligned<std::int32_t> corner;
    Aligned<std::int32_t> slot;          ///< as corner: four times the slot of the force
    Aligned<float> tetrahedra;           ///< lines of tetrahedra, numbers_of_tetrahedron vectors of 16 for each
    std::vector<std::size_t> slot_start; ///< (rows / 4 + 1) in units of four slots: the k-th of four nodes side by side
    Aligned<float> force;                ///< in slots; zero where nothing writes, and one more slot for what fills up
    // Rows of four, the last one zero but where it says so.
    Aligned<float> displacement; ///< [m], and the pressure around the node [Pa]
    Aligned<float> velocity;     ///< [m/s]
    Aligned<float> external;     ///< [N]
    Aligned<float> inverse_mass; ///< [1/kg], three times the same; zero where constrained
    // Of pressures around nodes.
    Aligned<float> growth;                 ///< as corner: V (J - 1) / 4, summed over tetrahedra of a fan at a corner
    std::vector<std::size_t> growth_start; ///< (slices of rows + 1) in units of 16
    Aligned<std::int32_t> growth_at;       ///< whose sum is the growth around a node; the last of growth is zero
    Aligned<float> inverse_volume, lambda; ///< (rows) a quarter of the volumes [1/m^3]; mean [Pa]

    std::size_t first_corner(std::size_t slice) const { return (line_start[slice] + 3 * slice) * slice_size; }
    std::size_t num_slices() const { return line_start.size() - 1; }
    std::size_t bytes() const; ///< of the body and its state
};

/// @param scene  without nodes of a method's own
ExplicitRows explicit_rows(const Scene &scene, Pressure pressure);

} // namespace livermark::interactive::kernels
