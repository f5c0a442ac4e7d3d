#include "fem_reference/symmetric_blocks.hpp"

#include <algorithm>

#include "fem_reference/node_order.hpp"

namespace livermark::fem_reference {

SymmetricBlocks::SymmetricBlocks(const SymmetricMatrix &matrix) : node_(order_by_distance(matrix)) {
    std::vector<int> place(node_.size());
    for (std::size_t at = 0; at < node_.size(); ++at)
        place[node_[at]] = static_cast<int>(at);
    const auto num_below = (matrix.column.size() / 9 - node_.size()) / 2;
    column_.reserve(num_below);
    block_.reserve(num_below + 1);
    diagonal_.reserve(node_.size() + 1);
    row_start_.push_back(0);
    for (const int node : node_) {
        const int begin = matrix.row_start[3 * node];
        const int length = matrix.row_start[3 * node + 1] - begin;
        for (int k = 0; k < length; k += 3) {
            const int other = matrix.column[begin + k] / 3;
            if (place[other] > place[node])
                continue;
            auto &block = other == node ? diagonal_.emplace_back() : block_.emplace_back();
            for (int i = 0; i < 3; ++i)
                std::copy_n(&matrix.value[begin + i * length + k], 3, &block[3 * i]);
            if (other != node)
                column_.push_back(place[other]);
        }
        row_start_.push_back(static_cast<int>(column_.size()));
    }
    block_.push_back({});
    diagonal_.push_back({});
}

LIVERMARK_WIDE_CLONES
void SymmetricBlocks::multiply(std::span<const double> x, std::span<double> out) const {
    std::vector<Padded<double>> in(node_.size()), sum(node_.size());
    for (std::size_t at = 0; at < node_.size(); ++at)
        std::copy_n(&x[3 * static_cast<std::size_t>(node_[at])], 3, in[at].data());
    for (std::size_t at = 0; at < node_.size(); ++at) {
        RowSum<double> row;
        row.add(diagonal_[at].data(), in[at].data());
        for (int k = row_start_[at]; k < row_start_[at + 1]; ++k) {
            ask_ahead(&block_[k], 1);
            row.add(block_[k].data(), in[column_[k]].data());
            add_transposed(block_[k].data(), in[at].data(), sum[column_[k]].data());
        }
        const auto total = row.total();
        for (std::size_t i = 0; i < 3; ++i)
            sum[at][i] = total[i]; // what lies behind comes later
    }
    for (std::size_t at = 0; at < node_.size(); ++at)
        std::copy_n(sum[at].data(), 3, &out[3 * static_cast<std::size_t>(node_[at])]);
}

} // namespace livermark::fem_reference
