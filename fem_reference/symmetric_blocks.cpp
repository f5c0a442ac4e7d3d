#include "fem_reference/symmetric_blocks.hpp"

#include <algorithm>

namespace livermark::fem_reference {

SymmetricBlocks::SymmetricBlocks(const SymmetricMatrix &matrix) {
    block_.reserve(num_blocks_below(matrix) + 1);
    rows_ = lower_rows(matrix, [&](int node, int other, const double *first, int stride) {
        auto &block = other == node ? diagonal_.emplace_back() : block_.emplace_back();
        for (int i = 0; i < 3; ++i)
            std::copy_n(first + i * stride, 3, &block[3 * i]);
    });
    block_.push_back({});
    diagonal_.push_back({});
}

LIVERMARK_WIDE_CLONES
void SymmetricBlocks::multiply(std::span<const double> x, std::span<double> out) const {
    std::vector<Padded<double>> in(rows_.node.size()), sum(rows_.node.size());
    for (std::size_t at = 0; at < rows_.node.size(); ++at)
        std::copy_n(&x[3 * static_cast<std::size_t>(rows_.node[at])], 3, in[at].data());
    for (std::size_t at = 0; at < rows_.node.size(); ++at) {
        RowSum<double> row;
        row.add(diagonal_[at].data(), in[at].data());
        for (int k = rows_.row_start[at]; k < rows_.row_start[at + 1]; ++k) {
            ask_ahead(&block_[k], 1);
            row.add(block_[k].data(), in[rows_.column[k]].data());
            add_transposed(block_[k].data(), in[at].data(), sum[rows_.column[k]].data());
        }
        const auto total = row.total();
        for (std::size_t i = 0; i < 3; ++i)
            sum[at][i] = total[i]; // what lies behind comes later
    }
    for (std::size_t at = 0; at < rows_.node.size(); ++at)
        std::copy_n(sum[at].data(), 3, &out[3 * static_cast<std::size_t>(rows_.node[at])]);
}

} // namespace livermark::fem_reference
