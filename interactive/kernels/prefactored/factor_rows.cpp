#include "interactive/kernels/prefactored/factor_rows.hpp"

#include <Eigen/Dense>
#include <algorithm>

namespace livermark::interactive::kernels {

namespace {

/// Of a supernode, shape (rows, columns).
Eigen::MatrixXd panel_matrix(const support::SupernodalFactor &factor, std::size_t s) {
    const auto &[first_column, row_start, row, value_start] = factor.supernodes;
    const Eigen::Index num_columns = first_column[s + 1] - first_column[s], num_rows = row_start[s + 1] - row_start[s];
    Eigen::MatrixXd panel = Eigen::Map<const Eigen::MatrixXd>(&factor.values[value_start[s]], num_rows, num_columns);
    const Eigen::MatrixXd inverse = panel.topRows(num_columns)
                                        .triangularView<Eigen::Lower>()
                                        .solve(Eigen::MatrixXd::Identity(num_columns, num_columns));
    panel.topRows(num_columns) = inverse;
    // The inverse has a triangle of numbers only; what a column needs stands at and behind it, so it can be replaced.
    auto below = panel.bottomRows(num_rows - num_columns);
    for (Eigen::Index j = 0; j < num_columns; ++j) {
        below.col(j) *= -inverse(j, j);
        for (Eigen::Index k = j + 1; k < num_columns; ++k)
            below.col(j) -= inverse(k, j) * below.col(k);
    }
    return panel;
}

void place_panel(const Eigen::MatrixXd &matrix, const Panel &panel, Aligned<float> &values) {
    for (std::size_t block = 0; block < panel.num_blocks; ++block) {
        const auto first = static_cast<Eigen::Index>(block * slice_size);
        const auto num_lanes = std::min<Eigen::Index>(slice_size, matrix.rows() - first);
        std::size_t at = values.size();
        values.resize(at + panel.columns_of_block(block) * slice_size, 0.0F);
        const auto num_columns = std::min<std::size_t>(panel.columns_of_block(block), matrix.cols());
        for (std::size_t column = 0; column < num_columns; ++column, at += slice_size)
            Eigen::Map<Eigen::VectorXf>(values.data() + at, num_lanes) =
                matrix.col(static_cast<Eigen::Index>(column)).segment(first, num_lanes).cast<float>();
    }
}

} // namespace

FactorRows factor_rows(const support::SupernodalFactor &factor) {
    FactorRows rows;
    rows.num_unknowns = factor.order.size();
    rows.place.resize(rows.num_unknowns);
    for (std::size_t k = 0; k < rows.num_unknowns; ++k)
        rows.place[factor.order[k]] = static_cast<std::int32_t>(4 * k);
    rows.x.assign(4 * (rows.num_unknowns + 1), 0.0F);
    const auto &all = factor.supernodes;
    std::size_t most_columns = 0, most_blocks = 0;
    for (std::size_t s = 0; s + 1 < all.first_column.size(); ++s) {
        const auto of_panel = all.row.subspan(all.row_start[s], all.row_start[s + 1] - all.row_start[s]);
        const Panel panel{.first_column = static_cast<std::size_t>(all.first_column[s]),
                          .num_columns = static_cast<std::size_t>(all.first_column[s + 1] - all.first_column[s]),
                          .first_block = rows.row.size() / slice_size,
                          .num_blocks = filled_up(of_panel.size()) / slice_size,
                          .first_value = rows.values.size()};
        for (const int row : of_panel)
            rows.row.push_back(4 * row);
        rows.row.resize(filled_up(rows.row.size()), static_cast<std::int32_t>(4 * rows.num_unknowns));
        place_panel(panel_matrix(factor, s), panel, rows.values);
        most_columns = std::max(most_columns, panel.stored_columns());
        most_blocks = std::max(most_blocks, panel.num_blocks);
        rows.panels.push_back(panel);
    }
    rows.own.assign(4 * most_columns, 0.0F);
    rows.fetched.assign(3 * slice_size * most_blocks, 0.0F);
    return rows;
}

} // namespace livermark::interactive::kernels
