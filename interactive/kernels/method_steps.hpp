#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "core/support/factors/sparse_cholesky.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/node_rows.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/kernels/point_spring_rows.hpp"
#include "interactive/method.hpp"

/// Steps of methods on the vectors of the machine, each with the layout of the body that it takes.
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
    // Arrays for pressures around nodes.
    Aligned<float> growth;                 ///< as corner: V (J - 1) / 4, summed over tetrahedra of a fan at a corner
    std::vector<std::size_t> growth_start; ///< (slices of rows + 1) in units of 16
    Aligned<std::int32_t> growth_at;       ///< whose sum is the growth around a node; the last of growth is zero
    Aligned<float> inverse_volume, lambda; ///< (rows) a quarter of the volumes [1/m^3]; mean [Pa]
    FanList fans;                          ///< as they stand side by side; no step reads them
    PointSpringRows springs;               ///< beside the tetrahedra

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
/// @param springs   beside them
ExplicitRows explicit_rows(const Scene &scene, Pressure pressure, std::span<const PointSpring> springs);

/// Steps of central differences as ExplicitTetrahedra takes them, in single precision on the vectors of the machine: a
/// pass over tetrahedra and one over nodes, and before these one for J of tetrahedra and one for pressures of nodes
/// where they are around nodes, and one over springs. Quadratic tetrahedra are neo-Hookean at their four points.
/// Constrained nodes keep their velocities. A tetrahedron that is inside out makes NaN, as the logarithm of its J does.
/// @param step          h of one [s]
/// @param mass_damping  alpha [1/s]
void take_explicit_steps(ExplicitRows &rows, double step, double mass_damping, int num_steps);

/// Numbers of the rotation of a tetrahedron: a unit quaternion w, x, y, z.
inline constexpr std::size_t numbers_of_rotation = 4;

/// Numbers of the tangent of a spring beside the tetrahedra: its direction, and its stiffness across and along it, less
/// that across. Across a spring that is pressed it is zero, so that the tangent is positive semi-definite.
inline constexpr std::size_t numbers_of_tangent = 5;

/// A spring between three nodes and a ball that touches them (ImplicitContact::Point).
struct TouchedRows {
    std::array<int, 3> rows{};
    std::array<float, 3> shape{};
    std::array<float, 6> stiffness{}; ///< xx, xy, xz, yy, yz, zz [N/m]
    std::array<float, 3> force{};     ///< where the step begins [N]
};

/// A body of co-rotational tetrahedra, its state, and what conjugate gradients need, in single precision. Fans, slots
/// and nodes are those of explicit elements. The stiffness is that of linear elasticity with the gradients of shape
/// functions turned by R, so these are what an iteration reads of a tetrahedron.
struct CorotationalRows {
    ExplicitRows body;
    Aligned<float> turned;   ///< as body.tetrahedra, with turned gradients
    Aligned<float> rotation; ///< lines of tetrahedra, numbers_of_rotation vectors of 16 for each; from step to step
    /// As body.force: xx, xy, xz and yy, yz, zz of V (lambda + mu) g g^T with turned gradients [N/m].
    std::array<Aligned<float>, 2> block_slots;
    // Rows of four, the last one zero but where it says so.
    std::array<Aligned<float>, 2> block; ///< sums of slots at nodes, also of springs
    Aligned<float> mass;                 ///< [kg], three times the same, and the sum of V mu |g|^2 [N/m]
    Aligned<float> residual, direction, product, preconditioned;
    Aligned<float> inverse_block; ///< slices of nodes, xx, xy, xz, yy, yz, zz of each [1/kg]; zero where constrained

    /// Tangents of each set of body.springs, where the step begins: numbers_of_tangent vectors of 16 for each batch.
    std::vector<Aligned<float>> spring_tangent;
    std::array<Aligned<float>, 2> spring_block_slots; ///< as body.springs.force, of K

    std::vector<TouchedRows> touched; ///< of the step to come

    std::size_t bytes() const; ///< of the body and its state
};

/// @param scene    without nodes of a method's own
/// @param springs  beside the tetrahedra
CorotationalRows corotational_rows(const Scene &scene, std::span<const PointSpring> springs);

/// The rotation next to a deformation gradient, whatever it is, in double precision.
/// @param h  F - 1 by columns
/// @param q  quaternion w, x, y, z; stays as it is if there are no numbers in h
void find_nearest_rotation(const std::array<float, 9> &h, std::array<float, 4> &q);

/// A linearised step of backward Euler as CorotationalImplicit takes it, in single precision on the vectors of the
/// machine: rotations, and conjugate gradients from the velocities with the blocks of nodes as preconditioner.
/// Constrained nodes keep their velocities. Points that are touched take part as springs.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
/// @param iterations    of conjugate gradients, fewer where nothing is left to do
void take_corotational_step(CorotationalRows &rows, double time_step, double mass_damping, int iterations);

