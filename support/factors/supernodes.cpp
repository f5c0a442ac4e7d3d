#define EIGEN_USE_BLAS // as fast as CHOLMOD's own
#include "support/factors/supernodes.hpp"

#include <algorithm>

namespace livermark::support {

namespace {

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

} // namespace

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

template void solve_lower(const Supernodes &, std::span<const float>, Eigen::Ref<DenseBlock<float>>);
template void solve_upper(const Supernodes &, std::span<const float>, Eigen::Ref<DenseBlock<float>>);
template void solve_lower(const Supernodes &, std::span<const double>, Eigen::Ref<DenseBlock<double>>);

} // namespace livermark::support
