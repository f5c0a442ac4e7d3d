#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <mutex>

#include "core/rayleigh_damping.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "python/bindings/conditions.hpp"
#include "python/bindings/released_interpreter.hpp"
#include "support/input_error.hpp"

namespace livermark::python {

msm::NodalConditions conditions_of(const Springs &springs, const py::handle &fixed, const py::handle &forces) {
    const std::size_t num_nodes = springs.points.size();
    msm::NodalConditions conditions;
    for (const auto &components : to_mask(fixed, "fixed", num_nodes)) {
        auto &displacement = conditions.displacement.emplace_back(core::Vector3::Zero());
        auto &constraint = conditions.constraint.emplace_back(std::array{0, 0, 0});
        for (std::size_t c = 0; c < 3; ++c)
            if (!components[c]) {
                displacement[static_cast<Eigen::Index>(c)] = std::numeric_limits<double>::quiet_NaN();
                constraint[c] = -1;
            }
    }
    conditions.force = forces.is_none() ? std::vector<core::Vector3>(num_nodes, core::Vector3::Zero())
                                        : to_vectors(forces, "forces", num_nodes);
    return conditions;
}

namespace {

msm::ForcePrecision precision_of(const std::string &kernel) {
    if (kernel == "simd_double")
        return msm::ForcePrecision::double_precision;
    if (kernel == "simd_float")
        return msm::ForcePrecision::single_precision;
    throw support::InputError(fmt::format("there is no kernel '{}'; known are: simd_double, simd_float", kernel));
}

msm::FastSteps prepare_steps(const Springs &springs, double time_step, const std::string &integrator,
                             const core::RayleighDamping &damping, const msm::NodalConditions &conditions,
                             const msm::FastStepOptions &options) {
    if (!(time_step > 0.0 && std::isfinite(time_step)))
        throw support::InputError(
            fmt::format("time_step: {} s; it has to be positive, such as 0.8 of critical_time_step()", time_step));
    if (options.num_threads < 1)
        throw support::InputError(fmt::format("num_threads: {}; there has to be one at least", options.num_threads));
    const auto steps = msm::FastSteps::prepare(springs.body, springs.points, conditions, damping,
                                               msm::find_integrator(integrator).name, time_step, options);
    if (!steps)
        throw support::InputError(fmt::format("integrator: the fast kernels do not know {} for such springs; take "
                                              "another one of integrators()",
                                              integrator));
    return *steps;
}

/// Springs that move. Several Python threads may use one: they wait for each other without holding the interpreter up.
class Simulation {
  public:
    Simulation(const Springs &springs, double time_step, const std::string &integrator,
               const core::RayleighDamping &damping, const py::object &fixed, const py::object &forces,
               const std::string &kernel, int num_threads)
        : points_(springs.points),
          steps_(prepare_steps(springs, time_step, integrator, damping, conditions_of(springs, fixed, forces),
                               {.precision = precision_of(kernel), .num_threads = num_threads})),
          time_step_(time_step) {}

    /// In pieces, so that Ctrl-C comes through.
    void step(std::int64_t num_steps) {
        if (num_steps < 0)
            throw support::InputError(fmt::format("num_steps: {}; there is no way back in time", num_steps));
        while (num_steps > 0) {
            const auto piece = std::min<std::int64_t>(num_steps, steps_between_signals);
            {
                const ReleasedInterpreter released;
                const std::lock_guard lock(mutex_);
                steps_.take(static_cast<int>(piece));
                num_steps_ += piece;
            }
            num_steps -= piece;
            if (PyErr_CheckSignals() != 0)
                throw py::error_already_set();
        }
    }

    py::array_t<double> displacement() const { return to_array(state().displacement); }
    py::array_t<double> velocity() const { return to_array(state().velocity); }
    py::array_t<double> positions() const {
        auto x = state().displacement;
        for (std::size_t i = 0; i < points_.size(); ++i)
            x.segment<3>(3 * static_cast<Eigen::Index>(i)) += points_[i];
        return to_array(std::move(x));
    }

    void set_displacement(const py::object &values) { set(&msm::State::displacement, values, "displacement"); }
    void set_velocity(const py::object &values) { set(&msm::State::velocity, values, "velocity"); }

