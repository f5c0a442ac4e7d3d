#include "fem_reference/symmetric_blocks.hpp"

#include <algorithm>

namespace livermark::fem_reference {

SymmetricBlocks::SymmetricBlocks(const SymmetricMatrix &matrix) {
    const int num_nodes = matrix.num_rows() / 3;
    const auto about = (matrix.column.size() / 9 + num_nodes) / 2;
    column_.reserve(about);
    block_.reserve(about);
    row_start_.push_back(0);
    for (int node = 0; node < num_nodes; ++node) {
        const int begin = matrix.row_start[3 * node];
        const int length = matrix.row_start[3 * node + 1] - begin;
        for (int k = 0; k < length; k += 3) {
            const int other = matrix.column[begin + k] / 3;
            if (other < node)
                continue;
            column_.push_back(other);
            auto &block = block_.emplace_back();
            for (int i = 0; i < 3; ++i)
                std::copy_n(&matrix.value[begin + i * length + k], 3, &block[3 * i]);
        }
        row_start_.push_back(static_cast<int>(column_.size()));
    }
}

void SymmetricBlocks::multiply(std::span<const double> x, std::span<double> out) const {
    std::ranges::fill(out, 0.0);
    const auto num_nodes = static_cast<int>(row_start_.size()) - 1;
    for (int node = 0; node < num_nodes; ++node) {
        const double x0 = x[3 * node], x1 = x[3 * node + 1], x2 = x[3 * node + 2];
        double sum[3]{};
        for (int k = row_start_[node]; k < row_start_[node + 1]; ++k) {
            const auto &b = block_[k];
            const double *const other = &x[3 * column_[k]];
            for (int i = 0; i < 3; ++i)
                sum[i] += b[3 * i] * other[0] + b[3 * i + 1] * other[1] + b[3 * i + 2] * other[2];
            if (k == row_start_[node])
                continue; // the diagonal block is its own mirror image
            double *const mirrored = &out[3 * column_[k]];
            for (int j = 0; j < 3; ++j)
                mirrored[j] += b[j] * x0 + b[3 + j] * x1 + b[6 + j] * x2;
        }
        for (int i = 0; i < 3; ++i)
            out[3 * node + i] += sum[i];
    }
}

} // namespace livermark::fem_reference
