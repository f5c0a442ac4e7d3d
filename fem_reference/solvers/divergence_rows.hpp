#pragma once

#include <array>
#include <span>
#include <vector>

namespace livermark::fem_reference {

/// A matrix D of m pressures and 3 n displacements, by rows: all three components of a node stand together.
/// @tparam T  double, or float where products may be rough: that is little more than half of the bytes
template <class T> struct DivergenceRows {
    std::vector<int> row_start;          ///< (m + 1) index into column and value
    std::vector<int> column;             ///< (nodes of all rows) ascending in each row
    std::vector<std::array<T, 3>> value; ///< (nodes of all rows) of the components of the node

    std::size_t num_rows() const { return row_start.size() - 1; }

    /// out_c = D u_c - g_c
    /// @param u       shape (3 n, lanes), see multivector.hpp
    /// @param g, out  shape (m, lanes)
    void subtract_product(std::span<const T> u, std::span<const T> g, std::span<T> out, int lanes) const;

    /// force_c += D^T p_c, and imbalance_c = D u_c - imbalance_c
    /// @param u, force      shape (3 n, lanes)
    /// @param p, imbalance  shape (m, lanes)
    void add_products(std::span<const T> u, std::span<const T> p, std::span<T> force, std::span<T> imbalance,
                      int lanes) const;
};

template <>
void DivergenceRows<float>::subtract_product(std::span<const float> u, std::span<const float> g, std::span<float> out,
                                             int lanes) const;
template <>
void DivergenceRows<float>::add_products(std::span<const float> u, std::span<const float> p, std::span<float> force,
                                         std::span<float> imbalance, int lanes) const;
template <>
void DivergenceRows<double>::subtract_product(std::span<const double> u, std::span<const double> g,
                                              std::span<double> out, int lanes) const;
template <>
void DivergenceRows<double>::add_products(std::span<const double> u, std::span<const double> p, std::span<double> force,
                                          std::span<double> imbalance, int lanes) const;

DivergenceRows<float> rounded(const DivergenceRows<double> &matrix);

} // namespace livermark::fem_reference
