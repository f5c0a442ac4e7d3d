#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/load_case.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/relaxation.hpp"

namespace livermark::msm {

// Arrays and functions of selective mass scaling (msm/dynamics/time_step.hpp) in vector units.

/// A part whose masses are scaled, one component behind the other, each filled up to whole slices by nodes without
/// mass. Positions are from any point near the part: float has too few digits for those of a body.
template <class T> struct ScaledMassArrays {
    std::size_t size = 0;     ///< of a component, n and what fills it up
    std::size_t num_slow = 0; ///< m
    Aligned<T> mass;          ///< (size) [kg]
    Aligned<T> rest;          ///< (3, size) [m]
    Aligned<T> slow;          ///< (m, 3, size) deformations that are left alone [kg^-1/2]
    Aligned<T> x;             ///< (3, size) where a step starts [m]; after strays(), from the centre of mass
    Aligned<T> v;             ///< (3, size) there [m/s]
    Aligned<T> a;             ///< (3, size) M^-1 F [m/s^2]
    Aligned<T> stray;         ///< (3, size) what of these is to be scaled [m/s^2]
};

/// A part between steps, of n nodes.
template <class T> struct ScaledMassPart {
    ScaledMassArrays<T> arrays;
    double factor = 1.0;
    std::vector<std::size_t> row;                            ///< (n) of each node
    std::vector<std::pair<std::size_t, std::size_t>> copies; ///< number in the part, and another row of the node
    std::array<std::vector<double>, 3> before;               ///< (n) velocities when a step began [m/s]
    std::vector<double> mass, own_mass;                      ///< (n) now, and that of the tissue alone [kg]
    double total_mass = 0.0;                                 ///< [kg]
    core::Vector3 rest_centre = core::Vector3::Zero();       ///< of masses [m]
    bool is_weighed = false;                                 ///< whether what follows is that of the masses now
    bool is_loaded = false;                                  ///< whether a mass differs from that of the tissue
    Eigen::LLT<Eigen::MatrixXd> gram;                        ///< of slow deformations in the masses now
    std::vector<double> weights;                             ///< (m)
};

/// Sums over the nodes of a part; a moment of two fields is sum of m p q^T.
struct ScaledMassSums {
    core::Vector3 sum_x, sum_v, sum_a;            ///< sums of m x, m v, m a
    Eigen::Matrix3d x_and_x, x_and_rest, x_and_v; ///< moments
    core::Vector3 x_cross_a;                      ///< sum of m x x a
};

/// The rigid motion of a part, and the rigid part of its accelerations less those of turning.
struct ScaledMassMotion {
    core::Vector3 centre;                ///< of mass, from where x is from [m]
    core::Vector3 velocity, rotation;    ///< [m/s], [rad/s]
    core::Vector3 acceleration, spin_up; ///< [m/s^2], [rad/s^2]
    Eigen::Matrix3d turn;                ///< since rest
};

/// Momentum of slow deformations.
struct SlowMomenta {
    core::Vector3 linear, angular; ///< sums of m e and m x x e
};

template <class T> struct ScaledMassFunctions {
    ScaledMassSums (*sums)(const ScaledMassArrays<T> &part);
    /// Moves x to the centre of mass, and puts into stray what a is besides a rigid motion and turning,
    ///   a - w x (2 (v - v_c) - w x x) - a_c - w' x x.
    /// @param weights  (m) sum of m slow_k . turn^T stray of each slow deformation
    void (*find_strays)(ScaledMassArrays<T> &part, const ScaledMassMotion &motion, std::vector<double> &weights);
    /// Takes e = turn (sum of weight_k slow_k) off stray.
    SlowMomenta (*subtract_slow)(ScaledMassArrays<T> &part, const Eigen::Matrix3d &turn,
                                 const std::vector<double> &weights);
};

/// In the widest vectors that the machine has.
template <class T> ScaledMassFunctions<T> scaled_mass_functions();

struct FastStepOptions;
struct MassScaling;
struct RowMap;

/// Way of an explicit integrator from one force to the next.
struct StepScheme {
    enum class Kind { symplectic_euler, velocity_verlet, runge_kutta, runge_kutta_chebyshev };
    Kind kind = Kind::symplectic_euler;
    /// Weights of Runge-Kutta methods whose stages each start from the one before: what each stage adds to the step,
    /// and where the next one stands, both as parts of the step.
    std::vector<double> weight{1.0};
    std::vector<double> next{};
    std::vector<ChebyshevStage> chebyshev{}; ///< of Runge-Kutta-Chebyshev methods
    /// Bound of a component of a velocity, of symplectic Euler [m/s]; see FastStepOptions.
    double largest_speed = std::numeric_limits<double>::infinity();
    int num_stages() const {
        if (kind == Kind::runge_kutta_chebyshev)
            return static_cast<int>(chebyshev.size());
        return kind == Kind::velocity_verlet ? 2 : static_cast<int>(weight.size());
    }
};

/// A vector at each node of a slice, one component behind the other.
template <class T> using SliceField = std::array<std::array<T, slice_size>, 3>;

/// The same to twice the digits where T has few: what many small steps add up to. (Dekker 1971, Numer. Math. 18)
template <class T> struct FineField {
    SliceField<T> high;
    void set(std::size_t component, std::size_t lane, double value) { high[component][lane] = static_cast<T>(value); }
    double get(std::size_t component, std::size_t lane) const { return high[component][lane]; }
    double less(const FineField &other, std::size_t component, std::size_t lane) const {
        return get(component, lane) - other.get(component, lane);
    }
};
template <> struct FineField<float> {
    SliceField<float> high, low; ///< their sum is meant, of which high is what a float can hold
    void set(std::size_t component, std::size_t lane, double value) {
        high[component][lane] = static_cast<float>(value);
        low[component][lane] = static_cast<float>(value - double{high[component][lane]});
    }
    double get(std::size_t component, std::size_t lane) const {
        return double{high[component][lane]} + double{low[component][lane]};
    }
    /// This less another, of which nothing is lost where they are about the same.
    double less(const FineField &other, std::size_t component, std::size_t lane) const {
        return (double{high[component][lane]} - double{other.high[component][lane]}) +
               (double{low[component][lane]} - double{other.low[component][lane]});
    }
};

/// Nodes of one slice.
template <class T> struct alignas(64) NodeSlice {
    FineField<T> position;       ///< x less the origin [m]
    FineField<T> velocity;       ///< [m/s]
    SliceField<T> free_per_mass; ///< 1/m [1/kg], 0 where constrained
};

/// State of methods of several stages between these; see schemes-inl.hpp.
template <class T> struct alignas(64) StageSlice {
    SliceField<T> acceleration; ///< at the stage before
    SliceField<T> for_position; ///< sums of accelerations
    SliceField<T> for_velocity;
};

/// State of Runge-Kutta-Chebyshev methods between their stages; see schemes-inl.hpp.
template <class T> struct alignas(64) ChebyshevSlice {
    SliceField<T> first_acceleration;
    /// Changes of position and velocity by accelerations, at one stage and at the one before, which take turns.
    std::array<SliceField<T>, 2> for_position, for_velocity;
};

/// Part of the work that one thread does.
struct Partition {
    int first = 0, last = 0;
};

/// Cache lines of rows.
struct CacheLines {
    std::vector<int> index;  ///< of the first number of each
    std::size_t at_once = 0; ///< how many to ask for before each pair of slices
};

/// Pairs of slices that one thread moves. Those come last whose springs end at nodes of other threads: until then these
/// have time to move theirs, and what they have written has time to come.
struct PairPartition {
    std::vector<int> order;
    std::size_t num_interior = 0;
    CacheLines ghost;  ///< rows of other threads that it reads
    CacheLines shared; ///< its own rows that others read
};

/// Everything that the steps of a body read and write.
template <class T> struct StepWorkspace {
    SlicedBody<T> body;
    StepScheme scheme;
    double time_step = 0.0;
    double alpha = 0.0, beta = 0.0; ///< Rayleigh damping
    double least_stretch = 0.0;     ///< see FastStepOptions

    StepFunctions<T> coupled;       ///< of the energy of springs that are coupled
    RelaxationArrays<T> relaxation; ///< empty if nothing relaxes

    std::vector<NodeSlice<T>> nodes;
    std::vector<SliceField<T>> loads;                ///< [N]; empty if there are none
    std::vector<StageSlice<T>> stages;               ///< empty for one stage
    std::vector<ChebyshevSlice<T>> chebyshev_stages; ///< empty for other methods
    /// Input of forces, (rows + 1, 4) each: x, y, z and pressure; velocities, where stiffness damps. One is
    /// read while the other is written.
    std::array<Aligned<T>, 2> rows, velocity_rows;
    int now = 0; ///< which of the two is read when the next steps begin
    /// (corners of fans + 16) volume gained by the tetrahedra of a fan at each of its corners, and zeros for nobody's
    /// [m^3]
    Aligned<T> gain;
    /// The same of beta times how fast it grows, where stiffness damps springs with means of F or around edges; gain
    /// has it elsewhere
    Aligned<T> gain_rate;
    /// (lines * 16 + 1, 8) of springs that are coupled: volume times the strain of each tetrahedron, xx yy zz xy yz zx,
    /// and the volume that it has gained; zeros for nobody's [m^3]
    Aligned<T> strain;
    /// (corners of fans + 16, 4) each, with means of C: sums over the tetrahedra of a fan at each of its corners
    /// of the volume times twice the strain, xx yy zz xy and yz zx, with the volume gained [m^3]; the same of their
    /// rates times beta, where stiffness damps
    std::array<Aligned<T>, 2> corner_strain, corner_rate;
    /// (rows + 1, 4) each: a quarter of the stress around each node, xx yy zz xy and yz zx 0 0 [Pa]; not with means of
    /// F
    std::array<Aligned<T>, 2> stress;
    /// (lines, 16) with means of C or F, a sixth of what pushes the corners of each tetrahedron outwards because of
    /// its volume: springs inside and the guard [Pa]
    Aligned<T> push;
    /// (volumes) beside springs around edges, relative changes of control volumes, beta times how fast they grow, and a
    /// quarter of the pressure that the means of both make [Pa], before it is averaged in turn
    Aligned<T> change, change_rate, mean_push;
    /// (lines * 16 + 1, long_row()) beside springs around edges: volume times what the mean is taken of, of each
    /// tetrahedron [m^3], and the same of its rate times beta, where stiffness damps; zeros for nobody's
    Aligned<T> tetrahedron_strain, tetrahedron_rate;
    /// (edge slices * 16, long_row()) a sixth of the stress of each edge [Pa]
    Aligned<T> edge_stress;
    /// (places of all chunks and one that stays zero, 4) [N]; with means of F also (places, 4) from first_pull on
    Aligned<T> corner_force;
    /// (fan slices, slices of control volumes, and of edges) the most that a tetrahedron lacked of the volume that is
    /// watched [m^3], and that det C around a node lacked, see LargestDeficit; 0 where nothing did, empty if
    /// nothing is watched
    std::vector<T> deficit;

    std::vector<PairPartition> pairs;                                      ///< of each thread
    std::vector<Partition> fan_slices, volume_slices, edge_slices, chunks; ///< of each thread
};

/// Selective mass scaling of steps of symplectic Euler on vector units. The kernels take a step with the
/// masses as they are, v + h a and x + h (v + h a). This puts a scaled acceleration in the place of a: that of
/// scale_acceleration(), in the precision of the forces.
template <class T> class ScaledMassSteps {
  public:
    ScaledMassSteps() = default;
    /// @param at  between steps; its scheme is symplectic Euler
    ScaledMassSteps(const MassScaling &scaling, const StepWorkspace<T> &at);

    bool empty() const { return parts_.empty(); }

    /// Gives a node another mass from now on; nothing happens where it belongs to no part.
    void set_mass(std::size_t row, double mass);

    /// Scales the part of a node no more.
    /// @return rows of its nodes, none if the node belongs to no part
    std::vector<std::size_t> leave(std::size_t row);

    /// Moves copies of rows to where they are now.
    void move_copies(const RowMap &map);

    /// Before a step.
    void remember(const StepWorkspace<T> &at);

    /// After it.
    void correct(StepWorkspace<T> &at);

  private:
    std::vector<ScaledMassPart<T>> parts_;
    std::vector<std::pair<std::size_t, std::size_t>> place_of_row_; ///< part, and number in it
};

/// Lays a body out for steps, with room for all that these write. Nodes have no mass and stand at zero as yet.
/// @param at_rest       shape (N) [m], less their mean
/// @param num_branches  of what relaxes; 0 if nothing does
/// @param num_threads   that will take the steps
/// @param plan          told where everything went if options.may_be_cut, or if something relaxes
template <class T>
StepWorkspace<T> make_workspace(const StepParts &parts, const std::vector<core::Vector3> &at_rest,
                                const StepScheme &scheme, const core::RayleighDamping &damping, double time_step,
                                const FastStepOptions &options, std::size_t num_branches, int num_threads,
                                SlicedPlan &plan);

/// For what part_sliced_body() has added to the body. Nodes keep their places, and new ones stand at zero as yet, with
/// no mass.
template <class T> void make_room_after_parting(const RowMap &map, int num_threads, StepWorkspace<T> &at);

/// Memory that every step reads or writes [bytes].
template <class T> std::size_t working_set(const StepWorkspace<T> &at);

/// Takes steps, with the widest vectors that the machine has; every thread of a pool calls it. The result does not
/// depend on how many there are: everything is written by one thread, from what was there before a barrier.
template <class T> void take_steps(StepWorkspace<T> &workspace, int thread, int num_steps, Barrier &barrier);

/// The turn of branches between steps, as RelaxationArrays::shares says; every thread of a pool calls it.
template <class T> void relax_stresses(StepWorkspace<T> &workspace, int thread, Barrier &barrier);

} // namespace livermark::msm
