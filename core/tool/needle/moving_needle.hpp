#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <array>
#include <functional>
#include <span>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/tool/least_within_limits.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::core {

/// Nodes of a body that moves in steps, as a needle in it sees them: one of each method of steps.
class MovingNodes {
  public:
    MovingNodes() = default;
    virtual ~MovingNodes() = default;
    MovingNodes(const MovingNodes &) = delete;
    MovingNodes &operator=(const MovingNodes &) = delete;

    /// Displacements of some nodes, as they are now [m].
    virtual void displacements(std::span<const int> nodes, std::span<Vector3> found) const = 0;

    /// Gives some nodes more velocity [m/s], and moves them on by as much in a step, as if a force had acted in the
    /// last one. Constrained nodes are given none.
    /// @param time_step  h of the last step [s]
    virtual void kick(std::span<const int> nodes, std::span<const Vector3> velocity, double time_step) = 0;
};

/// Action on the nodes of a body after each explicit step: a needle, say.
/// @param nodes  as the step has left them; kicks end up in positions and velocities
/// @param part   of the way of a longer step that is behind, up to 1
/// @param h      length of the step [s]
using AfterStep = std::function<void(MovingNodes &nodes, double part, double h)>;

/// For how long a damper beside needle_stiffness goes on [s].
inline constexpr double needle_damping_time = 1e-3;

/// Work since the needle began [J]. What the hand does is what the tissue takes up, as elastic and kinetic energy and
/// by its own damping, and the three losses.
struct NeedleWork {
    double hand = 0.0;     ///< of the hand
    double friction = 0.0; ///< lost along the shaft
    double tearing = 0.0;  ///< lost at the tip
    double holding = 0.0;  ///< lost where the tissue is held across the axis
};

/// The weights W of the places of a needle, shape (K, N).
using PlaceWeights = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// @throws std::invalid_argument if no point of the body is near a place
PlaceWeights place_weights(const Needle &needle, const TetraMesh &mesh);

/// A straight, rigid needle in a body that moves in steps: the mechanics of studies::insert() with inertia.
///
/// It acts on the places of needle_line(), which lie on the way from entry to target as it was at rest, so their
/// weights W (K, N) are found once and no step looks for tetrahedra. After each step it changes velocities by A^-1 W^T
/// J, and positions by h times that, with the impulses J that make it the step of Euler's method under implicit springs
/// and dampers,
///   J = -h k e' - h k tau v',  e' = e + h W A^-1 W^T J,  v' = v + W A^-1 W^T J,
/// e and v being what a place has moved from where it is held, and how fast, after the step. With 1 / b = h^2 k +
/// h k tau that is (W A^-1 W^T + b) J = -b (h k e + h k tau v). Between the limits
///   0 <= J_tip <= h G w, or h times the puncture force while the surface is whole, nothing in its own hole,
///   |J_k| <= h friction times the length of the shaft that place k stands for,
/// the tissue sticks to the needle, and at a limit it slides (Coulomb, stick and slip). Across the axis a place is held
/// where it was when the tip passed, without a limit, by softer springs where the needle has a side_stiffness.
///
/// A says what the body does with an impulse in a step:
/// - of explicit steps A = M, the masses of nodes. Steps may be as long as without a needle, since 4 M + (h^2 k + 2 h k
///   tau) W^T W - h^2 K stays positive where 4 M - h^2 K is.
/// - of implicit steps A is the matrix of the step, M (1 + alpha h) + h^2 K with K of the body at rest, or A^-1 W^T is
///   what the steps do that are taken, and forces last: the body takes its step under those of the step before,
///   nodal_forces(), and the needle changes what comes out by A^-1 W^T (J - J before). Where nothing moves, the body is
///   in its own equilibrium under the forces, whatever A is. What forces are wrong by becomes 1 - r times as much from
///   step to step, r being what the steps do over A^-1: beyond r = 2 it grows. (free motion and correction: Duriez et
///   al. 2006, Realistic haptic rendering of interacting deformable objects, IEEE TVCG 12(1), as in SOFA)
class MovingNeedle {
  public:
    /// In explicit steps.
    /// @param mesh      at rest, where the body is prepared
    /// @param per_mass  shape (N) 1 / m of the steps, as given and not scaled [1/kg]; zero where nothing moves
    /// @throws std::invalid_argument if no point of the body is near a place
    MovingNeedle(const Needle &needle, const TetraMesh &mesh, const std::vector<double> &per_mass);

    /// In implicit steps of one length.
    /// @param weights  W shape (K, N), from place_weights()
    /// @param columns  A^-1 W^T shape (3 N, 3 K) [1/kg], component c of node i in row 3 i + c, of place k in column
    ///                 3 k + c
    MovingNeedle(const Needle &needle, const PlaceWeights &weights, Eigen::MatrixXf columns);

    /// Sets other responses of implicit steps.
    /// @param columns  as above
    void respond_by(Eigen::MatrixXf columns);

    /// Begins outside, the tip at the entry as it is now.
    void begin(const MovingNodes &body);

