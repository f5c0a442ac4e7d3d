#pragma once

#include <vector>

#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

/// What Python calls Springs: where the nodes are at rest, the springs of their edges, and all that resists.
struct Springs {
    std::vector<core::Vector3> points; ///< (N) [m]
    core::SpringNetwork network;       ///< no edges where springs are coupled around nodes
    msm::ElasticBody body;
};

/// Adds the class Springs and the functions that make them.
void add_springs(py::module_ &module);

/// Adds damping, frequencies and critical time steps.
void add_time_steps(py::module_ &module);

/// Adds the class Simulation.
void add_simulation(py::module_ &module);

} // namespace livermark::python
