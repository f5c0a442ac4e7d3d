#include "interactive/elements/prefactored.hpp"

#include <stdexcept>

namespace livermark::interactive {

void Prefactored::factorise(const Inertia &terms, double time_step) {
    unknown_.assign(terms.stiffness.size(), -1);
    num_unknowns_ = 0;
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (is_free()[i])
            unknown_[i] = num_unknowns_++;
    Energy::Triplets all;
    add_laplacian(all);
    Energy::Triplets kept;
    for (const auto &entry : all)
        if (unknown_[entry.row()] >= 0 && unknown_[entry.col()] >= unknown_[entry.row()])
            kept.emplace_back(unknown_[entry.row()], unknown_[entry.col()], entry.value());
    for (std::size_t i = 0; i < unknown_.size(); ++i)
        if (unknown_[i] >= 0)
            kept.emplace_back(unknown_[i], unknown_[i], terms.stiffness[i]);
    Eigen::SparseMatrix<double> matrix(num_unknowns_, num_unknowns_);
    matrix.setFromTriplets(kept.begin(), kept.end());
    factor_.order(matrix);
    if (!factor_.factorise(matrix))
        throw std::logic_error("the matrix of projective dynamics is not positive definite");
    factorised_for_ = time_step;
}

void Prefactored::step(double time_step, int iterations) {
    auto &x = mutable_positions();
    const Field before = x;
    const auto terms = inertia(*this, time_step);
    if (time_step != factorised_for_)
        factorise(terms, time_step);
    x = terms.predicted;
    Field forces(3, x.cols());
    Eigen::MatrixXd right(num_unknowns_, 3);
    for (int k = 0; k < iterations && num_unknowns_ > 0; ++k) {
        forces.setZero();
        energy().add_forces(x, forces);
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            if (unknown_[i] >= 0)
                right.row(unknown_[i]) =
                    (forces.col(i) - terms.stiffness[i] * (x.col(i) - terms.predicted.col(i))).transpose();
        const Eigen::MatrixXd move = factor_.solve(right);
        for (Eigen::Index i = 0; i < x.cols(); ++i)
            if (unknown_[i] >= 0)
                x.col(i) += move.row(unknown_[i]).transpose();
    }
    mutable_velocities() = (x - before) / time_step;
}

} // namespace livermark::interactive
