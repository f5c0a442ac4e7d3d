#include "fem_reference/dynamics/ritz_space.hpp"

#include <cmath>
#include <utility>

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
    : stiffness_(&stiffness), mass_(mass), solver_(&solver), force_(std::move(force)), next_load_(force_),
      vector_(force_.size()), product_(force_.size()), vectors_(force_.size(), 0) {}

RitzSpace::RitzSpace(const SymmetricMatrix &mass, SolveStatics solve, std::vector<double> force)
    : mass_(mass), solve_statics_(std::move(solve)), force_(std::move(force)), next_load_(force_),
      vector_(force_.size()), product_(force_.size()), force_of_vector_(force_.size()), vectors_(force_.size(), 0),
      forces_(force_.size(), 0) {}

void RitzSpace::solve() {
    if (solve_statics_)
        solve_statics_(next_load_, vector_, force_of_vector_);
    else if (size() < num_exact)
        solver_->solve_constrained(next_load_, vector_);
    else
        solver_->solve_single_precision(next_load_, vector_);
}

/// Takes the space out of what was solved, and makes its size 1; its product with M is beside it.
/// @return false if nothing is left
bool RitzSpace::make_orthogonal() {
    const auto num_unknowns = static_cast<Eigen::Index>(force_.size());
    Eigen::Map<Eigen::VectorXd> vector(vector_.data(), num_unknowns), product(product_.data(), num_unknowns),
        force(force_of_vector_.data(), std::ssize(force_of_vector_));
    multiply_mass(mass_, vector_, product_);
    const double size_before = std::sqrt(vector.dot(product));
    // Twice is enough (W. Kahan, in B. N. Parlett 1980, The symmetric eigenvalue problem, 6-9); once is not, because
    // the rounding of one vector grows in those after it.
    for (int pass = 0; pass < 2; ++pass) {
        const Eigen::VectorXd component = vectors().transpose() * product;
        vector.noalias() -= vectors() * component;
        if (solve_statics_)
            force.noalias() -= forces_.leftCols(size()) * component;
        multiply_mass(mass_, vector_, product_);
    }
    const double left = std::sqrt(vector.dot(product));
    if (!(left > rounding * size_before))
        return false;
    vector /= left;
    product /= left;
    force /= left;
    return true;
}

bool RitzSpace::extend() {
    const auto num_unknowns = static_cast<Eigen::Index>(force_.size());
    solve();
    if (!make_orthogonal())
        return false;
    next_load_ = product_;

    const auto last = size();
    if (last == vectors_.cols()) {
        vectors_.conservativeResize(Eigen::NoChange, last + columns_at_once);
        if (solve_statics_)
            forces_.conservativeResize(Eigen::NoChange, last + columns_at_once);
    }
    vectors_.col(last) = Eigen::VectorXd::Map(vector_.data(), num_unknowns);
    force_on_space_.conservativeResize(last + 1);
    force_on_space_[last] = dot(vector_, force_);
    if (solve_statics_) {
        forces_.col(last) = Eigen::VectorXd::Map(force_of_vector_.data(), num_unknowns);
        product_ = force_of_vector_;
    } else {
        stiffness_->multiply(vector_, product_);
    }
    stiffness_of_space_.conservativeResize(last + 1, last + 1);
    stiffness_of_space_.col(last) =
        vectors_.leftCols(last + 1).transpose() * Eigen::VectorXd::Map(product_.data(), num_unknowns);
    stiffness_of_space_.row(last) = stiffness_of_space_.col(last).transpose();
    return true;
}

} // namespace livermark::fem_reference
