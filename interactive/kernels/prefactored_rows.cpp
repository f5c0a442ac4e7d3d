#include "interactive/kernels/prefactored_steps.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <utility>

namespace livermark::interactive::kernels {

namespace {

/// Panel of a supernode, shape (rows, columns).
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
        const auto panel_rows = all.row.subspan(all.row_start[s], all.row_start[s + 1] - all.row_start[s]);
        const Panel panel{.first_column = static_cast<std::size_t>(all.first_column[s]),
                          .num_columns = static_cast<std::size_t>(all.first_column[s + 1] - all.first_column[s]),
                          .first_block = rows.row.size() / slice_size,
                          .num_blocks = filled_up(panel_rows.size()) / slice_size,
                          .first_value = rows.values.size()};
        for (const int row : panel_rows)
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

namespace {

struct SpringAtNode {
    std::size_t spring;
    int other;
};

/// Numbers that fill up: of some length.
constexpr float numbers_of_no_spring[numbers_of_spring] = {1.0F, 0.0F, 0.0F, 1.0F, 0.0F};

} // namespace

SpringRows spring_rows(const Scene &scene, const Springs &springs) {
    const auto &mesh = scene.body->mesh;
    std::vector<std::vector<SpringAtNode>> at_node(mesh.points.size());
    std::vector<int> num_springs(mesh.points.size(), 0);
    for (std::size_t s = 0; s < springs.edges.size(); ++s)
        for (std::size_t end = 0; end < 2; ++end) {
            at_node[springs.edges[s][end]].push_back({s, springs.edges[s][1 - end]});
            ++num_springs[springs.edges[s][end]];
        }
    SpringRows rows;
    const bool has_order = scene.orders && scene.orders->rows.size() == mesh.points.size();
    const auto order = has_order ? scene.orders->rows : order_of_nodes(mesh.tetrahedra, {}, num_springs);
    rows.place(scene, order);
    rows.force.assign(4 * rows.num_rows, 0.0F);
    for (std::size_t row = 0; row < rows.num_rows; ++row)
        rows.self.push_back(static_cast<std::int32_t>(4 * row));
    rows.item_start.assign(1, 0);
    for (std::size_t first = 0; first < rows.num_rows; first += slice_size) {
        const std::size_t last = std::min(first + slice_size, order.size());
        std::size_t most = 0;
        for (std::size_t row = first; row < last; ++row)
            most = std::max(most, at_node[order[row]].size());
        for (std::size_t k = 0; k < most; ++k) {
            const std::size_t at = rows.numbers.size();
            rows.numbers.resize(at + numbers_of_spring * slice_size);
            for (std::size_t lane = 0; lane < slice_size; ++lane) {
                const std::size_t row = first + lane;
                const auto put = [&](const auto &numbers) {
                    for (std::size_t n = 0; n < numbers_of_spring; ++n)
                        rows.numbers[at + n * slice_size + lane] = static_cast<float>(numbers[n]);
                };
                if (row >= last || k >= at_node[order[row]].size()) {
                    rows.other.push_back(rows.self[row]);
                    put(numbers_of_no_spring);
                    continue;
                }
                const auto [spring, other] = at_node[order[row]][k];
                const core::Vector3 to_other = mesh.points[other] - mesh.points[order[row]];
                rows.other.push_back(4 * rows.row_of_node[other]);
                put(std::array{to_other.x(), to_other.y(), to_other.z(), springs.rest_length[spring],
                               springs.stiffness[spring]});
            }
        }
        rows.item_start.push_back(rows.item_start.back() + most);
    }
    return rows;
}

PrefactoredRows::PrefactoredRows(PrefactoredElements body) : elements(std::move(body)) {
    for (auto *field : {&before, &predicted, &stiffness, &right})
        field->assign(4 * nodes().num_rows, 0.0F);
}

const NodeRows &PrefactoredRows::nodes() const {
    return std::visit([](const auto &body) -> const NodeRows & { return body; }, elements);
}

std::size_t PrefactoredRows::bytes() const {
    return std::visit([](const auto &body) { return body.bytes(); }, elements) + factor.bytes() +
           bytes_of(place, before, predicted, stiffness, right);
}

Orders PrefactoredRows::orders() const {
    if (const auto *body = std::get_if<ExplicitRows>(&elements))
        return body->orders();
    Orders orders;
    orders.rows = nodes().order();
    return orders;
}

void PrefactoredRows::set_factor(const support::SupernodalFactor &matrix, const std::vector<int> &unknown,
                                 const std::vector<double> &inertia) {
    factor = factor_rows(matrix);
    place.assign(nodes().num_rows, static_cast<std::int32_t>(4 * factor.num_unknowns));
    for (std::size_t i = 0; i < unknown.size(); ++i) {
        const auto row = static_cast<std::size_t>(nodes().row_of_node[i]);
        if (unknown[i] >= 0)
            place[row] = factor.place[unknown[i]];
        std::fill_n(stiffness.begin() + static_cast<std::ptrdiff_t>(4 * row), 3, static_cast<float>(inertia[i]));
    }
}

} // namespace livermark::interactive::kernels
