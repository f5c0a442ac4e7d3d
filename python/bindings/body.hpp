#pragma once

#include "core/problem.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

/// A body of arrays. Tetrahedra of the same material are a region.
/// @param points         shape (N, 3) [m]
/// @param tetrahedra     shape (M, 4), node numbers, positive volumes
/// @param young_modulus  [Pa], here and below a number or shape (M)
/// @param density        [kg/m^3]
/// @throws support::InputError if shapes, node numbers, volumes or materials are wrong, or if a node is in no
/// tetrahedron
core::Body to_body(const py::handle &points, const py::handle &tetrahedra, const py::handle &young_modulus,
                   const py::handle &poisson_ratio, const py::handle &density);

} // namespace livermark::python
