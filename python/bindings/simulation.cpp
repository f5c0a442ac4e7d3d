#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <type_traits>

#include "python/bindings/conditions.hpp"
#include "python/bindings/errors.hpp"
#include "python/bindings/prepared_steps.hpp"
#include "python/bindings/without_interpreter.hpp"
#include "support/input_error.hpp"
#include "support/processes/forks.hpp"

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

/// Springs that move. Several Python threads may use one: they wait for each other without holding the interpreter up.
class Simulation {
  public:
    Simulation(const Springs &springs, const StepChoice &choice, const py::object &fixed, const py::object &forces)
        : threads_(choice.num_threads), points_(springs.points), steps_(prepare_steps(springs, choice, fixed, forces)),
          time_step_(choice.time_step) {}

    /// In pieces, so that Ctrl-C comes through.
    void step(std::int64_t num_steps) {
        if (num_steps < 0)
            throw support::InputError(fmt::format("num_steps: {}; there is no way back in time", num_steps));
        while (num_steps > 0) {
            const auto piece = std::min<std::int64_t>(num_steps, steps_between_signals);
            const bool is_finite = alone([&] {
                steps_.take(static_cast<int>(piece));
                num_steps_ += piece;
                return looks_finite();
            });
            if (!is_finite)
                refuse_not_finite();
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
        alone([&] {
            for (std::size_t i = 0; i < forces.size(); ++i)
                steps_.set_load(static_cast<int>(i), forces[i]);
        });
    }

    void set_force(std::int64_t node, const std::array<double, 3> &force) {
        if (node < 0 || static_cast<std::size_t>(node) >= points_.size())
            throw support::InputError(
                fmt::format("node: there is no node {}; nodes are numbered from 0 to {}", node, points_.size() - 1));
        if (!std::ranges::all_of(force, [](double f) { return std::isfinite(f); }))
            throw support::InputError("force: every component has to be finite");
        alone([&] { steps_.set_load(static_cast<int>(node), {force[0], force[1], force[2]}); });
    }

    void relax(double seconds) {
        if (!(seconds >= 0.0))
            throw support::InputError(fmt::format("seconds: {}; stresses have no way back in time", seconds));
        alone([&] { steps_.relax(seconds); });
    }

    double time_step() const { return time_step_; }
    std::int64_t num_steps() const { return num_steps_; }
    double time() const { return static_cast<double>(num_steps_) * time_step_; }

  private:
    static constexpr std::int64_t steps_between_signals = 200;
    static constexpr std::size_t nodes_looked_at = 16;

    /// Does work on the steps while other threads of Python run, but none on the same steps.
    template <class Work> std::invoke_result_t<Work> alone(const Work &work) const {
        enter_this_process();
        return without_interpreter([&] {
            const std::lock_guard lock(mutex_);
            return work();
        });
    }

    /// After a fork whoever held the mutex is not there, and has left the steps as they were in the middle of his work.
    void enter_this_process() const {
        if (forks_ == support::fork_count())
            return;
        if (was_torn_ || !mutex_.try_lock()) {
            was_torn_ = true;
            throw std::runtime_error(
                "this process was forked while another thread used the simulation, which is in the "
                "middle of a step for ever; make another one here, or start processes by the "
                "method 'spawn' of multiprocessing");
        }
        mutex_.unlock();
        forks_ = support::fork_count();
    }

    /// Of some nodes, others each time: what is not finite spreads from node to node with every step.
    bool looks_finite() {
        for (std::size_t i = 0; i < std::min(nodes_looked_at, points_.size()); ++i) {
            next_look_ = (next_look_ + 1) % points_.size();
            if (!steps_.displacement(static_cast<int>(next_look_)).allFinite())
                return false;
        }
        return true;
    }

    [[noreturn]] void refuse_not_finite() const {
        raise("DivergedError",
              fmt::format("the motion is not finite any more after {} steps, at t = {:.3g} s; take steps shorter than "
                          "{:.3g} s, smaller forces or more damping, and assign displacement and velocity to go on",
                          num_steps_.load(), time(), time_step_));
    }

    msm::State state() const {
        auto now = alone([&] { return steps_.state(); });
        if (!now.displacement.allFinite() || !now.velocity.allFinite())
            refuse_not_finite();
        return now;
    }

    void set(Eigen::VectorXd msm::State::*field, const py::object &values, const char *name) {
        const auto given = msm::to_unknowns(to_vectors(values, name, points_.size()));
        alone([&] {
            auto state = steps_.state();
            state.*field = given;
            steps_.set_state(state);
        });
    }

    BorrowedThreads threads_;
    std::vector<core::Vector3> points_;
    mutable std::mutex mutex_;
    mutable unsigned forks_ = support::fork_count(); ///< of the process that used it last
    mutable bool was_torn_ = false;
    msm::FastSteps steps_;
    double time_step_;
    std::atomic<std::int64_t> num_steps_ = 0;
    std::size_t next_look_ = 0;
};

std::unique_ptr<Simulation> make_simulation(const Springs &springs, double time_step, const std::string &integrator,
                                            const core::RayleighDamping &damping, const py::object &fixed,
                                            const py::object &forces, const std::string &kernel, int num_threads,
                                            bool force_time_step,
                                            const std::vector<std::pair<double, double>> &relaxation) {
    const StepChoice choice{
        time_step, integrator, damping, kernel, num_threads, force_time_step, prony_series(relaxation)};
    return std::make_unique<Simulation>(springs, choice, fixed, forces);
}

py::object refuse_pickling(const Simulation & /*simulation*/) {
    throw py::type_error(
        "a Simulation cannot be pickled; pickle its springs, displacement and velocity, and make another "
        "one of them");
}

} // namespace

