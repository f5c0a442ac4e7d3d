#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace livermark::interactive::kernels {

/// Sorts each window of so many items by itself, so that they stay near where they are.
template <class T, class Less> void sort_in_windows_of(std::size_t window, std::vector<T> &items, const Less &less) {
    for (std::size_t first = 0; first < items.size(); first += window)
        std::stable_sort(items.begin() + static_cast<std::ptrdiff_t>(first),
                         items.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, items.size())), less);
}

} // namespace livermark::interactive::kernels
