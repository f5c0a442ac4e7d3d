#include "fem_reference/block_gauss_seidel.hpp"

#include <Eigen/LU>

namespace livermark::fem_reference {

namespace {

Eigen::Vector3f at(std::span<const double> vector, int node) {
    return Eigen::Vector3d::Map(vector.data() + 3 * node).cast<float>();
}

void put(std::span<double> vector, int node, const Eigen::Vector3f &value) {
    Eigen::Vector3d::Map(vector.data() + 3 * node) = value.cast<double>();
}

} // namespace

BlockGaussSeidel::BlockGaussSeidel(const SymmetricMatrix &matrix, const std::vector<bool> &is_free) {
    const int num_nodes = matrix.num_rows() / 3;
    row_start_.push_back(0);
    column_.reserve(matrix.column.size() / 9);
    block_.reserve(matrix.column.size() / 9);
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
                inverse_diagonal_.push_back(block.inverse().cast<float>());
            }
            column_.push_back(other);
            block_.push_back(block.cast<float>());
        }
        row_start_.push_back(static_cast<int>(column_.size()));
    }
}

void BlockGaussSeidel::sweep_forward_from_zero(std::span<const double> right_hand_side, std::span<double> u) const {
    for (int node = 0; node + 1 < static_cast<int>(row_start_.size()); ++node) {
        Eigen::Vector3f sum = at(right_hand_side, node);
        for (int k = row_start_[node]; k < diagonal_[node]; ++k)
            sum.noalias() -= block_[k] * at(u, column_[k]);
        put(u, node, inverse_diagonal_[node] * sum);
    }
}

void BlockGaussSeidel::residual_after_forward(std::span<const double> u, std::span<double> residual) const {
    for (int node = 0; node + 1 < static_cast<int>(row_start_.size()); ++node) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int k = diagonal_[node] + 1; k < row_start_[node + 1]; ++k)
            sum.noalias() -= block_[k] * at(u, column_[k]);
        put(residual, node, sum);
    }
}

void BlockGaussSeidel::sweep_backward(std::span<const double> right_hand_side, std::span<double> u) const {
    for (int node = static_cast<int>(row_start_.size()) - 2; node >= 0; --node) {
        Eigen::Vector3f sum = at(right_hand_side, node);
        for (int k = row_start_[node]; k < row_start_[node + 1]; ++k)
            if (k != diagonal_[node])
                sum.noalias() -= block_[k] * at(u, column_[k]);
        put(u, node, inverse_diagonal_[node] * sum);
    }
}

} // namespace livermark::fem_reference
