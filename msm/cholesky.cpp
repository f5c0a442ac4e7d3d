#include "msm/cholesky.hpp"

#include <Eigen/CholmodSupport>

#include "core/openmp.hpp"

namespace livermark::msm {

struct Cholesky::Impl {
    Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>> solver;
    bool is_ordered = false;
};

Cholesky::Cholesky() : impl_(std::make_unique<Impl>()) {
    core::keep_openmp_in_this_thread();
    auto &common = impl_->solver.cholmod();
    common.print = 0;
    common.nmethods = 1;
    common.method[0].ordering = CHOLMOD_METIS;
}
Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky &&) noexcept = default;
Cholesky &Cholesky::operator=(Cholesky &&) noexcept = default;

bool Cholesky::factorize(const Eigen::SparseMatrix<double> &matrix) {
    if (!impl_->is_ordered)
        impl_->solver.analyzePattern(matrix);
    impl_->is_ordered = true;
    impl_->solver.factorize(matrix);
    return impl_->solver.info() == Eigen::Success;
}

Eigen::VectorXd Cholesky::solve(const Eigen::VectorXd &right_hand_side) const {
    return impl_->solver.solve(right_hand_side);
}

} // namespace livermark::msm
