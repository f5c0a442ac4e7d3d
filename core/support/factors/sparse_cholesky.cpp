#define EIGEN_USE_BLAS // as fast as CHOLMOD's own
#include "core/support/factors/sparse_cholesky.hpp"

#include <Eigen/Cholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <atomic>
#include <cholmod.h>
#include <cmath>
#include <cstddef>
#include <new>
#include <stdexcept>
#include <string>
#include <sys/mman.h>

#include "core/support/processes/own_process.hpp"

namespace livermark::support {

namespace {

/// Lets BLAS take its memory now if it has none yet in this process. OpenBLAS takes 128 MiB when it is called first,
/// and tries again for ever where it gets none.
/// @throws std::bad_alloc if there is not so much
void reserve_blas_memory() {
    static std::atomic<bool> is_there = false;
    if (is_there)
        return;
    constexpr std::size_t enough = std::size_t{160} << 20; // its buffer, with room around it
    void *probe = mmap(nullptr, enough, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (probe == MAP_FAILED) // NOLINT(performance-no-int-to-ptr): as POSIX has it
        throw std::bad_alloc();
    munmap(probe, enough);
    // The routine takes the buffer however small the matrix is, and BLAS keeps it for the calls to come.
    const auto lock = only_in_blas();
    const int size = 1;
    const double one = 1.0;
    double product = 0.0;
    dsyrk_("L", "N", &size, &size, &one, &one, &size, &one, &product, &size);
    is_there = true;
}

/// A symmetric matrix as CHOLMOD sees it, without a copy.
/// @param matrix  compressed, of which the upper triangle is there; outlives the view
cholmod_sparse cholmod_view(const SparseCholesky::Matrix &matrix) {
    cholmod_sparse view{};
    view.nrow = static_cast<std::size_t>(matrix.rows());
    view.ncol = static_cast<std::size_t>(matrix.cols());
    view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
    // CHOLMOD's matrices are what it reads and what it writes.
    view.p = const_cast<int *>(matrix.outerIndexPtr());
    view.i = const_cast<int *>(matrix.innerIndexPtr());
    view.x = const_cast<double *>(matrix.valuePtr());
    view.stype = 1; // the upper triangle
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
}

template <class Scalar> using DenseBlock = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

template <class Scalar> struct Supernode {
    Supernode(const Supernodes &all, std::span<const Scalar> values, std::size_t s)
        : first(all.first_column[s]), num_columns(all.first_column[s + 1] - first),
          below(all.row.subspan(all.row_start[s] + num_columns, all.row_start[s + 1] - all.row_start[s] - num_columns)),
          block(&values[all.value_start[s]], num_columns + std::ssize(below), num_columns) {}

    auto triangle() const { return block.topRows(num_columns); }
    auto rectangle() const { return block.bottomRows(std::ssize(below)); }

    int first;
    int num_columns;
    std::span<const int> below; ///< rows of the rectangle
    Eigen::Map<const DenseBlock<Scalar>> block;
};

/// Calls action with x and with space for the rows below any supernode. What is one column is a vector for Eigen, so
/// that it calls what BLAS has for vectors.
template <class Scalar, class Action>
void with_space(const Supernodes &supernodes, Eigen::Ref<DenseBlock<Scalar>> x, const Action &action) {
    Eigen::Index most = 0;
    for (std::size_t s = 0; s + 1 < supernodes.row_start.size(); ++s)
        most = std::max<Eigen::Index>(most, supernodes.row_start[s + 1] - supernodes.row_start[s]);
    DenseBlock<Scalar> space(most, x.cols());
    if (x.cols() == 1)
        action(x.col(0), space.col(0));
    else
        action(x, space);
}

/// x = L^-1 x. Supernodes that would multiply zeros alone are not read.
/// @param values  of L
/// @param x       shape (n, any)
template <class Scalar>
void solve_lower(const Supernodes &supernodes, std::span<const Scalar> values, Eigen::Ref<DenseBlock<Scalar>> x) {
    with_space<Scalar>(supernodes, x, [&](auto &&all, auto &&space) {
        for (std::size_t s = 0; s + 1 < supernodes.first_column.size(); ++s) {
            const Supernode<Scalar> node(supernodes, values, s);
            auto own = all.middleRows(node.first, node.num_columns);
            if ((own.array() == Scalar(0)).all())
                continue;
            node.triangle().template triangularView<Eigen::Lower>().solveInPlace(own);
            auto change = space.topRows(std::ssize(node.below));
            change.noalias() = node.rectangle() * own;
            for (Eigen::Index c = 0; c < change.cols(); ++c)
                for (Eigen::Index r = 0; r < change.rows(); ++r)
                    all(node.below[r], c) -= change(r, c);
        }
    });
}

/// x = L^-T x
template <class Scalar>
void solve_upper(const Supernodes &supernodes, std::span<const Scalar> values, Eigen::Ref<DenseBlock<Scalar>> x) {
    with_space<Scalar>(supernodes, x, [&](auto &&all, auto &&space) {
        for (std::size_t s = supernodes.first_column.size() - 1; s-- > 0;) {
            const Supernode<Scalar> node(supernodes, values, s);
            auto own = all.middleRows(node.first, node.num_columns);
            auto known = space.topRows(std::ssize(node.below));
            for (Eigen::Index c = 0; c < known.cols(); ++c)
                for (Eigen::Index r = 0; r < known.rows(); ++r)
                    known(r, c) = all(node.below[r], c);
            own.noalias() -= node.rectangle().transpose() * known;
            node.triangle().transpose().template triangularView<Eigen::Upper>().solveInPlace(own);
        }
    });
}

using Dense = Eigen::MatrixXd;

/// Unit vectors that are solved for at once.
constexpr Eigen::Index columns_at_once = 64;

} // namespace

struct SparseCholesky::Impl {
    Impl() {
        keep_openmp_in_this_thread();
        cholmod_start(&common);
        common.print = 0;
        // One ordering instead of the best of several, and one kind of factor: the same bits every time. Nested
        // dissection costs 77 GFlop for 70,000 unknowns of quadratic tetrahedra where minimum degree costs 264.
        common.nmethods = 1;
        common.method[0].ordering = CHOLMOD_METIS;
        common.supernodal = CHOLMOD_SUPERNODAL;
        common.useGPU = 0;
    }
    ~Impl() {
        cholmod_free_factor(&factor, &common);
        cholmod_finish(&common);
    }
    Impl(const Impl &) = delete;
    Impl &operator=(const Impl &) = delete;

