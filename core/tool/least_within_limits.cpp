#include "core/tool/least_within_limits.hpp"

namespace livermark::core {

namespace {

using Eigen::Index;

/// Number of times that the number of those on a wrong side may fail to fall before one alone changes sides.
constexpr int most_goes = 3;

} // namespace

/// x of the free entries, the others given.
void LeastWithinLimits::find_free(const Eigen::Ref<const Eigen::MatrixXd> &matrix) {
    const auto count = static_cast<Index>(free_.size());
    block_.resize(count, count);
    free_values_.resize(count);
    for (Index j = 0; j < count; ++j) {
        free_values_[j] = right_[free_[j]];
        for (Index i = j; i < count; ++i)
            block_(i, j) = matrix(free_[i], free_[j]);
    }
    factor_.compute(block_);
    factor_.solveInPlace(free_values_);
    for (Index j = 0; j < count; ++j)
        x_[free_[j]] = free_values_[j];
}

const Eigen::VectorXd &LeastWithinLimits::solve(const Eigen::Ref<const Eigen::MatrixXd> &matrix,
                                                const Eigen::Ref<const Eigen::VectorXd> &b,
                                                const Eigen::Ref<const Eigen::VectorXd> &low,
                                                const Eigen::Ref<const Eigen::VectorXd> &high) {
    const Index count = b.size();
    x_.resize(count);
    side_.resize(static_cast<std::size_t>(count), Side::free);
    if (count == 0)
        return x_;
    const double slack = 1e-12 * (b.cwiseAbs().maxCoeff() + 1e-300);
    Index fewest = count + 1;
    int goes = most_goes;
    while (true) {
        free_.clear();
        right_ = b;
        for (Index i = 0; i < count; ++i) {
            if (!(low[i] < high[i]))
                side_[i] = Side::low;
            if (side_[i] == Side::free) {
                free_.push_back(i);
                continue;
            }
            x_[i] = side_[i] == Side::low ? low[i] : high[i];
            right_ -= x_[i] * matrix.col(i);
        }
        if (!free_.empty())
            find_free(matrix);
        gradient_.noalias() = matrix * x_;
        gradient_ -= b;
        changes_.clear();
        for (Index i = 0; i < count; ++i) {
            if (side_[i] == Side::free && x_[i] < low[i])
                changes_.push_back({i, Side::low});
            else if (side_[i] == Side::free && x_[i] > high[i])
                changes_.push_back({i, Side::high});
            else if (low[i] < high[i] && ((side_[i] == Side::low && gradient_[i] < -slack) ||
                                          (side_[i] == Side::high && gradient_[i] > slack)))
                changes_.push_back({i, Side::free});
        }
        if (changes_.empty())
            return x_;
        const auto wrong = static_cast<Index>(changes_.size());
        if (wrong < fewest) {
            fewest = wrong;
            goes = most_goes;
        } else if (--goes < 0) {
            changes_.erase(changes_.begin(), changes_.end() - 1); // Murty's rule: it ends
        }
        for (const auto &[entry, to] : changes_)
            side_[entry] = to;
    }
}

Eigen::VectorXd least_within_limits(const Eigen::MatrixXd &matrix, const Eigen::VectorXd &b, const Eigen::VectorXd &low,
                                    const Eigen::VectorXd &high) {
    LeastWithinLimits one;
    return one.solve(matrix, b, low, high);
}

} // namespace livermark::core
