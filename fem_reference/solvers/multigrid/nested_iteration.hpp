#pragma once

#include <span>
#include <vector>

#include "fem_reference/linear/pressure_system.hpp"
#include "fem_reference/solvers/multigrid/prolongation.hpp"

namespace livermark::fem_reference {

/// A sparse matrix in compressed rows that need not be square.
struct SparseRows {
    std::vector<int> row_start; ///< (m + 1) index into column and value
    std::vector<int> column;    ///< (nonzeros)
    std::vector<double> value;  ///< (nonzeros)
};

/// How displacements and pressures of a body are those of the refined one: iterations there begin at the solution on
/// the mesh before refinement, which is wrong by percents where zero is wrong by all.
struct NestedIteration {
    Prolongation displacement;
    SparseRows pressure; ///< (m_fine, m_coarse)

    /// p_c = P p_coarse,c
    /// @param coarse  shape (m_coarse, lanes), see multivector.hpp
    /// @return shape (m_fine, lanes)
    std::vector<double> prolonged_pressure(std::span<const double> coarse, int lanes) const;
};

/// @param coarse, fine                    systems of degree 2 of a body and of one that is refined
/// @param coarse_pressure, fine_pressure  assembled on them
/// @param parent                          see prolongation()
/// @throws std::invalid_argument if the fine system is not that of the refined body
NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent = {});

} // namespace livermark::fem_reference