    void check(const std::string &what, std::size_t num_rows) const {
        if (common.status == CHOLMOD_OUT_OF_MEMORY)
            throw std::bad_alloc();
        if (common.status < CHOLMOD_OK)
            throw std::runtime_error("CHOLMOD failed to " + what + " a matrix of " + std::to_string(num_rows) +
                                     " rows");
    }

    /// One of the parts of a solve.
    Dense solve(int part, Dense right_hand_sides) {
        cholmod_dense b{};
        b.nzmax = static_cast<std::size_t>(right_hand_sides.size());
        b.nrow = b.d = static_cast<std::size_t>(right_hand_sides.rows());
        b.ncol = static_cast<std::size_t>(right_hand_sides.cols());
        b.x = right_hand_sides.data();
        b.xtype = CHOLMOD_REAL;
        b.dtype = CHOLMOD_DOUBLE;
        cholmod_dense *x = cholmod_solve(part, factor, &b, &common);
        check("solve with", b.nrow);
        std::copy_n(static_cast<const double *>(x->x), x->nzmax, right_hand_sides.data());
        cholmod_free_dense(&x, &common);
        return right_hand_sides;
    }

    Supernodes supernodes() const {
        const auto span = [](const void *start, std::size_t size) {
            return std::span(static_cast<const int *>(start), size);
        };
        return {span(factor->super, factor->nsuper + 1), span(factor->pi, factor->nsuper + 1),
                span(factor->s, factor->ssize), span(factor->px, factor->nsuper + 1)};
    }
    std::span<const double> values() const { return {static_cast<const double *>(factor->x), factor->xsize}; }
    std::span<const int> order() const { return {static_cast<const int *>(factor->Perm), factor->n}; }

    /// Q of constrain(), which takes what is constrained out of L^-1 P b.
    void project(Dense &half) const {
        const Dense on_constrained = gram.solve(reach.transpose() * half);
        half.noalias() -= reach * on_constrained;
    }

