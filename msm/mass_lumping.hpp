#pragma once

#include <vector>

#include "core/problem.hpp"

namespace livermark::msm {

/// Node masses by barycentric lumping: m_i = 1/4 sum over the tetrahedra t at node i of rho_t V(t)
/// (equation 2 of Jurnal Teknologi 75, 10.11113/jt.v75.5068).
/// @return shape (N) [kg]; the sum is the mass of the body
std::vector<double> lumped_masses(const core::Body &body);

} // namespace livermark::msm
