#pragma once

#include <span>
#include <vector>

namespace livermark::fem_reference {

/// Which entries of a sparse matrix have numbers of the same cell as their row and column, and where those of each cell
/// stand, so that an assembly looks for none.
struct CellRows {
    std::vector<int> row_start; ///< (rows + 1)
    std::vector<int> column;    ///< (entries) ascending in each row
    std::vector<int> place;     ///< (M, a cell's rows, its columns) index into column; -1 of what has no entry
};

/// Which entries are wanted.
enum class CellEntries { all, below_diagonal };

/// @param rows     (M, rows_per_cell) numbers of the rows that a cell adds to, different ones; -1 of none
/// @param columns  (M, columns_per_cell) numbers of its columns, none below 0 where it has a row
CellRows cell_rows(std::span<const int> rows, int rows_per_cell, int num_rows, std::span<const int> columns,
                   int columns_per_cell, int num_columns, CellEntries wanted = CellEntries::all);

} // namespace livermark::fem_reference
