#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "core/solution.hpp"
#include "msm/elastic_body.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

/// Source of the springs of a mesh, so that they can be made again.
struct SpringsSource {
    std::shared_ptr<const core::Body> body; ///< null for springs that were given one by one
    std::string name{};                     ///< of the law, or of the model of coupled springs
    std::optional<std::string> volume_term{};
    bool is_coupled = false;
};

/// The largest frequency of springs for the components that were fixed when it was asked for last. Looked at by the
/// thread that holds the interpreter.
struct KnownFrequency {
    std::vector<std::array<bool, 3>> fixed{}; ///< (N)
    std::optional<double> largest{};          ///< [rad/s]
};

/// Springs of Python: where the nodes are at rest, the springs of their edges, and all that resists. They never
/// change.
struct Springs {
    std::vector<core::Vector3> points; ///< (N) [m]
    core::SpringNetwork network;       ///< no edges where springs are coupled around nodes
    msm::ElasticBody body;
    SpringsSource source{};
    std::shared_ptr<KnownFrequency> frequency = std::make_shared<KnownFrequency>();
};

/// Springs of a mesh, by a spring law or by a model of coupled springs.
/// @param source  with a body
/// @throws support::InputError if there is no law, model or volume term of that name
Springs springs_of_body(SpringsSource source);

/// Springs that were given one by one.
/// @param points  shape (N) [m]
/// @throws support::InputError if two join the same nodes, have no length, or if a number is not positive
Springs springs_of_network(std::vector<core::Vector3> points, const core::SpringNetwork &network);

/// The largest frequency at rest, which is found once for the same fixed components [rad/s].
/// @param fixed  see to_mask()
double largest_frequency(const Springs &springs, const py::handle &fixed);

/// Adds the class Springs and the functions that make them.
void add_springs(py::module_ &module);

/// Lets springs be pickled: what they were made of, in arrays, from which the same are made again.
void add_pickling(py::class_<Springs> &springs);

/// Adds damping, frequencies and critical time steps.
void add_time_steps(py::module_ &module);

/// Adds the class Simulation.
void add_simulation(py::module_ &module);

/// @param fixed   see to_mask()
/// @param forces  shape (N, 3) [N], or None
msm::NodalConditions conditions_of(const Springs &springs, const py::handle &fixed, const py::handle &forces);

} // namespace livermark::python
