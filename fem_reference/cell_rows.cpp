#include "fem_reference/cell_rows.hpp"

#include <algorithm>
#include <cstddef>

namespace livermark::fem_reference {

namespace {

/// Where each row occurs in the rows of the cells, in their order.
struct Occurrences {
    std::vector<std::size_t> start; ///< (rows + 1) index into at
    std::vector<std::size_t> at;    ///< index into the rows of the cells
};

Occurrences occurrences(std::span<const int> rows, int num_rows) {
    Occurrences of{std::vector<std::size_t>(static_cast<std::size_t>(num_rows) + 1, 0), {}};
    for (const int row : rows)
        if (row >= 0)
            ++of.start[row + 1];
    for (int row = 0; row < num_rows; ++row)
        of.start[row + 1] += of.start[row];
    of.at.resize(of.start.back());
    auto next = of.start;
    for (std::size_t k = 0; k < rows.size(); ++k)
        if (rows[k] >= 0)
            of.at[next[rows[k]]++] = k;
    return of;
}

} // namespace

CellRows cell_rows(std::span<const int> rows, int rows_per_cell, int num_rows, std::span<const int> columns,
                   int columns_per_cell, int num_columns, CellEntries wanted) {
    const auto of = occurrences(rows, num_rows);
    CellRows result{{0}, {}, std::vector<int>(rows.size() * columns_per_cell, -1)};
    std::vector<int> last_row(num_columns, -1), place(num_columns); // of each column
    const auto for_each_column = [&](int row, const auto &action) {
        for (auto k = of.start[row]; k < of.start[row + 1]; ++k) {
            const auto cell = of.at[k] / static_cast<std::size_t>(rows_per_cell);
            for (int b = 0; b < columns_per_cell; ++b)
                if (const int column = columns[cell * columns_per_cell + b]; wanted == CellEntries::all || column < row)
                    action(column, of.at[k] * columns_per_cell + b);
        }
    };
    for (int row = 0; row < num_rows; ++row) {
        const auto first = static_cast<std::ptrdiff_t>(result.column.size());
        for_each_column(row, [&](int column, std::size_t /*pair*/) {
            if (last_row[column] != row) {
                last_row[column] = row;
                result.column.push_back(column);
            }
        });
        std::sort(result.column.begin() + first, result.column.end());
        for (auto at = static_cast<std::size_t>(first); at < result.column.size(); ++at)
            place[result.column[at]] = static_cast<int>(at);
        for_each_column(row, [&](int column, std::size_t pair) { result.place[pair] = place[column]; });
        result.row_start.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

} // namespace livermark::fem_reference
