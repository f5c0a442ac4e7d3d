#pragma once

#include <utility>
#include <vector>

#include "interactive/kernels/node_rows.hpp"
#include "interactive/scene.hpp"

namespace livermark::interactive {

/// The three numbers of a node in rows of four.
inline Eigen::Map<Eigen::Vector3f> in_row(kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}
inline Eigen::Map<const Eigen::Vector3f> in_row(const kernels::Aligned<float> &rows, int row) {
    return Eigen::Map<const Eigen::Vector3f>(rows.data() + 4 * static_cast<Eigen::Index>(row));
}

/// A row in single precision, and where it is measured from, as one vector in double precision.
class FineRow {
  public:
    FineRow(core::Vector3 origin, Eigen::Map<Eigen::Vector3f> row) : origin_(std::move(origin)), row_(row) {}
    operator core::Vector3() const { return origin_ + row_.cast<double>(); } // NOLINT(google-explicit-constructor)
    void operator+=(const core::Vector3 &change) { row_ = (row_.cast<double>() + change).cast<float>(); }

  private:
    core::Vector3 origin_;
    Eigen::Map<Eigen::Vector3f> row_;
};

/// @param row_of_node  (N)
inline void put_into_rows(const Field &field, const std::vector<int> &row_of_node, kernels::Aligned<float> &rows) {
    for (Eigen::Index i = 0; i < field.cols(); ++i)
        in_row(rows, row_of_node[i]) = field.col(i).cast<float>();
}

inline void take_from_rows(const kernels::Aligned<float> &rows, const std::vector<int> &row_of_node, Field &field) {
    for (Eigen::Index i = 0; i < field.cols(); ++i)
        field.col(i) = in_row(rows, row_of_node[i]).cast<double>();
}

} // namespace livermark::interactive
