#include "fem_reference/block_gauss_seidel.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace livermark::fem_reference {

namespace {

Block<float> rounded(const Eigen::Matrix3d &block) {
    Block<float> result;
    Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(result.data()) = block.cast<float>();
    return result;
}

Padded<float> rounded(const double *components) {
    return {static_cast<float>(components[0]), static_cast<float>(components[1]), static_cast<float>(components[2])};
}

/// What a node comes to when its row is solved for it.
[[gnu::always_inline]] inline Padded<float> solved(const float *inverse_diagonal, const double *right_hand_side,
                                                   const std::array<float, 3> &others) {
    const float left[4]{static_cast<float>(right_hand_side[0]) - others[0],
                        static_cast<float>(right_hand_side[1]) - others[1],
                        static_cast<float>(right_hand_side[2]) - others[2], 0.0F};
    RowSum<float> sum;
    sum.add(inverse_diagonal, left);
    const auto total = sum.total();
    return {total[0], total[1], total[2]};
}

} // namespace

BlockGaussSeidel::BlockGaussSeidel(const SymmetricMatrix &matrix, const std::vector<bool> &is_free) {
    block_.reserve(num_blocks_below(matrix) + 1);
    rows_ = lower_rows(matrix, [&](int node, int other, const double *first, int stride) {
        Eigen::Matrix3d block;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                block(i, j) = is_free[3 * node + i] && is_free[3 * other + j] ? first[i * stride + j]
                                                                              : (node == other && i == j ? 1.0 : 0.0);
        if (node == other)
            inverse_diagonal_.push_back(rounded(block.inverse()));
        else
            block_.push_back(rounded(block));
    });
    block_.push_back({});
    inverse_diagonal_.push_back({});
    now_.resize(rows_.node.size());
    taken_.resize(rows_.node.size());
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_forward_from_zero(std::span<const double> right_hand_side, std::span<double> u,
                                               std::span<double> residual) {
    std::ranges::fill(taken_, Padded<float>{});
    for (std::size_t at = 0; at < rows_.node.size(); ++at) {
        RowSum<float> before;
        for (int k = rows_.row_start[at]; k < rows_.row_start[at + 1]; ++k) {
            ask_ahead(&block_[k], 1);
            before.add(block_[k].data(), now_[rows_.column[k]].data());
        }
        const auto dof = 3 * static_cast<std::size_t>(rows_.node[at]);
        now_[at] = solved(inverse_diagonal_[at].data(), &right_hand_side[dof], before.total());
        for (int k = rows_.row_start[at]; k < rows_.row_start[at + 1]; ++k)
            add_transposed(block_[k].data(), now_[at].data(), taken_[rows_.column[k]].data());
        std::copy_n(now_[at].data(), 3, &u[dof]);
    }
    // A sweep leaves of each row only what lies behind the diagonal.
    for (std::size_t at = 0; at < rows_.node.size(); ++at)
        for (std::size_t i = 0; i < 3; ++i)
            residual[3 * static_cast<std::size_t>(rows_.node[at]) + i] = -taken_[at][i];
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_backward(std::span<const double> right_hand_side, std::span<double> u) {
    for (std::size_t at = 0; at < rows_.node.size(); ++at)
        now_[at] = rounded(&u[3 * static_cast<std::size_t>(rows_.node[at])]);
    std::ranges::fill(taken_, Padded<float>{});
    for (std::size_t at = rows_.node.size(); at-- > 0;) {
        RowSum<float> before;
        for (int k = rows_.row_start[at + 1] - 1; k >= rows_.row_start[at]; --k) {
            ask_ahead(&block_[k], -1);
            before.add(block_[k].data(), now_[rows_.column[k]].data());
        }
        auto others = before.total();
        for (std::size_t i = 0; i < 3; ++i)
            others[i] += taken_[at][i];
        const auto dof = 3 * static_cast<std::size_t>(rows_.node[at]);
        now_[at] = solved(inverse_diagonal_[at].data(), &right_hand_side[dof], others);
        for (int k = rows_.row_start[at + 1] - 1; k >= rows_.row_start[at]; --k)
            add_transposed(block_[k].data(), now_[at].data(), taken_[rows_.column[k]].data());
        std::copy_n(now_[at].data(), 3, &u[dof]);
    }
}

} // namespace livermark::fem_reference
