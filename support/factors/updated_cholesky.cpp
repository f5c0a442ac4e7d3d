#include "support/factors/updated_cholesky.hpp"

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <stdexcept>
#include <string>

#include "support/factors/blas_memory.hpp"
#include "support/factors/cholmod_view.hpp"
#include "support/factors/orderings.hpp"
#include "support/openmp.hpp"

namespace livermark::support {

struct UpdatedCholesky::Impl {
    Impl() {
        keep_openmp_in_this_thread();
        cholmod_start(&common);
        common.print = 0;
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
        common.supernodal = CHOLMOD_SIMPLICIAL;
        common.final_ll = 0;
    }
    ~Impl() {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    void check(const std::string &what) const {
        if (common.status == CHOLMOD_OUT_OF_MEMORY)
            throw std::bad_alloc();
        if (common.status < CHOLMOD_OK)
            throw std::runtime_error("CHOLMOD failed to " + what);
    }

    cholmod_common common{};
    cholmod_factor *factor = nullptr;
};

UpdatedCholesky::UpdatedCholesky(const Matrix &matrix) : impl_(std::make_unique<Impl>()) {
    auto upper = cholmod_view(matrix, true);
    {
        const auto lock = only_ordering();
        impl_->factor = cholmod_analyze(&upper, &impl_->common);
    }
    impl_->check("order a matrix");
    const auto in_blas = only_in_blas();
    cholmod_factorize(&upper, impl_->factor, &impl_->common);
    impl_->check("factor a matrix");
}

UpdatedCholesky::~UpdatedCholesky() = default;
UpdatedCholesky::UpdatedCholesky(UpdatedCholesky &&) noexcept = default;
UpdatedCholesky &UpdatedCholesky::operator=(UpdatedCholesky &&) noexcept = default;

void UpdatedCholesky::add(const Matrix &columns) {
    change(true, columns);
}
void UpdatedCholesky::subtract(const Matrix &columns) {
    change(false, columns);
}

void UpdatedCholesky::change(bool adds, const Matrix &columns) {
    auto view = cholmod_view(columns, false);
    // The factor is of the permuted matrix.
    auto *permuted =
        cholmod_submatrix(&view, static_cast<int *>(impl_->factor->Perm),
                          static_cast<SuiteSparse_long>(impl_->factor->n), nullptr, -1, 1, 1, &impl_->common);
    impl_->check("permute columns");
    const auto lock = only_in_blas();
    cholmod_updown(adds ? 1 : 0, permuted, impl_->factor, &impl_->common);
    cholmod_free_sparse(&permuted, &impl_->common);
    impl_->check("change a factor");
}

Eigen::VectorXd UpdatedCholesky::solve(const Eigen::VectorXd &right_hand_side) const {
    Eigen::VectorXd solution = right_hand_side;
    cholmod_dense b{};
    b.nzmax = b.nrow = b.d = static_cast<std::size_t>(solution.size());
    b.ncol = 1;
    b.x = solution.data();
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    const auto lock = only_in_blas();
    cholmod_dense *x = cholmod_solve(CHOLMOD_A, impl_->factor, &b, &impl_->common);
    impl_->check("solve");
    std::copy_n(static_cast<const double *>(x->x), x->nzmax, solution.data());
    cholmod_free_dense(&x, &impl_->common);
    return solution;
}

} // namespace livermark::support
