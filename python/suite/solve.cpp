#include <algorithm>
#include <fmt/format.h>

#include "core/solution.hpp"
#include "models/model_table.hpp"
#include "python/bindings/without_interpreter.hpp"
#include "python/suite/problem.hpp"
#include "support/known_names.hpp"

namespace livermark::python {

namespace {

core::Model find_model(const std::string &name) {
    const auto models = models::all_models();
    return support::find_named(models, name, "model");
}

core::Solution solution_of(const LoadedBody &loaded, const std::string &name) {
    const auto model = find_model(name);
    const auto &problem = loaded.problem;
    if (!model.takes_part_in(problem))
        throw support::InputError(fmt::format("model {} does not take part in load case {}: it is for {}", name,
                                              problem.load_case.name,
                                              model.only_moving ? "motions" : "the other regime"));
    if (model.check)
        model.check(problem);
    return model.solve(problem);
}

core::Solution solve(const LoadedBody &loaded, const std::string &name) {
    return without_interpreter([&] { return solution_of(loaded, name); });
}

/// None where there is nothing.
template <class Scalar, class Pick> auto shows_if_any(Pick pick, py::ssize_t columns) {
    return [=](const py::object &self) -> py::object {
        const auto &solution = self.cast<const core::Solution &>();
        const auto *values = pick(solution);
        if (!values)
            return py::none();
        std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values->size())};
        if (columns > 1)
            shape.push_back(columns);
        return view(reinterpret_cast<const Scalar *>(values->data()), shape, self);
    };
}

template <class Member> auto of_springs(Member member) {
    return [=](const core::Solution &s) { return s.springs ? &((*s.springs).*member) : nullptr; };
}

template <class Member> auto of_history(Member member) {
    return [=](const core::Solution &s) { return s.history ? &((*s.history).*member) : nullptr; };
}

/// (K, Q, 3)
py::object motion_of_probes(const py::object &self) {
    const auto &history = self.cast<const core::Solution &>().history;
    if (!history || history->time.empty())
        return py::none();
    const auto records = static_cast<py::ssize_t>(history->time.size());
    const auto probes = static_cast<py::ssize_t>(history->displacement.size()) / records;
    return view(reinterpret_cast<const double *>(history->displacement.data()), {records, probes, 3}, self);
}

} // namespace

void add_solve(py::module_ &module, py::class_<LoadedBody> &problem) {
    using core::Solution;
    using core::SpringNetwork;
    py::class_<Solution>(module, "Solution", "What a model finds. Arrays are views that cannot be written to.")
        .def_property_readonly(
            "status", [](const Solution &s) { return core::to_string(s.status); }, "ok, diverged or not_converged")
        .def_readonly("message", &Solution::message, "why the status is not ok")
        .def_property_readonly("displacement",
                               shows_if_any<double>([](const Solution &s) { return &s.displacement; }, 3),
                               "(N, 3) [m], of a load case that depends on time the static start")
        .def_property_readonly("reaction", shows_if_any<double>([](const Solution &s) { return &s.reaction; }, 3),
                               "(P, 3) force of each constraint on the body [N], as in Problem.constraint_names")
        .def_readonly("strain_energy", &Solution::strain_energy, "[J]")
        .def_readonly("degrees_of_freedom", &Solution::degrees_of_freedom, "unknowns, constrained ones included")
        .def_readonly("setup_seconds", &Solution::setup_seconds, "all that needs no loads [s]")
        .def_readonly("solve_seconds", &Solution::solve_seconds, "the rest [s]")
        .def_readonly("solver", &Solution::solver, "how linear systems were solved")
        .def_property_readonly("edges", shows_if_any<int>(of_springs(&SpringNetwork::edges), 2),
                               "(S, 2) node numbers; None of finite elements, as the next three")
        .def_property_readonly("stiffness", shows_if_any<double>(of_springs(&SpringNetwork::stiffness), 1), "(S) [N/m]")
        .def_property_readonly("rest_length", shows_if_any<double>(of_springs(&SpringNetwork::rest_length), 1),
                               "(S) [m]")
        .def_property_readonly("node_mass", shows_if_any<double>(of_springs(&SpringNetwork::node_mass), 1), "(N) [kg]")
        .def_property_readonly("time", shows_if_any<double>(of_history(&core::History::time), 1),
                               "(K) of the records [s]; None where nothing moves, as the next three")
        .def_property_readonly("probe_displacement", &motion_of_probes, "(K, Q, 3) [m]")
        .def_property_readonly("kinetic_energy_history",
                               shows_if_any<double>(of_history(&core::History::kinetic_energy), 1), "(K) [J]")
        .def_property_readonly("strain_energy_history",
                               shows_if_any<double>(of_history(&core::History::strain_energy), 1), "(K) [J]")
        .def("__repr__", [](const Solution &s) {
            return fmt::format("<livermark.Solution of {} unknowns: {}>", s.degrees_of_freedom,
                               core::to_string(s.status));
        });
    problem.def("solve", &solve, py::arg("model"),
                "Solves with one of models(). Other Python threads run meanwhile. Returns Solution; that one was not "
                "found is a status,\nnot an error. Raises InputError.");
}

} // namespace livermark::python