/// Kinds of constraints, and the numbers that each has. Gradients are those of the shape functions of the second,
/// third and fourth node of a tetrahedron.
enum class Constraint : std::uint8_t {
    distance, ///< |x_a - x_b| - l: x_a - x_b at rest, l, compliance [m/N]
    fibre,    ///< |d| - l of a PointSpring of four nodes: 4 weights, d at rest, l, compliance [m/N]
    volume,   ///< J - 1: 9 of gradients, compliance [1/J]
    pair      ///< |F| and J - 1 - mu / k: 9 of gradients, mu / k, both compliances [1/J]
};

constexpr std::size_t num_nodes_of(Constraint kind) {
    return kind == Constraint::distance ? 2 : 4;
}
constexpr std::size_t num_numbers_of(Constraint kind) {
    switch (kind) {
    case Constraint::distance:
        return 5;
    case Constraint::fibre:
        return 9;
    case Constraint::volume:
        return 10;
    default:
        return 12;
    }
}
constexpr std::size_t num_multipliers_of(Constraint kind) {
    return kind == Constraint::pair ? 2 : 1;
}

/// Constraints of one kind, colour after colour, 16 of one colour in a batch: no two of a batch share a node, so it
/// moves them at once. Batches are filled up with constraints of nodes that cannot move.
struct ConstraintRows {
    Constraint kind = Constraint::distance;
    Aligned<std::int32_t> corner; ///< vectors of 16 for each batch: four times the node
    Aligned<float> numbers, multipliers;
    std::vector<std::size_t>
        place; ///< (M) of each constraint in its order of colours: 16 times the batch plus the lane

    std::size_t num_batches() const { return corner.size() / (num_nodes_of(kind) * slice_size); }
};

/// Nodes in their order, and one more row that cannot move. The last number of a displacement is the inverse mass that
/// a step has [1/kg], that of an inverse mass is zero.
struct PositionRows : NodeRows {
    explicit PositionRows(const Scene &scene);

    Aligned<float> before; ///< displacement when the step began
    float damping = 0.0F;  ///< 1 + alpha h of the inverse masses in displacement; 0 if there are none yet
    std::vector<ConstraintRows> sets;
    std::function<void()> after_iteration; ///< what else moves nodes, after all sets; empty if there is nothing

    std::size_t bytes() const; ///< of the body and its state
};

/// @param offsets  where each colour begins, and the end
/// @param nodes    of each in the order of colours, num_nodes_of() behind each other
/// @param numbers  of each as the kind has them, num_numbers_of() behind each other
ConstraintRows constraint_rows(Constraint kind, const std::vector<int> &offsets, const std::vector<int> &nodes,
                               const std::vector<double> &numbers, int num_nodes);

/// A step as PositionBased takes it, in single precision on the vectors of the machine: each iteration visits the sets
/// in their order and the batches of each in theirs. Constrained nodes keep their velocities.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_position_step(PositionRows &rows, double time_step, double mass_damping, int iterations);

/// Numbers of a line: where its node is at rest, from the node that moves [m], three; the entry of both nodes in the
/// Laplacian, sum of V mu g . g [N/m], where the node comes for the first time; then of the tetrahedron that the line
/// ends (lambda + mu) / (36 V), with the sign bit where its strip keeps its first node, and mu / 6, negative where the
/// order of its nodes is that of a mirror.
inline constexpr std::size_t numbers_of_line = 6;

/// Numbers of a line of springs, a spring at one of its nodes: weights of the other three nodes and its own, d at rest,
/// l, k. A spring of two nodes has itself in place of two others, with the weight 0.
inline constexpr std::size_t others_in_line = 3, numbers_of_spring_line = 9;

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
    // Springs beside the tetrahedra.
    std::vector<std::size_t> spring_start; ///< (batches + 1) in lines
    Aligned<std::int32_t> spring_other;    ///< others_in_line vectors of 16 for each line: four times the row
    Aligned<float> spring_numbers;         ///< numbers_of_spring_line vectors of 16 for each line
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
/// @param springs  beside the tetrahedra, of four nodes at most
DescentRows descent_rows(const Scene &scene, const Colouring &colours, std::span<const PointSpring> springs);

/// A step of vertex block descent in single precision on the vectors of the machine: displacements go on to where the
/// velocity and the external acceleration that the last step followed lead, and each iteration visits the batches in
/// their order, with the weights of orders.hpp. The rows of constrained nodes in predicted are their targets.
/// @param time_step     h [s]
/// @param mass_damping  alpha [1/s]
void take_descent_step(DescentRows &rows, double time_step, double mass_damping, int iterations);

