#include "fem_reference/block_gauss_seidel.hpp"

#include <Eigen/LU>

namespace livermark::fem_reference {

namespace {

Eigen::Vector4f padded(const double *components) {
    Eigen::Vector4f result = Eigen::Vector4f::Zero();
    result.head<3>() = Eigen::Vector3d::Map(components).cast<float>();
    return result;
}

Eigen::Matrix<float, 4, 3> padded(const Eigen::Matrix3d &block) {
    Eigen::Matrix<float, 4, 3> result = Eigen::Matrix<float, 4, 3>::Zero();
    result.topRows<3>() = block.cast<float>();
    return result;
}

Eigen::Vector4f times(const Eigen::Matrix<float, 4, 3> &block, const Eigen::Vector4f &vector) {
    return block.col(0) * vector[0] + block.col(1) * vector[1] + block.col(2) * vector[2];
}

} // namespace

BlockGaussSeidel::BlockGaussSeidel(const SymmetricMatrix &matrix, const std::vector<bool> &is_free) {
    const int num_nodes = matrix.num_rows() / 3;
    row_start_.push_back(0);
    column_.reserve(matrix.column.size() / 9);
    block_.reserve(matrix.column.size() + 1);
    for (int node = 0; node < num_nodes; ++node) {
        const int begin = matrix.row_start[3 * node];
        const int length = matrix.row_start[3 * node + 1] - begin;
        for (int k = 0; k < length; k += 3) {
            const int other = matrix.column[begin + k] / 3;
            Eigen::Matrix3d block;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j)
                    block(i, j) = is_free[3 * node + i] && is_free[3 * other + j]
                                      ? matrix.value[begin + i * length + k + j]
                                      : (node == other && i == j ? 1.0 : 0.0);
            if (node == other) {
                diagonal_.push_back(static_cast<int>(column_.size()));
                inverse_diagonal_.push_back(padded(block.inverse()));
            }
            column_.push_back(other);
            const Eigen::Matrix3f rounded = block.cast<float>();
            block_.insert(block_.end(), rounded.data(), rounded.data() + rounded.size());
        }
        row_start_.push_back(static_cast<int>(column_.size()));
    }
    block_.push_back(0.0F);
    now_.assign(static_cast<std::size_t>(num_nodes), Padded::Zero());
}

BlockGaussSeidel::Padded BlockGaussSeidel::less_block(const Padded &sum, int k) const {
    const float *const block = &block_[9 * static_cast<std::size_t>(k)];
    const auto &other = now_[column_[k]];
    return sum - (Eigen::Vector4f::Map(block) * other[0] + Eigen::Vector4f::Map(block + 3) * other[1] +
                  Eigen::Vector4f::Map(block + 6) * other[2]);
}

BlockGaussSeidel::Padded BlockGaussSeidel::less_blocks(Padded sum, int begin, int end) const {
    for (int k = begin; k < end; ++k)
        sum = less_block(sum, k);
    return sum;
}

BlockGaussSeidel::Padded BlockGaussSeidel::less_blocks_from_the_last(Padded sum, int begin, int end) const {
    for (int k = end - 1; k >= begin; --k)
        sum = less_block(sum, k);
    return sum;
}

void BlockGaussSeidel::load(std::span<const double> u) {
    for (std::size_t node = 0; node < now_.size(); ++node)
        now_[node] = padded(&u[3 * node]);
}

void BlockGaussSeidel::put(int node, const Padded &value, std::span<double> u) {
    now_[node] = value;
    Eigen::Vector3d::Map(u.data() + 3 * node) = value.head<3>().cast<double>();
}

void BlockGaussSeidel::sweep_forward_from_zero(std::span<const double> right_hand_side, std::span<double> u) {
    for (int node = 0; node < static_cast<int>(now_.size()); ++node)
        put(node,
            times(inverse_diagonal_[node],
                  less_blocks(padded(&right_hand_side[3 * node]), row_start_[node], diagonal_[node])),
            u);
}

void BlockGaussSeidel::residual_after_forward(std::span<const double> u, std::span<double> residual) {
    load(u);
    for (int node = 0; node < static_cast<int>(now_.size()); ++node)
        Eigen::Vector3d::Map(residual.data() + 3 * node) =
            less_blocks(Padded::Zero(), diagonal_[node] + 1, row_start_[node + 1]).head<3>().cast<double>();
}

void BlockGaussSeidel::sweep_backward(std::span<const double> right_hand_side, std::span<double> u) {
    load(u);
    for (int node = static_cast<int>(now_.size()) - 1; node >= 0; --node) {
        const Padded behind =
            less_blocks_from_the_last(padded(&right_hand_side[3 * node]), diagonal_[node] + 1, row_start_[node + 1]);
        put(node, times(inverse_diagonal_[node], less_blocks_from_the_last(behind, row_start_[node], diagonal_[node])),
            u);
    }
}

} // namespace livermark::fem_reference
