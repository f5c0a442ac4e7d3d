#pragma once

#include <span>
#include <string>
#include <vector>

namespace livermark::fem_reference {

/// A symmetric positive definite approximation of the inverse of the free rows and columns of a stiffness matrix.
/// n is the number of rows of the whole matrix; unknowns that are not free are zero in whatever comes out.
class Preconditioner {
  public:
    virtual ~Preconditioner() = default;

    /// Prepares it, unless the same unknowns were free last time.
    /// @param is_free  shape (n)
    /// @return whether the conditions fix the answer
    virtual bool set_up(const std::vector<bool> &is_free) = 0;

    /// @param residual    shape (n), zero where not free
    /// @param correction  shape (n)
    virtual void apply(std::span<const double> residual, std::span<double> correction) = 0;

    /// What it is, for the result file.
    virtual std::string name() const = 0;
};

} // namespace livermark::fem_reference
