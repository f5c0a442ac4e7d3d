#pragma once

#include <Eigen/Core>

#include "fem_reference/solvers/matrices.hpp"

namespace livermark::tests {

inline Eigen::MatrixXd dense(const fem_reference::DivergenceRows<double> &matrix, Eigen::Index num_columns) {
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(matrix.num_rows()), num_columns);
    for (std::size_t row = 0; row < matrix.num_rows(); ++row)
        for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
            for (int i = 0; i < 3; ++i)
                full(static_cast<Eigen::Index>(row), 3 * matrix.column[k] + i) = matrix.value[k][i];
    return full;
}

} // namespace livermark::tests