void add_simulation(py::module_ &module) {
    py::class_<Simulation>(module, "Simulation",
                           "Springs that move in explicit steps, with forces from vector units. Starts at rest.")
        .def(py::init(&make_simulation), py::arg("springs"), py::arg("time_step"),
             py::arg("integrator") = "symplectic_euler", py::arg("damping") = core::RayleighDamping{},
             py::arg("fixed") = py::none(), py::arg("forces") = py::none(), py::arg("kernel") = "simd_double",
             py::arg("num_threads") = 1, py::arg("force_time_step") = false,
             py::arg("relaxation") = std::vector<std::pair<double, double>>{},
             "time_step: h [s], at most critical_time_step(), above which motions grow without bounds. integrator: one "
             "of\nintegrators(). fixed: node numbers, or a mask of shape (N) or (N, 3). forces: (N, 3) on the nodes "
             "[N]. "
             "kernel:\nsimd_double, or simd_float for forces in single precision. num_threads: the motion is the same "
             "with any.\nforce_time_step: take the step even if it is too long to be stable, without looking for the "
             "largest frequency.\nrelaxation: pairs (modulus, time) of a Prony series; of the stress that resists "
             "changes "
             "of shape, and of a\nspring's tension, the part modulus fades with the time [s].\nRaises "
             "InputError.")
        .def("step", &Simulation::step, py::arg("num_steps") = 1,
             "Takes that many steps. Other Python threads run meanwhile. Raises DivergedError if the motion is not "
             "finite any more.")
        .def("relax", &Simulation::relax, py::arg("seconds"),
             "Lets stresses fade as if the body stayed where it is for that long; math.inf is for ever. Positions, "
             "velocities and time stay.")
        .def("set_forces", &Simulation::set_forces, py::arg("forces"),
             "Loads all nodes from now on: (N, 3) [N], in place of what loaded them.")
        .def("set_force", &Simulation::set_force, py::arg("node"), py::arg("force"),
             "Loads one node from now on: (3) [N], in place of what loaded it.")
        .def_property_readonly("positions", &Simulation::positions,
                               "(N, 3) [m], an array of its own. Raises DivergedError as step() does, as the next two.")
        .def_property("displacement", &Simulation::displacement, &Simulation::set_displacement,
                      "(N, 3) from rest [m], an array of its own. Assign one to go on from there; fixed nodes move to "
                      "what is assigned.")
        .def_property("velocity", &Simulation::velocity, &Simulation::set_velocity,
                      "(N, 3) [m/s], an array of its own. Assign one to go on from there; fixed nodes stay at zero.")
        .def("__reduce__", &refuse_pickling)
        .def_property_readonly("time", &Simulation::time, "num_steps times time_step [s]")
        .def_property_readonly("num_steps", &Simulation::num_steps, "that were taken")
        .def_property_readonly("time_step", &Simulation::time_step, "h [s]");
}

} // namespace livermark::python
