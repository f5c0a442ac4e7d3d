#pragma once

#include <cholmod.h>

#include <Eigen/SparseCore>

namespace livermark::support {

/// A matrix as CHOLMOD sees it, without a copy.
/// @param matrix        compressed; outlives the view
/// @param is_symmetric  of which the upper triangle is there
inline cholmod_sparse cholmod_view(const Eigen::Ref<const Eigen::SparseMatrix<double>> &matrix, bool is_symmetric) {
    cholmod_sparse view{};
    view.nrow = static_cast<std::size_t>(matrix.rows());
    view.ncol = static_cast<std::size_t>(matrix.cols());
    view.nzmax = static_cast<std::size_t>(matrix.nonZeros());
    // CHOLMOD's matrices are what it reads and what it writes.
    view.p = const_cast<int *>(matrix.outerIndexPtr());
    view.i = const_cast<int *>(matrix.innerIndexPtr());
    view.x = const_cast<double *>(matrix.valuePtr());
    view.stype = is_symmetric ? 1 : 0;
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    return view;
}

} // namespace livermark::support