    cholmod_common common{};
    cholmod_factor *factor = nullptr;
    std::vector<float> single; ///< values of the factor, empty if nobody has asked for them
    std::vector<int> constrained;
    Dense reach;            ///< (n, m) W = L^-1 P E
    Eigen::LLT<Dense> gram; ///< W^T W
};

SparseCholesky::SparseCholesky() : impl_(std::make_unique<Impl>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky &&) noexcept = default;
SparseCholesky &SparseCholesky::operator=(SparseCholesky &&) noexcept = default;

void SparseCholesky::order(const Matrix &matrix) {
    reserve_blas_memory();
    auto upper = cholmod_view(matrix);
    cholmod_free_factor(&impl_->factor, &impl_->common);
    {
        const auto lock = only_ordering();
        impl_->factor = cholmod_analyze(&upper, &impl_->common);
    }
    impl_->check("order", upper.nrow);
}

void SparseCholesky::order(const Matrix &matrix, std::span<const int> order) {
    reserve_blas_memory();
    auto upper = cholmod_view(matrix);
    cholmod_free_factor(&impl_->factor, &impl_->common);
    std::vector<int> given(order.begin(), order.end());
    impl_->common.method[0].ordering = CHOLMOD_GIVEN;
    impl_->factor = cholmod_analyze_p(&upper, given.data(), nullptr, 0, &impl_->common);
    impl_->common.method[0].ordering = CHOLMOD_METIS;
    impl_->check("order", upper.nrow);
}

bool SparseCholesky::factorise(const Matrix &matrix) {
    constrain({});
    impl_->single = {};
    auto upper = cholmod_view(matrix);
    const auto lock = only_in_blas();
    cholmod_factorize(&upper, impl_->factor, &impl_->common);
    impl_->check("factor", upper.nrow);
    return impl_->common.status == CHOLMOD_OK;
}

double SparseCholesky::pivot_ratio() const {
    return cholmod_rcond(impl_->factor, &impl_->common);
}

void SparseCholesky::constrain(std::vector<int> unknowns) {
    impl_->constrained = std::move(unknowns);
    const auto num_constrained = static_cast<Eigen::Index>(impl_->constrained.size());
    if (num_constrained == 0) {
        impl_->reach.resize(0, 0);
        return;
    }
    const auto lock = only_in_blas();
    const auto num_unknowns = static_cast<Eigen::Index>(impl_->factor->n);
    std::vector<Eigen::Index> place(num_unknowns);
    for (Eigen::Index k = 0; k < num_unknowns; ++k)
        place[impl_->order()[k]] = k;
    // Unknowns near each other in L reach the same supernodes.
    std::ranges::sort(impl_->constrained, {}, [&](int unknown) { return place[unknown]; });
    impl_->reach.setZero(num_unknowns, num_constrained);
    for (Eigen::Index c = 0; c < num_constrained; ++c)
        impl_->reach(place[impl_->constrained[c]], c) = 1.0;
    for (Eigen::Index first = 0; first < num_constrained; first += columns_at_once)
        solve_lower<double>(impl_->supernodes(), impl_->values(),
                            impl_->reach.middleCols(first, std::min(columns_at_once, num_constrained - first)));
    Dense gram = Dense::Zero(num_constrained, num_constrained);
    gram.selfadjointView<Eigen::Lower>().rankUpdate(impl_->reach.transpose());
    impl_->gram.compute(gram);
}

Eigen::MatrixXd SparseCholesky::solve(const Eigen::Ref<const Eigen::MatrixXd> &right_hand_sides) const {
    const auto lock = only_in_blas();
    if (impl_->constrained.empty())
        return impl_->solve(CHOLMOD_A, right_hand_sides);
    Dense half = impl_->solve(CHOLMOD_L, impl_->solve(CHOLMOD_P, right_hand_sides));
    impl_->project(half);
    Dense solutions = impl_->solve(CHOLMOD_Pt, impl_->solve(CHOLMOD_Lt, std::move(half)));
    for (const int unknown : impl_->constrained)
        solutions.row(unknown).setZero(); // they are, but for rounding
    return solutions;
}

Eigen::MatrixXd
SparseCholesky::solve_single_precision(const Eigen::Ref<const Eigen::MatrixXd> &right_hand_sides) const {
    const auto lock = only_in_blas();
    if (impl_->single.empty())
        impl_->single.assign(impl_->values().begin(), impl_->values().end());
    const auto order = impl_->order();
    const Eigen::RowVectorXd size = right_hand_sides.colwise().lpNorm<Eigen::Infinity>();
    Eigen::MatrixXf x(right_hand_sides.rows(), right_hand_sides.cols());
    for (Eigen::Index c = 0; c < x.cols(); ++c)
        for (Eigen::Index k = 0; k < x.rows(); ++k)
            x(k, c) = static_cast<float>(size[c] > 0.0 ? right_hand_sides(order[k], c) / size[c] : 0.0);
    solve_lower<float>(impl_->supernodes(), impl_->single, x);
    if (!impl_->constrained.empty()) {
        Dense half = x.cast<double>();
        impl_->project(half);
        x = half.cast<float>();
    }
    solve_upper<float>(impl_->supernodes(), impl_->single, x);
    Dense solutions(x.rows(), x.cols());
    for (Eigen::Index c = 0; c < x.cols(); ++c)
        for (Eigen::Index k = 0; k < x.rows(); ++k)
            solutions(order[k], c) = size[c] * static_cast<double>(x(k, c));
    for (const int unknown : impl_->constrained)
        solutions.row(unknown).setZero();
    return solutions;
}

SupernodalFactor SparseCholesky::factor() const {
    return {impl_->supernodes(), impl_->values(), impl_->order()};
}

std::optional<std::vector<int>> unknowns_to_constrain(const std::vector<bool> &has, const std::vector<bool> &free) {
    std::vector<int> constrained;
    int num_unknowns = 0;
    for (std::size_t i = 0; i < has.size(); ++i) {
        if (free[i] && !has[i])
            return std::nullopt;
        if (has[i] && !free[i])
            constrained.push_back(num_unknowns);
        num_unknowns += has[i] ? 1 : 0;
    }
    // In three dimensions n unknowns take some n^2 operations to factor, and n^(4/3) to solve for. The part was
    // measured at 70,000 unknowns.
    constexpr double part = 0.2;
    if (static_cast<double>(constrained.size()) > part * std::pow(num_unknowns, 2.0 / 3.0))
        return std::nullopt;
    return constrained;
}

} // namespace livermark::support
