#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace livermark::fem_reference {

/// Zeros where nothing is free: so a solver takes the rows and columns of what is free alone.
/// @param values   shape (3 n)
/// @param is_free  shape (3 n)
template <class T> void clear_constrained(std::span<T> values, const std::vector<bool> &is_free) {
    for (std::size_t dof = 0; dof < values.size(); ++dof)
        if (!is_free[dof])
            values[dof] = T(0);
}

} // namespace livermark::fem_reference
