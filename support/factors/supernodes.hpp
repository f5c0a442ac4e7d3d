#pragma once

#include <Eigen/Core>
#include <span>

namespace livermark::support {

/// Where the entries of a supernodal triangular factor L stand: columns of a supernode follow each other and have the
/// same rows, which begin with those of the columns themselves. Its values are a dense matrix, column by column. It is
/// CHOLMOD's own form, whose solves are in double precision only and go through all of L.
struct Supernodes {
    std::span<const int> first_column; ///< (S + 1)
    std::span<const int> row_start;    ///< (S + 1) index into row
    std::span<const int> row;
    std::span<const int> value_start; ///< (S + 1) index into the values
};

/// P A P^T = L L^T.
struct SupernodalFactor {
    Supernodes supernodes;
    std::span<const double> values; ///< of L
    std::span<const int> order;     ///< (n) of A, the row that each row of L is
};

/// x = L^-1 x. Supernodes that would multiply zeros alone are not read.
/// @param values  of L
/// @param x       shape (n, any)
template <class Scalar>
void solve_lower(const Supernodes &supernodes, std::span<const Scalar> values,
                 Eigen::Ref<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>> x);

/// x = L^-T x
template <class Scalar>
void solve_upper(const Supernodes &supernodes, std::span<const Scalar> values,
                 Eigen::Ref<Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>> x);

} // namespace livermark::support