/// The columns of a supernode of L, the triangle L11 on top and the rectangle L21 below it, as the panel
///     B = [L11^-1; -L21 L11^-1],
/// by which both sweeps are products that wait for nothing: forwards (x1, x2) <- B x1 + (0, x2), backwards
/// x1 <- B^T (x1, x2).
struct Panel {
    std::size_t first_column, num_columns; ///< of L
    std::size_t first_block, num_blocks;   ///< of 16 rows, the last one filled up
    std::size_t first_value;

    /// Columns that share a load.
    static constexpr std::size_t columns_at_once = 4;
    std::size_t stored_columns() const {
        return (num_columns + columns_at_once - 1) / columns_at_once * columns_at_once;
    }
    /// Rows of the triangle have no more than these.
    std::size_t columns_of_block(std::size_t block) const {
        return std::min(stored_columns(), (block + 1) * slice_size);
    }
};

/// A factor of P A P^T = L L^T in single precision for vector units, which solves for three right-hand sides at once:
/// x, y and z stand side by side in a row of four, and an entry is read once for all of them.
struct FactorRows {
    std::size_t num_unknowns = 0;
    std::vector<std::int32_t> place; ///< (n) four times the place of each unknown in the order of L
    std::vector<Panel> panels;
    Aligned<std::int32_t> row;   ///< 16 for each block: four times the place; the one behind all others fills up
    Aligned<float> values;       ///< block after block, and in each column after column
    Aligned<float> x;            ///< (n + 1) rows of four: right-hand sides, and the solutions; zero behind all others
    Aligned<float> own, fetched; ///< space for the columns and the rows of a panel

    std::size_t bytes() const { return bytes_of(row, values, x); }
};

FactorRows factor_rows(const support::SupernodalFactor &factor);

/// Numbers of a spring at one of its nodes: from there to the other one at rest, length at rest, stiffness.
inline constexpr std::size_t numbers_of_spring = 5;

/// Springs at nodes for vector units, in single precision. 16 nodes stand side by side, and each spring stands at both
/// of its nodes: so nodes sum their own forces, and nothing is scattered. They are filled up with springs of no
/// stiffness.
struct SpringRows : NodeRows {
    std::vector<std::size_t> item_start; ///< (rows / 16 + 1) in units of 16: the k-th spring of nodes side by side
    Aligned<std::int32_t> other;         ///< four times the row of the other node
    Aligned<float> numbers;              ///< numbers_of_spring vectors of 16 for each
    Aligned<std::int32_t> self;          ///< (rows) four times the row
    Aligned<float> force;                ///< rows of four [N]
    PointSpringRows beside;

    std::size_t bytes() const {
        return NodeRows::bytes() + bytes_of(item_start, other, numbers, self, force) + beside.bytes();
    }
};

/// @param beside  more springs
SpringRows spring_rows(const Scene &scene, const Springs &springs, std::span<const PointSpring> beside);

/// Tetrahedra of densities::Projective, or springs.
using PrefactoredElements = std::variant<ExplicitRows, SpringRows>;

/// A body of Prefactored, its state, and its factor for one time step.
struct PrefactoredRows {
    explicit PrefactoredRows(PrefactoredElements body);

    NodeRows &nodes() {
        return std::visit([](auto &body) -> NodeRows & { return body; }, elements);
    }
    const NodeRows &nodes() const;
    std::size_t bytes() const; ///< of the body, its state and the factor
    Orders orders() const;     ///< of the body

    /// @param unknown    (N) of each node, -1 where constrained
    /// @param stiffness  (N) m (1 + alpha h) / h^2 [N/m]
    void set_factor(const support::SupernodalFactor &matrix, const std::vector<int> &unknown,
                    const std::vector<double> &stiffness);

    PrefactoredElements elements;
    FactorRows factor;
    /// (rows) where the row of a node is in the factor's x; behind all where it is not
    std::vector<std::int32_t> place;
    // Rows of four.
    Aligned<float> before;                 ///< displacement when a step began [m]
    Aligned<float> predicted;              ///< where nodes would be without elasticity [m]
    Aligned<float> stiffness;              ///< of inertia [N/m]
    Aligned<float> right;                  ///< right-hand sides [N]
    std::function<void()> after_iteration; ///< what else moves nodes; empty if there is nothing
};

/// A step as Prefactored takes it, in single precision on the vectors of the machine. Constrained nodes keep their
/// velocities.
/// @param time_step     h [s], that of the factor
/// @param mass_damping  alpha [1/s]
void take_prefactored_step(PrefactoredRows &rows, double time_step, double mass_damping, int iterations);

} // namespace livermark::interactive::kernels
