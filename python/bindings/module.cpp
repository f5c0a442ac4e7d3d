#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/relaxation.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "python/bindings/interpreter.hpp"
#include "python/bindings/springs.hpp"

namespace livermark::python {

namespace {

using core::RayleighDamping;

RayleighDamping checked_damping(double alpha, double beta) {
    if (!(alpha >= 0.0 && beta >= 0.0 && std::isfinite(alpha) && std::isfinite(beta)))
        throw support::InputError(
            fmt::format("alpha is {} 1/s and beta {} s; both have to be finite and not negative", alpha, beta));
    return {.alpha = alpha, .beta = beta};
}

RayleighDamping same_ratio_damping(double ratio, double omega_1, double omega_2) {
    if (!(ratio >= 0.0 && omega_1 > 0.0 && omega_2 > 0.0))
        throw support::InputError(fmt::format("a damping ratio of {} at {} and {} rad/s; the ratio must not be "
                                              "negative, and frequencies have to be positive",
                                              ratio, omega_1, omega_2));
    return core::rayleigh_damping(ratio, omega_1, omega_2);
}

double longest_step(const Springs &springs, const std::string &integrator, const RayleighDamping &damping,
                    const py::object &fixed) {
    const auto &rule = msm::find_integrator(integrator);
    const double highest = largest_frequency(springs, fixed);
    if (!(highest > 0.0))
        throw support::InputError("fixed: nothing can move, so no step is too long; leave nodes free");
    return msm::critical_time_step(rule, damping, msm::lowest_damped_part * highest, highest);
}

} // namespace

double largest_frequency(const Springs &springs, const py::handle &fixed) {
    auto mask = to_mask(fixed, "fixed", springs.points.size());
    if (springs.frequency->largest && springs.frequency->fixed == mask)
        return *springs.frequency->largest;
    const auto conditions = conditions_of(springs, fixed, py::none());
    const double largest =
        without_interpreter([&] { return msm::largest_angular_frequency(springs.body, springs.points, conditions); });
    *springs.frequency = {std::move(mask), largest};
    return largest;
}

void add_time_steps(py::module_ &module) {
    py::class_<RayleighDamping>(module, "RayleighDamping", "Damping forces D v with D = alpha M + beta K.")
        .def(py::init(&checked_damping), py::arg("alpha") = 0.0, py::arg("beta") = 0.0,
             "alpha: of the mass [1/s]. beta: of the stiffness [s]. Neither is negative.")
        .def_readonly("alpha", &RayleighDamping::alpha, "of the mass [1/s]")
        .def_readonly("beta", &RayleighDamping::beta, "of the stiffness [s]")
        .def("ratio", &RayleighDamping::ratio, py::arg("omega"),
             "Damping ratio of a mode, zeta = (alpha / omega + beta omega) / 2. omega [rad/s] > 0.")
        .def(py::pickle([](const RayleighDamping &d) { return py::make_tuple(d.alpha, d.beta); },
                        [](const py::tuple &kept) {
                            return checked_damping(py::cast<double>(kept[0]), py::cast<double>(kept[1]));
                        }))
        .def("__repr__", [](const RayleighDamping &damping) {
            return fmt::format("RayleighDamping(alpha={}, beta={})", damping.alpha, damping.beta);
        });
    module.def("rayleigh_damping", &same_ratio_damping, py::arg("ratio"), py::arg("omega_1"), py::arg("omega_2"),
               "One ratio at two frequencies [rad/s]: alpha = 2 zeta omega_1 omega_2 / (omega_1 + omega_2),\n"
               "beta = 2 zeta / (omega_1 + omega_2). Returns RayleighDamping. Raises InputError.");
    module.def("mass_proportional_damping", &msm::mass_proportional_damping, py::arg("ratio"), py::arg("omega"),
               "By the mass alone: alpha = 2 zeta omega. omega [rad/s]. Returns RayleighDamping. Raises InputError.");
    module.def("stiffness_proportional_damping", &msm::stiffness_proportional_damping, py::arg("ratio"),
               py::arg("omega"),
               "By the stiffness alone: beta = 2 zeta / omega. omega [rad/s]. Returns RayleighDamping. Raises "
               "InputError.");
    module.def("two_mode_damping", &msm::two_mode_damping, py::arg("ratio_1"), py::arg("omega_1"), py::arg("ratio_2"),
               py::arg("omega_2"),
               "One ratio at one frequency, another one at another [rad/s]. Returns RayleighDamping. Raises "
               "InputError.");
    module.def("largest_angular_frequency", &largest_frequency, py::arg("springs"), py::arg("fixed") = py::none(),
               "The largest omega of K phi = omega^2 M phi at rest [rad/s], to 1e-9. fixed: node numbers, or a mask "
               "of shape (N)\nor (N, 3). Zero if nothing can move.");
    module.def("critical_time_step", &longest_step, py::arg("springs"), py::arg("integrator") = "symplectic_euler",
               py::arg("damping") = RayleighDamping{}, py::arg("fixed") = py::none(),
               "The longest step at which no mode of the springs at rest grows [s]; 0 for an integrator that is stable "
               "at none.\nintegrator: one of integrators(). fixed: as of Simulation. Take a part of it, such as 0.8: "
               "springs get stiffer as they\nare stretched. Raises InputError.");
    module.def(
        "integrators",
        [] {
            std::vector<std::string> names;
            for (const auto &integrator : msm::all_integrators())
                names.push_back(integrator.name);
            return names;
        },
        "Names of the explicit integrators.");
}

} // namespace livermark::python

/// Springs and their motion: the components core and msm, and nothing under the GPL.
PYBIND11_MODULE(_livermark, module) {
    module.doc() = "Springs, time steps and simulation of Livermark; import livermark instead.";
    livermark::python::translate_input_errors();
    livermark::python::work_at_the_end::register_with();
    livermark::python::add_springs(module);
    livermark::python::add_time_steps(module);
    livermark::python::add_simulation(module);
}
