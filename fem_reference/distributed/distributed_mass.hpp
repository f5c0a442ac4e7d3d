#pragma once

#include <deal.II/base/subscriptor.h>

#include <algorithm>
#include <functional>
#include <span>
#include <vector>

#include "fem_reference/distributed/node_exchange.hpp"
#include "fem_reference/solvers/multivector.hpp"

namespace livermark::fem_reference {

/// The mass of the pressure that each rank has on its part.
class DistributedMass : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    /// Both are kept alive by the caller.
    /// @param matrix  of the part, complete in the rows that this rank owns
    DistributedMass(const SymmetricMatrix &matrix, const NodeExchange &pressures)
        : matrix_(matrix), pressures_(pressures), from_(matrix.value.empty() ? 0 : matrix.num_rows()),
          to_(from_.size()) {}

    void vmult(Vector &out, const Vector &in) const {
        pressures_.read(in, std::span(from_));
        if (!from_.empty())
            multiply(matrix_, from_, to_, 1);
        pressures_.write(std::span<const double>(to_), out);
    }

  private:
    const SymmetricMatrix &matrix_;
    const NodeExchange &pressures_;
    mutable std::vector<double> from_, to_;
};

/// Over its diagonal.
class InverseDiagonal : public dealii::Subscriptor {
  public:
    using Vector = NodeExchange::Vector;

    InverseDiagonal(const SymmetricMatrix &matrix, const NodeExchange &pressures) {
        for (const int row : pressures.owned())
            for (int k = matrix.row_start[row]; k < matrix.row_start[row + 1]; ++k)
                if (matrix.column[k] == row)
                    inverse_.push_back(1.0 / matrix.value[k]);
    }
    void vmult(Vector &out, const Vector &in) const {
        std::ranges::transform(inverse_, std::span(in.begin(), inverse_.size()), out.begin(), std::multiplies<>());
    }

  private:
    std::vector<double> inverse_; ///< (owned pressures)
};

} // namespace livermark::fem_reference
