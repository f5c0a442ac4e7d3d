#pragma once

#include <vector>

#include "msm/dynamics/step_parts.hpp"
#include "msm/kernels/layout/sliced_body.hpp"
#include "msm/kernels/relaxation/relaxation_clock.hpp"

namespace livermark::msm {

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

/// What a body has beside its elastic parts so that it relaxes: see RelaxingTerm on which stresses do. Steps read
/// little of it, because what is held between two turns of the branches goes where elastic stresses are:
///
/// - The tension k (l - l0) - R of a spring is that of a longer one at rest, k l0 + R in SlicedBody::spring.
/// - Of a mean, six numbers are taken off its stress.
/// - Inside a tetrahedron the second Piola-Kirchhoff stress R pulls its corners by -V F R g, which is linear in
///   positions: corners i and j pull each other with V g_i . R g_j times what is between them. These add up, over the
///   tetrahedra of an edge, to the pulls that mu F inside tetrahedra has there too (mean_gradients.hpp). Beside means
///   of C around nodes there are no such pulls, and it is taken off the stress inside; Hooke's springs there pull along
///   edges, and have the same.
template <class T> struct RelaxationArrays {
    RelaxationShares shares; ///< of the branches' turn now

    RelaxingStresses<T> springs; ///< (lines, 16) tensions at both ends [N]; without faded
    Aligned<T> rest_tension;     ///< (lines, 16) k l0 / 2 [N]

    /// (slices of control volumes, 6, 16) in the units of coupled_modulus, or (slices of stars, 6, 16) of star_modulus
    RelaxingStresses<T> means;

    /// (lines of fans, 6, 16) times their volumes [J]; faded beside means of C around nodes alone, the following beside
    /// others
    RelaxingStresses<T> tetrahedra;
    /// (lines of fans, 6, 16) of each tetrahedron, V g_i . R g_j of its edges: from the start of the axis to its end
    /// and to both nodes of the rim, and around these three [N/m]
    Aligned<T> pull;
    /// (lines, 16) of SlicedBody::mean_node, or (stars): the elastic part of what stands in mean_gradient or
    /// star_stiffness [N/m], and the places of the pulls to add, those of each from pull_start on
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
