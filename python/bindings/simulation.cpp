#include <algorithm>
#include <atomic>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/relaxation.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/own_process.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "python/bindings/interpreter.hpp"
#include "python/bindings/springs.hpp"

namespace livermark::python {

namespace {

/// Arguments of a Simulation; see its docstring.
struct StepChoice {
    double time_step = 0.0; ///< h [s]
    std::string integrator;
    core::RayleighDamping damping;
    std::string kernel;
    int num_threads = 1;
    bool force_time_step = false; ///< take it even if it is too long to be stable
    core::PronySeries relaxation{};
};

/// Threads of one simulation: more than cores only wait for each other. Small machines may try what large ones do.
int most_threads() {
    constexpr int at_least = 8;
    return std::max(at_least, 2 * static_cast<int>(std::thread::hardware_concurrency()));
}

/// Threads of all simulations together, beside the threads that call them.
int most_borrowed() {
    return 32 * most_threads();
}

int num_borrowed_in_all = 0; // looked at by the thread that holds the interpreter

/// Threads that simulations have beside those that call them. They are given back when it goes.
class BorrowedThreads {
  public:
    /// @param num_threads  of one simulation, that which calls it among them
    /// @throws support::InputError if they are fewer than one, too many for this machine, or too many with those of all
    /// other simulations of this process
    explicit BorrowedThreads(int num_threads) : num_borrowed_(num_threads - 1) {
        if (num_threads < 1)
            throw support::InputError(fmt::format("num_threads: {}; there has to be one at least", num_threads));
        if (num_threads > most_threads())
            throw support::InputError(
                fmt::format("num_threads: {} is too many for the {} cores of this machine; give {} at "
                            "most",
                            num_threads, std::thread::hardware_concurrency(), most_threads()));
        if (num_borrowed_in_all + num_borrowed_ > most_borrowed())
            throw support::InputError(
                fmt::format("num_threads: all simulations that are alive have {} threads already, and "
                            "{} are the most; delete some, or give num_threads=1",
                            num_borrowed_in_all, most_borrowed()));
        num_borrowed_in_all += num_borrowed_;
    }
    ~BorrowedThreads() { num_borrowed_in_all -= num_borrowed_; }
    BorrowedThreads(const BorrowedThreads &) = delete;
    BorrowedThreads &operator=(const BorrowedThreads &) = delete;

  private:
    int num_borrowed_;
};

msm::ForcePrecision precision_of(const std::string &kernel) {
    if (kernel == "simd_double")
        return msm::ForcePrecision::double_precision;
    if (kernel == "simd_float")
        return msm::ForcePrecision::single_precision;
    throw support::InputError(fmt::format("there is no kernel '{}'; known are: simd_double, simd_float", kernel));
}

/// In the words of `livermark run`.
void refuse_unstable(const Springs &springs, const StepChoice &choice, const msm::Integrator &integrator,
                     const py::handle &fixed) {
    const double highest = largest_frequency(springs, fixed);
    if (!(highest > 0.0))
        return; // nothing moves
    const double critical =
        msm::critical_time_step(integrator, choice.damping, msm::lowest_damped_part * highest, highest);
    if (!(critical > 0.0))
        throw support::InputError(fmt::format("integrator: {} is unstable at every time step with such damping; give "
                                              "more of it, take another integrator, or force_time_step=True to see "
                                              "what happens",
                                              integrator.name));
    if (choice.time_step > critical)
        throw support::InputError(fmt::format(
            "time_step: {:.3g} s is too long for {} with these springs: {:.3g} s is the longest that is stable, and "
            "{:.3g} s is safe; take that, or force_time_step=True to see what happens",
            choice.time_step, integrator.name, critical, msm::default_safety_factor * critical));
}

/// @param branches  modulus and time [s] of each
/// @throws support::InputError if a modulus is negative, all together leave nothing, or a time is not positive
core::PronySeries prony_series(const std::vector<std::pair<double, double>> &branches) {
    core::PronySeries series;
    for (const auto &[modulus, time] : branches) {
        if (!(modulus >= 0.0))
            throw support::InputError(fmt::format("relaxation: {} is no part of a modulus that fades; give pairs of a "
                                                  "modulus, 0 or more, and a time in seconds",
                                                  modulus));
        if (!(time > 0.0))
            throw support::InputError(
                fmt::format("relaxation: a time is {} s; times have to be positive, in seconds", time));
        series.moduli.push_back(modulus);
        series.times.push_back(time);
    }
    if (!(series.remaining() > 0.0))
        throw support::InputError(
            fmt::format("relaxation: the moduli are parts that fade, and their sum {:g} has to be "
                        "below 1; change them",
                        1.0 - series.remaining()));
    return series;
}

/// @param fixed, forces  see conditions_of()
/// @throws support::InputError if the step is too long to be stable, and what else is wrong in the arguments
msm::FastSteps prepare_steps(const Springs &springs, const StepChoice &choice, const py::handle &fixed,
                             const py::handle &forces) {
    const msm::FastStepOptions options{
        .precision = precision_of(choice.kernel), .num_threads = choice.num_threads, .relaxation = choice.relaxation};
    const auto conditions = conditions_of(springs, fixed, forces);
    if (!(choice.time_step > 0.0 && std::isfinite(choice.time_step)))
        throw support::InputError(fmt::format(
            "time_step: {} s; it has to be positive, such as 0.8 of critical_time_step()", choice.time_step));
    const auto &integrator = msm::find_integrator(choice.integrator);
    if (!choice.force_time_step)
        refuse_unstable(springs, choice, integrator, fixed);
    try {
        const auto steps = msm::FastSteps::prepare(springs.body, springs.points, conditions, choice.damping,
                                                   integrator.name, choice.time_step, options);
        if (!steps)
            throw support::InputError(fmt::format("integrator: the fast kernels do not know {} for such springs; take "
                                                  "another one of integrators()",
                                                  integrator.name));
        return *steps;
    } catch (const std::system_error &error) {
        throw support::InputError(fmt::format("num_threads: the system starts no {} threads ({}); give fewer",
                                              choice.num_threads, error.code().message()));
    }
}

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

    /// Check of some nodes, others each time: what is not finite spreads from node to node with every step.
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
