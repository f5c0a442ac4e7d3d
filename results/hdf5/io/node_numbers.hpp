#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <fmt/format.h>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "results/hdf5/io/hdf5_io.hpp"

namespace livermark::results::hdf5 {

/// Every index of every row in [first, end).
inline void check_indices(const InputFile &file, const std::string &path, std::span<const int> indices, int columns,
                          int first, std::size_t end) {
    const auto bad = std::ranges::find_if(
        indices, [&](int index) { return index < first || index >= static_cast<std::int64_t>(end); });
    if (bad != indices.end())
        file.refuse(path, fmt::format("row {} holds {}, which is not in [{}, {})", (bad - indices.begin()) / columns,
                                      *bad, first, end));
}

/// One index of each row, checked.
inline std::vector<int> indices(const InputFile &file, const std::string &path, std::size_t num_rows, int first,
                                std::size_t end) {
    auto values = file.dataset<int>(path, num_rows);
    check_indices(file, path, values, 1, first, end);
    return values;
}

inline void check_finite(const InputFile &file, const std::string &path, std::span<const core::Vector3> vectors) {
    const auto bad = std::ranges::find_if(vectors, [](const core::Vector3 &vector) { return !vector.allFinite(); });
    if (bad != vectors.end())
        file.refuse(path, fmt::format("row {} is not finite", bad - vectors.begin()));
}

/// Rows of node numbers, each checked.
template <std::size_t columns>
std::vector<std::array<int, columns>> node_numbers(const InputFile &file, const std::string &path,
                                                   std::size_t num_nodes) {
    auto rows = file.dataset<std::array<int, columns>>(path);
    // std::array lies in memory like its entries, one row behind the other.
    check_indices(file, path, {rows.empty() ? nullptr : rows.front().data(), columns * rows.size()},
                  static_cast<int>(columns), 0, num_nodes);
    return rows;
}

} // namespace livermark::results::hdf5
