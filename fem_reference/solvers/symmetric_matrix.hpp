#pragma once

#include <vector>

namespace livermark::fem_reference {

/// A symmetric sparse matrix in compressed rows (or columns, it is the same): both triangles, columns ascending.
struct SymmetricMatrix {
    std::vector<int> row_start; ///< (n + 1) index into column and value
    std::vector<int> column;    ///< (nonzeros)
    std::vector<double> value;  ///< (nonzeros)

    int num_rows() const { return static_cast<int>(row_start.size()) - 1; }
};

} // namespace livermark::fem_reference
