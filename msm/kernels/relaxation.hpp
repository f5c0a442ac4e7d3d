#pragma once

#include <vector>

#include "core/relaxation.hpp"
#include "msm/elastic_body.hpp"
#include "msm/kernels/layout/sliced_body.hpp"

namespace livermark::msm {

/// Turn of Maxwell branches. Each has a stress r that follows gain s, where s is the stress of
/// the elastic law: r += share (gain s - r). The stress that is left is s - at_once s - sum of r.
struct RelaxationShares {
    std::vector<double> share, gain; ///< (B)
    double at_once = 0.0;
    /// Whether the r of before are taken away in the next step, and not those of now.
    bool takes_former = false;
    double back = 0.0; ///< [s] how far positions are taken back along velocities before s is found
};

/// When branches of explicit steps have their turn, and what they do then. Symplectic Euler is drift, kick and drift
/// with half steps h / 2 between; velocities stand half a step before positions. Let q be what branches have taken off
/// the stress, dq/dt = (g s - q) / tau. It is held for m steps, and then relaxed exactly for the time m h where the
/// body is half a step before: a splitting of Strang's (1968, SIAM J. Numer. Anal. 5(3)) of motion and relaxation, of
/// second order in m h. Of a linear body, steps with q held keep
///     1/2 v^T (M - h^2 / 4 K) v + Q(x, q),   Q = 1/2 s.e - q.e + sum of q^2 / (2 g c),
/// at these half steps, with the stiffness K at once and s = c e; relaxation at fixed x and v makes Q smaller. So
/// steps that are stable without branches are stable with them, for every m and every tau, and this energy never grows.
///
/// As |g s - q| is at most 2 g times the largest |s|, what is held is wrong by at most sum of g (1 - exp(-m h / tau))
/// times that, to first order. m is chosen by it. If that is 1, branches move in every step, with s linear in
/// time over it: with gain = g (1 - exp(-x)) / x of x = h / tau, r = q - (g - gain) s obeys
/// r += (1 - exp(-x)) (gain s - r), and the stress at x(n) has the r of before.
///
/// Other integrators have velocities and positions at one time, and evaluate forces anew in every step. The same
/// splitting relaxes branches between two steps, where the body is, for every m: of second order in m h, or of the
/// order of the integrator if that is lower.
class RelaxationClock {
  public:
    RelaxationClock() = default;

    /// @param largest_error  of the stress, as a part of the largest one of the elastic law; not negative
    /// @param time_step      h [s], > 0
    /// @param is_staggered   whether velocities stand half a step before positions, as in symplectic Euler
    RelaxationClock(core::PronySeries series, double largest_error, double time_step, bool is_staggered);

    bool is_elastic() const { return series_.is_elastic(); }
    std::size_t num_branches() const { return series_.moduli.size(); }

    /// Branches have their turn before the next step.
    void set_time_step(double time_step);

    /// m
    int num_steps() const { return num_steps_; }
    /// Until branches have their turn.
    int steps_left() const { return steps_left_; }

    /// Turn before the next m steps.
    RelaxationShares turn();
    /// Turn if the body stays where it is for that long [s]. Branches have their turn before the next step.
    RelaxationShares stay(double time);
    void count(int steps);

  private:
    std::vector<double> shares_after(double time) const;
    bool moves_in_every_step() const { return is_staggered_ && num_steps_ == 1; }

    core::PronySeries series_;
    double largest_error_ = 0.0, time_step_ = 0.0;
    bool is_staggered_ = true;
    int num_steps_ = 1, steps_left_ = 0;
    double ahead_ = 0.0; ///< [s] by how much branches have gone on further than the body
};

/// The largest m for which sum of g (1 - exp(-m h / tau)) is at most that error; 1 if there is none.
int steps_between_turns(const core::PronySeries &series, double largest_error, double time_step);

/// Stresses that relax, one number for each component of each, and the r of their branches (RelaxationShares).
template <class T> struct RelaxingStresses {
    std::size_t size = 0;
    /// (B, size) r as the sum of both: a branch of a minute moves by less in a step than a float can tell. Of doubles
    /// there is no low one.
    Aligned<T> high, low;
    /// (size) what the next steps take off the stresses of the elastic law
    Aligned<T> faded;

    bool empty() const { return size == 0; }
};

/// Stresses of a body that relax, and their branches: see RelaxingTerm on which stresses do. Steps read
/// little of it, because what is held between two turns of the branches goes where elastic stresses are:
///
/// - The tension k (l - l0) - R of a spring is that of a longer one at rest, k l0 + R in SlicedBody::spring.
/// - Of a mean, six numbers are taken off its stress.
/// - Inside a tetrahedron the second Piola-Kirchhoff stress R pulls its corners by -V F R g, which is linear in
///   positions: corners i and j pull each other with V g_i . R g_j times what is between them. These add up, over the
///   tetrahedra of an edge, to the pulls that mu F inside tetrahedra has there too, of means of F around nodes
///   (slicing.hpp). Beside other means there are no such pulls, and it is taken off the stress inside; Hooke's springs
///   there pull along edges, and have the same.
template <class T> struct RelaxationArrays {
    RelaxationShares shares; ///< of the branches' turn now

    RelaxingStresses<T> springs; ///< (lines, 16) tensions at both ends [N]; without faded
    Aligned<T> rest_tension;     ///< (lines, 16) k l0 / 2 [N]

    /// (slices of control volumes, 6, 16) in the units of coupled_modulus, or (edge slices, 6, 16) of edge_modulus
    RelaxingStresses<T> means;

    /// (lines of fans, 6, 16) times their volumes [J]; not faded beside means of F around nodes, which have the
    /// following
    RelaxingStresses<T> tetrahedra;
    /// (lines of fans, 6, 16) of each tetrahedron, V g_i . R g_j of its edges: from the start of the axis to its end
    /// and to both nodes of the rim, and around these three [N/m]
    Aligned<T> pull;
    /// (lines, 16) of SlicedBody::mean_node: the elastic part of what stands in mean_gradient [N/m], and the places of
    /// the pulls to add, those of each from pull_start on
    Aligned<T> rest_stiffness;
    std::vector<int> pull_start, pull_place;

    bool empty() const { return springs.empty() && means.empty(); }
};

/// Without stress before.
/// @param plan  of the sliced body, whose parts are all there
template <class T>
RelaxationArrays<T> relaxation_arrays(const StepParts &parts, const SlicedPlan &plan, SlicedBody<T> &body,
                                      std::size_t num_branches);

/// Goes on without stress before, in the body too: what is no number would stay.
template <class T> void forget(RelaxationArrays<T> &arrays, SlicedBody<T> &body);

} // namespace livermark::msm
