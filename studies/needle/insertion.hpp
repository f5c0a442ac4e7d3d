#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh/interior_place.hpp"
#include "core/tool/needle.hpp"

namespace livermark::studies {

/// Places on the axis of a needle, a third of their radius apart or a little less, from the entry on and some beyond
/// the target, which is one of them.
struct NeedleLine {
    std::vector<core::InteriorPlace> places; ///< (K)
    double spacing = 0.0;                    ///< [m]
    int target = 0;                          ///< number of its place
};

/// @param needle  whose target is some way below its entry
NeedleLine needle_line(const core::Needle &needle);

/// Drives a needle into a body that gives way as a matrix says, and draws it out again.
///
/// The body is elastic and linear, so all that is to be found is forces on the places: those of the shaft along the
/// axis, within friction times the length that each stands for; that of the tip, between nothing and what tears the
/// tissue; and those across, which hold the tissue at the shaft where it was when the tip passed. Where a force is
/// within its limits the tissue sticks to the needle, and at a limit it slides the way of the force (Coulomb's
/// condition with a given limit). These are the conditions of the least 1/2 f . C f - f . b within limits, which has
/// one solution. The tip advances where the tissue tears, until what it exerts is what tearing takes; after the surface
/// has given way it jumps.
/// @param compliance  C, shape (3 K, 3 K) of the places of the line [m/N], see core::Compliance
core::Insertion insert(const Eigen::MatrixXd &compliance, const NeedleLine &line, const core::Needle &needle);

/// The f of least 1/2 f . A f - b . f with low <= f <= high, by principal pivoting (Judice and Pires 1992, Basic-set
/// algorithm for a generalized linear complementarity problem, J. Optim. Theory Appl. 74).
/// @param matrix  A, symmetric and positive definite
Eigen::VectorXd least_within_limits(const Eigen::MatrixXd &matrix, const Eigen::VectorXd &b, const Eigen::VectorXd &low,
                                    const Eigen::VectorXd &high);

} // namespace livermark::studies
