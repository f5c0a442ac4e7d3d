#include "fem_reference/dynamics/ritz_space.hpp"

#include <cmath>

#include "fem_reference/dynamics/mass_matrix.hpp"

namespace livermark::fem_reference {

namespace {

/// What is left of a vector when the space is taken out of it, below which it is but rounding of what was taken out.
constexpr double rounding = 1e-12;
/// More than a motion takes as a rule: growing would go through the memory again, and what is not used costs nothing.
constexpr Eigen::Index columns_at_once = 128;
/// Nearly all of the motion is in the first vectors, so they are found in double precision; the others may be a little
/// off the way, as what they leave out is looked at.
constexpr Eigen::Index num_exact = 5;

} // namespace

RitzSpace::RitzSpace(const SymmetricBlocks<double> &stiffness, const SymmetricMatrix &mass, ConstrainedSolver &solver,
                     std::vector<double> force)
    : stiffness_(stiffness), mass_(mass), solver_(solver), force_(std::move(force)), next_load_(force_),
      vector_(force_.size()), product_(force_.size()), vectors_(force_.size(), 0) {}

bool RitzSpace::extend() {
    const auto num_unknowns = static_cast<Eigen::Index>(force_.size());
    Eigen::Map<Eigen::VectorXd> vector(vector_.data(), num_unknowns), product(product_.data(), num_unknowns);
    if (size() < num_exact)
        solver_.solve_constrained(next_load_, vector_);
    else
        solver_.solve_single_precision(next_load_, vector_);
    multiply_mass(mass_, vector_, product_);
    const double size_before = std::sqrt(vector.dot(product));
    // Twice is enough (W. Kahan, in B. N. Parlett 1980, The symmetric eigenvalue problem, 6-9); once is not, because
    // the rounding of one vector grows in those after it.
    for (int pass = 0; pass < 2; ++pass) {
        const Eigen::VectorXd component = vectors().transpose() * product;
        vector.noalias() -= vectors() * component;
        multiply_mass(mass_, vector_, product_);
    }
    const double left = std::sqrt(vector.dot(product));
    if (!(left > rounding * size_before))
        return false;
    vector /= left;
    Eigen::Map<Eigen::VectorXd>(next_load_.data(), num_unknowns) = product / left;

    const auto last = size();
    if (last == vectors_.cols())
        vectors_.conservativeResize(Eigen::NoChange, last + columns_at_once);
    vectors_.col(last) = vector;
    force_on_space_.conservativeResize(last + 1);
    force_on_space_[last] = dot(vector_, force_);
    stiffness_.multiply(vector_, product_);
    stiffness_of_space_.conservativeResize(last + 1, last + 1);
    stiffness_of_space_.col(last) = vectors_.leftCols(last + 1).transpose() * product;
    stiffness_of_space_.row(last) = stiffness_of_space_.col(last).transpose();
    return true;
}

} // namespace livermark::fem_reference
