#pragma once

#include <cstdint>
#include <functional>

#include "interactive/kernels/node_rows.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive::kernels {

/// Numbers of a line: where its node is at rest, from the node that moves [m], three; the entry of both nodes in the
/// Laplacian, sum of V mu g . g [N/m], where the node comes for the first time; then of the tetrahedron that the line
/// ends (lambda + mu) / (36 V), with the sign bit where its strip keeps its first node, and mu / 6, negative where the
/// order of its nodes is that of a mirror.
inline constexpr std::size_t numbers_of_line = 6;

/// A body of stable neo-Hookean tetrahedra for descent on one node at a time, in single precision. Nodes that can move
/// stand colour after colour, 16 of one colour in a batch: no two of a batch are in one tetrahedron, so it moves them
/// at once. The facets opposite a node make strips of triangles around it (orders.hpp), so that one neighbour is
/// fetched for each tetrahedron, not three. Batches are filled up with nodes that have no neighbours. What is
/// constrained stands behind them, filled up to whole slices; there are no inverse masses.
struct DescentRows : NodeRows {
    std::vector<std::size_t> line_start; ///< (batches + 1)
    Aligned<std::int32_t> neighbour;     ///< lines of 16: four times the row
    Aligned<float> numbers;              ///< lines, numbers_of_line vectors of 16 for each
    Aligned<float> mass;                 ///< (rows) [kg]
    Aligned<float> laplacian;            ///< (rows) sum of V mu |g|^2 [N/m]
    // Rows of four, the last one zero.
    Aligned<float> before;                 ///< displacement when the step began
    Aligned<float> predicted;              ///< where inertia and external forces lead; the target where constrained
    Aligned<float> last_velocity;          ///< [m/s], of the step before the last one
    Aligned<float> older, oldest;          ///< displacement, one iteration ago and two
    std::function<void()> after_iteration; ///< what else moves nodes; empty if there is nothing
    std::vector<std::vector<StripNode>> strips; ///< (N) of Orders; no step reads them

    std::size_t num_batches() const { return line_start.size() - 1; }
    std::size_t bytes() const; ///< of the body and its state
};

/// @param colours  of all nodes, as colour_nodes() of the tetrahedra finds them
DescentRows descent_rows(const Scene &scene, const Colouring &colours);

/// A step of vertex block descent in single precision on the vectors of the machine: displacements go on to where the
/// velocity and the external acceleration that the last step followed lead, and each iteration visits the batches in
/// their order, with the weights of orders.hpp. The rows of constrained nodes in predicted are their targets.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_descent_step(DescentRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
