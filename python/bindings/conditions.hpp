#pragma once

#include "msm/nodal_conditions.hpp"
#include "python/bindings/springs.hpp"

namespace livermark::python {

/// @param fixed   see to_mask()
/// @param forces  shape (N, 3) [N], or None
msm::NodalConditions conditions_of(const Springs &springs, const py::handle &fixed, const py::handle &forces);

} // namespace livermark::python