    /// Acts on the last step. In a body that has diverged forces are not finite, and the tip stays
    /// where it was. Of explicit steps other than symplectic Euler it is a splitting of first order.
    /// @param depth      of the tip below the entry at rest, as the hand leads it, at the end of the step [m]
    /// @param time_step  h of that step [s]
    void act(MovingNodes &body, double depth, double time_step);

    double depth() const { return depth_; }         ///< of the tip below the entry at rest [m]
    double tip() const { return tip_; }             ///< how much of the tissue's path is behind it, at rest [m]
    double force() const { return force_; }         ///< of the hand, inwards, in the last step [N]
    double tip_force() const { return tip_force_; } ///< [N]
    bool is_punctured() const { return is_punctured_; }
    /// Adds what each place has got of the needle in the last step, on the tissue [N s].
    /// @param sum  shape (K), in the order of needle_line()
    void add_impulses(std::span<Vector3> sum) const;
    int num_places() const { return static_cast<int>(u_.rows()); } ///< K
    const NeedleWork &work() const { return work_; }
    const Needle &needle() const { return needle_; }
    /// Displacement of the tissue at the entry, inwards, after the last step [m].
    double entry_displacement() const { return u_(0, 0); }
    /// Displacement of the target: the mean over its place [m].
    Vector3 target_displacement(const MovingNodes &body) const;
    /// (K) the same of all places [m].
    std::vector<Vector3> place_displacements(const MovingNodes &body) const;
    /// Nodes that places have parts of, those near the entry first.
    const std::vector<int> &nodes() const { return nodes_; }
    /// Forces on these nodes in the next of implicit steps [N].
    const std::vector<Vector3> &nodal_forces() const { return nodal_forces_; }

  private:
    using Row = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;

    MovingNeedle(const Needle &needle, const PlaceWeights &weights);
    bool is_lasting() const { return columns_.size() > 0; }
    /// W A^-1 W^T of a direction of the frame.
    const Eigen::MatrixXd &places(int direction) const { return is_lasting() ? places_[direction] : places_[0]; }
    Vector3 mean_over(int place, const std::vector<Vector3> &node_values) const;
    int num_active() const;
    void read(const MovingNodes &body, int active);
    void take_back(int active, double time_step);
    void prepare(double time_step);
    void find_along(int touched, double depth, double time_step);
    void find_across(int held, double time_step);
    void kick(MovingNodes &body, int active, double time_step);
    void kick_all(MovingNodes &body, int active, double time_step);
    void move_on(int touched, int active, double time_step);
    void move_tip(double time_step, bool tears);
    double along_tip(const Row &field) const;
    double largest_tip_force() const;

    Needle needle_;
    NeedleLine line_;
    Eigen::Matrix3d frame_; // rows: the axis, and two directions across it

    // The weights of the places, (K) rows one after the other; nodes have the numbers of nodes_.
    std::vector<int> nodes_;                // (n) of the mesh
    std::vector<double> per_mass_;          // (n) [1/kg], of explicit steps
    std::vector<int> row_start_;            // (K + 1)
    std::vector<int> column_;               // of each weight
    std::vector<double> weight_;            // [1]
    std::vector<int> num_nodes_;            // (K + 1) of nodes_ that the first places have
    std::array<Eigen::MatrixXd, 3> places_; // (K, K) of each direction of the frame, one for all of explicit steps
    std::vector<int> band_;                 // (K) the first place that each has an entry with

    // Of implicit steps.
    Eigen::MatrixXf columns_;           // (3 N, 3 K) [1/kg]; empty of explicit steps
    std::vector<int> all_nodes_;        // (N)
    std::vector<Vector3> velocities_;   // (N) scratch [m/s]
    std::vector<Vector3> nodal_forces_; // (n) [N]

    double time_step_ = 0.0, softness_ = 0.0; // [s], b [1/kg]
    std::array<Eigen::LLT<Eigen::MatrixXd>, 2>
        across_factor_;     // of W A^-1 W^T + b; the first for both of explicit steps
    Eigen::MatrixXd along_; // (K + 1, K + 1) the same for the tip and the places of the shaft
    LeastWithinLimits within_limits_;
    Eigen::VectorXd right_, low_, high_, impulse_; // (K + 1) the tip first

    std::vector<Vector3> node_values_;              // (n) scratch
    Row u_, before_, impulses_, last_, change_;     // (K, 3) along the axis and across it [m], [N s], [m/s]
    Eigen::VectorXd stuck_at_;                      // (K) what u less the depth is held at, NaN of what does not touch
    Eigen::Matrix<double, Eigen::Dynamic, 2> hold_; // (K, 2) where it is held across [m]
    int num_held_ = 0, num_read_ = 0, num_lasting_ = 0;

    double depth_ = 0.0, tip_ = 0.0, deepest_ = 0.0, force_ = 0.0, tip_force_ = 0.0;
    bool is_punctured_ = false;
    NeedleWork work_;
};

} // namespace livermark::core