    void set_forces(const py::object &values) {
        const auto forces = to_vectors(values, "forces", points_.size());
        const ReleasedInterpreter released;
        const std::lock_guard lock(mutex_);
        for (std::size_t i = 0; i < forces.size(); ++i)
            steps_.set_load(static_cast<int>(i), forces[i]);
    }

    void set_force(std::int64_t node, const std::array<double, 3> &force) {
        if (node < 0 || static_cast<std::size_t>(node) >= points_.size())
            throw support::InputError(
                fmt::format("node: there is no node {}; nodes are numbered from 0 to {}", node, points_.size() - 1));
        if (!std::ranges::all_of(force, [](double f) { return std::isfinite(f); }))
            throw support::InputError("force: every component has to be finite");
        const ReleasedInterpreter released;
        const std::lock_guard lock(mutex_);
        steps_.set_load(static_cast<int>(node), {force[0], force[1], force[2]});
    }

    double time_step() const { return time_step_; }
    std::int64_t num_steps() const { return num_steps_; }
    double time() const { return static_cast<double>(num_steps_) * time_step_; }

  private:
    static constexpr std::int64_t steps_between_signals = 200;

    msm::State state() const {
        const ReleasedInterpreter released;
        const std::lock_guard lock(mutex_);
        return steps_.state();
    }

    void set(Eigen::VectorXd msm::State::*field, const py::object &values, const char *name) {
        const auto given = msm::to_unknowns(to_vectors(values, name, points_.size()));
        const ReleasedInterpreter released;
        const std::lock_guard lock(mutex_);
        auto state = steps_.state();
        state.*field = given;
        steps_.set_state(state);
    }

    std::vector<core::Vector3> points_;
    mutable std::mutex mutex_;
    msm::FastSteps steps_;
    double time_step_;
    std::int64_t num_steps_ = 0;
};

} // namespace

void add_simulation(py::module_ &module) {
    py::class_<Simulation>(module, "Simulation",
                           "Springs that move in explicit steps, with forces from vector units. Starts at rest.")
        .def(py::init<const Springs &, double, const std::string &, const core::RayleighDamping &, const py::object &,
                      const py::object &, const std::string &, int>(),
             py::arg("springs"), py::arg("time_step"), py::arg("integrator") = "symplectic_euler",
             py::arg("damping") = core::RayleighDamping{}, py::arg("fixed") = py::none(),
             py::arg("forces") = py::none(), py::arg("kernel") = "simd_double", py::arg("num_threads") = 1,
             "time_step: h [s]; steps above critical_time_step() grow without bounds. integrator: one of "
             "integrators().\nfixed: node numbers, or a mask of shape (N) or (N, 3). forces: (N, 3) on the nodes [N]. "
             "kernel: simd_double, or\nsimd_float for forces in single precision. num_threads: the motion is the same "
             "with any. Raises InputError.")
        .def("step", &Simulation::step, py::arg("num_steps") = 1,
             "Takes that many steps. Other Python threads run meanwhile.")
        .def("set_forces", &Simulation::set_forces, py::arg("forces"),
             "Loads all nodes from now on: (N, 3) [N], in place of what loaded them.")
        .def("set_force", &Simulation::set_force, py::arg("node"), py::arg("force"),
             "Loads one node from now on: (3) [N], in place of what loaded it.")
        .def_property_readonly("positions", &Simulation::positions, "(N, 3) [m], an array of its own")
        .def_property("displacement", &Simulation::displacement, &Simulation::set_displacement,
                      "(N, 3) from rest [m], an array of its own. Assign one to go on from there; fixed nodes move to "
                      "what is assigned.")
        .def_property("velocity", &Simulation::velocity, &Simulation::set_velocity,
                      "(N, 3) [m/s], an array of its own. Assign one to go on from there; fixed nodes stay at zero.")
        .def_property_readonly("time", &Simulation::time, "num_steps times time_step [s]")
        .def_property_readonly("num_steps", &Simulation::num_steps, "that were taken")
        .def_property_readonly("time_step", &Simulation::time_step, "h [s]");
}

} // namespace livermark::python
