#pragma once

#include <span>
#include <string>

#include "fem_reference/solvers/multivector.hpp"

namespace livermark::fem_reference {

/// A symmetric positive definite approximation of the inverse of the free rows and columns of a stiffness matrix, in
/// single precision: what is approximate takes no more, and memory comes in half of the time.
/// n is the number of rows of the whole matrix; unknowns that are not free are zero in whatever comes out.
class Preconditioner {
  public:
    virtual ~Preconditioner() = default;

    /// Prepares it, unless the same unknowns were free last time.
    /// @param free  in each of at most max_columns() columns
    /// @return whether the conditions fix the solution in every column
    virtual bool set_up(const FreeUnknowns &free) = 0;

    /// @param residual    shape (n, lanes), zero where not free
    /// @param correction  shape (n, lanes)
    virtual void apply(std::span<const float> residual, std::span<float> correction) = 0;

    /// How many columns take less time together than one by one.
    virtual std::size_t max_columns() const { return 1; }

    /// What it is, for the result file.
    virtual std::string name() const = 0;
};

} // namespace livermark::fem_reference
