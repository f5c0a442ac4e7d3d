#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "interactive/kernels/node_rows.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive::kernels {

/// Source of the pressure of a neo-Hookean tetrahedron.
enum class Pressure : std::uint8_t {
    of_tetrahedra, ///< its own J
    around_nodes   ///< the mean of those of its nodes, which have the mean J around them (NodalPressureEnergy)
};

/// Numbers of a tetrahedron: gradients of the shape functions of its nodes but the first of the axis, three each, then
/// V mu, then V lambda, or V / 4 where pressures are those around nodes. V is the volume, or what a quadrature point of
/// a quadratic one is worth.
inline constexpr std::size_t numbers_of_tetrahedron = 11;

/// Lines of a fan that it has beside those of its tetrahedra, and what a tetrahedron adds.
struct FanLines {
    std::size_t per_fan, per_tetrahedron;
};
/// Both ends of the axis and the first node of the rim; the next one of the rim.
inline constexpr FanLines linear_lines{3, 1};
/// Both ends of the axis and its middle, the first node of the rim and the middles between it and the ends; the next
/// one of the rim, the same middles of it, and that between both nodes of the rim.
inline constexpr FanLines quadratic_lines{6, 4};

/// A body and its state for vector units, in single precision. Nodes stand in reverse Cuthill-McKee order, sorted by
/// their number of slots within windows. Tetrahedra stand in fans, 16 side by side, filled up with tetrahedra of no
/// volume, so that one new node is fetched for each tetrahedron, not four, and four of quadratic ones, not ten. A fan
/// puts the force on each of its nodes, summed over its tetrahedra, into a slot of its own. A node sums its slots,
/// always in the same order: the same steps give the same bits, on vectors of any width that multiply and add at once.
struct ExplicitRows : NodeRows {
    Pressure pressure = Pressure::of_tetrahedra;
    bool is_quadratic = false; ///< whether there is a node in the middle of each edge
    int num_corners = 0;       ///< nodes of the mesh

    std::vector<std::size_t> line_start; ///< (slices + 1) of fans: their first line of tetrahedra
    /// Lines of nodes as FanLines says, those of the axis first: 16 times four times the row of a node.
    Aligned<std::int32_t> corner;
    Aligned<std::int32_t> slot;          ///< as corner: four times the slot of the force
    Aligned<float> tetrahedra;           ///< lines of tetrahedra, numbers_of_tetrahedron vectors of 16 for each
    std::vector<std::size_t> slot_start; ///< (rows / 4 + 1) in units of four slots: the k-th of four nodes side by side
    Aligned<float> force;                ///< in slots; zero where nothing writes, and one more slot for what fills up
    // Of pressures around nodes.
    Aligned<float> growth;                 ///< as corner: V (J - 1) / 4, summed over tetrahedra of a fan at a corner
    std::vector<std::size_t> growth_start; ///< (slices of rows + 1) in units of 16
    Aligned<std::int32_t> growth_at;       ///< whose sum is the growth around a node; the last of growth is zero
    Aligned<float> inverse_volume, lambda; ///< (rows) a quarter of the volumes [1/m^3]; mean [Pa]
    FanList fans;                          ///< as they stand side by side; no step reads them

    FanLines lines() const { return is_quadratic ? quadratic_lines : linear_lines; }
    std::size_t first_corner(std::size_t slice) const {
        return (lines().per_tetrahedron * line_start[slice] + lines().per_fan * slice) * slice_size;
    }
    std::size_t num_slices() const { return line_start.size() - 1; }
    std::size_t bytes() const; ///< of the body and its state
    /// Rows of the mesh's nodes, and fans.
    Orders orders() const;
};

/// @param scene     linear, without nodes of a method's own, or of quadratic_scene()
/// @param pressure  of tetrahedra, where they are quadratic
ExplicitRows explicit_rows(const Scene &scene, Pressure pressure);

/// Steps of central differences as ExplicitTetrahedra takes them, in single precision on the vectors of the machine: a
/// pass over tetrahedra and one over nodes, and before these one for J of tetrahedra and one for pressures of nodes
/// where they are around nodes. Quadratic tetrahedra are neo-Hookean at their four points. Constrained nodes keep their
/// velocities. A tetrahedron that is inside out makes NaN, as the logarithm of its J does.
/// @param step          h of one [s]
/// @param mass_damping  alpha [1/s]
void take_explicit_steps(ExplicitRows &rows, double step, double mass_damping, int num_steps);

} // namespace livermark::interactive::kernels
