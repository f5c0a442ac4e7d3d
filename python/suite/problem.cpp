#include "python/suite/problem.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <utility>
#include <vector>

#include "core/part_springs.hpp"
#include "core/solution.hpp"
#include "core/support/input_error.hpp"
#include "msm/elastic_body.hpp"
#include "python/bindings/interpreter.hpp"
#include "studies/exchange/exchange.hpp"
#include "studies/exchange/formats/ground_springs.hpp"
#include "studies/models/model_table.hpp"
#include "studies/run/run.hpp"

namespace livermark::python {

namespace {

LoadedBody read(const std::string &body, const std::string &load_case, std::optional<double> young_modulus,
                std::optional<double> poisson_ratio) {
    return without_interpreter([&]() -> LoadedBody {
        auto set = studies::read_scaled_problems({body}, load_case, {young_modulus, poisson_ratio});
        return {std::move(set.problems.front()), std::move(set.notes)};
    });
}

const core::TetraMesh &mesh_of(const LoadedBody &loaded) {
    return loaded.problem.body->mesh;
}

/// A constant of its material for each tetrahedron.
auto tetrahedron_values(double core::Material::*constant) {
    return [=](const LoadedBody &loaded) {
        const auto &body = *loaded.problem.body;
        py::array_t<double> values(static_cast<py::ssize_t>(body.mesh.region.size()));
        for (std::size_t t = 0; t < body.mesh.region.size(); ++t)
            values.mutable_data()[t] = body.material_of(t).*constant;
        return values;
    };
}

msm::NodalConditions at_nodes(const core::Problem &problem) {
    return msm::nodal_conditions(problem, msm::lumped_masses(*problem.body));
}

/// Pressures that follow the surface; 0 on every other facet.
py::array follower_pressure(const LoadedBody &loaded) {
    const auto &mesh = mesh_of(loaded);
    py::array_t<double> pressure(static_cast<py::ssize_t>(mesh.num_boundary_triangles()));
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        pressure.mutable_data()[f] = core::follower_pressure(loaded.problem.load_case, mesh, f);
    return pressure;
}

py::array dead_forces(const LoadedBody &loaded) {
    const auto &[body, load_case] = loaded.problem;
    return to_array(at_nodes({body, core::without_follower_pressures(load_case)}).force);
}

py::array fixed(const LoadedBody &loaded) {
    const auto conditions = at_nodes(loaded.problem);
    py::array_t<bool> mask({static_cast<py::ssize_t>(conditions.displacement.size()), py::ssize_t{3}});
    for (std::size_t i = 0; i < conditions.displacement.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
            mask.mutable_data()[3 * i + c] = conditions.constraint[i][c] >= 0;
    return mask;
}

py::object ball(const LoadedBody &loaded) {
    const auto &tool = loaded.problem.load_case.touching;
    if (!tool || !exchange::is_plain_ball(*tool))
        return py::none();
    return py::make_tuple(tool->shape.radius, to_array(std::vector{tool->start}).attr("reshape")(3),
                          to_array(std::vector{tool->press}).attr("reshape")(3));
}

py::object vessels(const py::object &self) {
    const auto &tree = self.cast<const LoadedBody &>().problem.body->vessels;
    if (!tree)
        return py::none();
    const auto points = static_cast<py::ssize_t>(tree->points.size());
    const auto segments = static_cast<py::ssize_t>(tree->segments.size());
    return py::make_tuple(view(reinterpret_cast<const double *>(tree->points.data()), {points, 3}, self),
                          view(tree->radius.data(), {points}, self),
                          view(reinterpret_cast<const int *>(tree->segments.data()), {segments, 2}, self));
}

std::vector<std::string> further_nouns(const LoadedBody &loaded) {
    std::vector<std::string> nouns;
    for (const auto &part : studies::further_parts(loaded.problem))
        if (part.kind == exchange::FurtherKind::other) // all else has a property
            nouns.push_back(part.noun);
    return nouns;
}

/// (n, columns), a copy.
template <std::size_t columns> py::array_t<int> rows(const std::vector<std::array<int, columns>> &values) {
    const std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size()), static_cast<py::ssize_t>(columns)};
    return py::array_t<int>(shape, values.front().data());
}

py::array_t<double> numbers(const std::vector<double> &values) {
    return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::object edge_springs(const LoadedBody &loaded) {
    const core::CapsuleEdges edges(*loaded.problem.body);
    if (edges.nodes.empty())
        return py::none();
    return py::make_tuple(rows(edges.nodes), numbers(edges.stiffness));
}

py::object ground_springs(const LoadedBody &loaded) {
    const exchange::SpringTable table(
        exchange::ground_springs(loaded.problem, exchange::discretise(mesh_of(loaded), 1)));
    if (table.rest.empty())
        return py::none();
    return py::make_tuple(to_array(table.rest), rows(table.terms), numbers(table.factor));
}

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

template <class Member> auto springs_member(Member member) {
    return [=](const core::Solution &s) { return s.springs ? &((*s.springs).*member) : nullptr; };
}

template <class Member> auto history_member(Member member) {
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

void add_problem(py::module_ &module) {
    py::class_<LoadedBody> problem(module, "Problem",
                                   "A body under a load case, with the loads scaled as in a run. Arrays of the mesh "
                                   "are views that cannot be written to.");
    problem
        .def_property_readonly(
            "body", [](const LoadedBody &p) { return p.problem.body->name; }, "name of the body")
        .def_property_readonly(
            "load_case", [](const LoadedBody &p) { return p.problem.load_case.name; }, "name of the load case")
        .def_property_readonly(
            "regime", [](const LoadedBody &p) { return core::to_string(p.problem.load_case.regime); },
            "small or large deformations")
        .def_property_readonly(
            "notes", [](const LoadedBody &p) { return p.notes; }, "sentences on what had to be assumed")
        .def_property_readonly("young_modulus", tetrahedron_values(&core::Material::young_modulus), "(M) [Pa]")
        .def_property_readonly("poisson_ratio", tetrahedron_values(&core::Material::poisson_ratio), "(M)")
        .def_property_readonly("density", tetrahedron_values(&core::Material::density), "(M) [kg/m^3]")
        .def_property_readonly(
            "prescribed_displacement", [](const LoadedBody &p) { return to_array(at_nodes(p.problem).displacement); },
            "(N, 3) [m], NaN where a component is free")
        .def_property_readonly("fixed", &fixed, "(N, 3) bool, the components that are prescribed; for Simulation")
        .def_property_readonly(
            "forces", [](const LoadedBody &p) { return to_array(at_nodes(p.problem).force); },
            "(N, 3) [N], a third of each facet's traction at its corners, and the acceleration of the body")
        .def_property_readonly(
            "press_depth", [](const LoadedBody &p) { return p.problem.load_case.press_depth; },
            "[m], not 0 where a place presses: forces are those of one newton of it, and are to be multiplied by the "
            "number\nwith sum(forces * displacement) = press_depth")
        .def_property_readonly("ball", &ball,
                               "(radius, start, press) [m] of a rigid ball that presses without friction: the centre "
                               "where it just\ntouches "
                               "the body at rest, and by which it moves; None where there is none")
        .def_property_readonly("vessels", &vessels,
                               "(points (V, 3) [m], radius (V) [m], segments (W, 2) numbers of points) of vessels as "
                               "lines; None where the body\nhas none")
        .def_property_readonly("edge_springs", &edge_springs,
                               "nodes (S, 2) and stiffness (S) [N/m] of springs on edges that stand for the capsule; "
                               "None where the body has\nnone")
        .def_property_readonly(
            "ground_springs", &ground_springs,
            "(rest, terms, factor) of GroundSprings, which stand for vessels as lines and an elastic "
            "foundation; None\nwithout these")
        .def_property_readonly("further_parts", &further_nouns,
                               "what acts on the body and is in none of these arrays, such as a ball with friction: "
                               "list of str")
        .def_property_readonly("follower_pressure", &follower_pressure,
                               "(T) [Pa], pressures that stay perpendicular to the moving surface, 0 elsewhere")
        .def_property_readonly("dead_forces", &dead_forces,
                               "(N, 3) [N], the part of forces that keeps its direction: without follower pressures")
        .def_property_readonly(
            "constraint_names", [](const LoadedBody &p) { return p.problem.load_case.constraint_names(); },
            "(P) the places whose force is a result: where displacement is prescribed, and what presses")
        .def("__repr__", [](const LoadedBody &p) {
            return fmt::format("<livermark.Problem {} on {}>", p.problem.load_case.name, p.problem.body->name);
        });
    add_mesh(problem, mesh_of);
    add_solve(module, problem);
    add_score(module, problem);
    module.def("problem", &read, py::arg("body"), py::arg("load_case"), py::arg("young_modulus") = py::none(),
               py::arg("poisson_ratio") = py::none(),
               "Reads a body, puts a load case on it, and scales the loads to their target.\n\n"
               "body: one of bodies(), or the path of a .toml or mesh file. load_case: one of load_cases(), or the "
               "path of a .toml.\nyoung_modulus [Pa]: of the first region, others keep their ratio to it. "
               "poisson_ratio: of every region.\nReturns Problem. Raises InputError.");
}

void add_solve(py::module_ &module, py::class_<LoadedBody> &problem) {
    using core::Solution;
    using core::SpringNetwork;
    py::class_<Solution>(module, "Solution", "What a model finds. Arrays are views that cannot be written to.")
        .def_property_readonly(
            "status", [](const Solution &s) { return core::to_string(s.status); }, "ok, diverged or not_converged")
        .def_readonly("message", &Solution::message, "why the status is not ok")
        .def_property_readonly("displacement",
                               read_only<core::Solution, double>([](const Solution &s) { return &s.displacement; }, 3),
                               "(N, 3) [m], of a load case that depends on time the static start")
        .def_property_readonly("reaction",
                               read_only<core::Solution, double>([](const Solution &s) { return &s.reaction; }, 3),
                               "(P, 3) force of each constraint on the body [N], as in Problem.constraint_names")
        .def_readonly("strain_energy", &Solution::strain_energy, "[J]")
        .def_readonly("degrees_of_freedom", &Solution::degrees_of_freedom, "unknowns, constrained ones included")
        .def_readonly("setup_seconds", &Solution::setup_seconds, "all that needs no loads [s]")
        .def_readonly("solve_seconds", &Solution::solve_seconds, "the rest [s]")
        .def_readonly("solver", &Solution::solver, "how linear systems were solved")
        .def_property_readonly("edges", read_only<core::Solution, int>(springs_member(&SpringNetwork::edges), 2),
                               "(S, 2) node numbers; None of finite elements, as the next three")
        .def_property_readonly(
            "stiffness", read_only<core::Solution, double>(springs_member(&SpringNetwork::stiffness), 1), "(S) [N/m]")
        .def_property_readonly(
            "rest_length", read_only<core::Solution, double>(springs_member(&SpringNetwork::rest_length), 1), "(S) [m]")
        .def_property_readonly(
            "node_mass", read_only<core::Solution, double>(springs_member(&SpringNetwork::node_mass), 1), "(N) [kg]")
        .def_property_readonly("time", read_only<core::Solution, double>(history_member(&core::History::time), 1),
                               "(K) of the records [s]; None where nothing moves, as the next three")
        .def_property_readonly("probe_displacement", &motion_of_probes, "(K, Q, 3) [m]")
        .def_property_readonly("kinetic_energy_history",
                               read_only<core::Solution, double>(history_member(&core::History::kinetic_energy), 1),
                               "(K) [J]")
        .def_property_readonly("strain_energy_history",
                               read_only<core::Solution, double>(history_member(&core::History::strain_energy), 1),
                               "(K) [J]")
        .def("__repr__", [](const Solution &s) {
            return fmt::format("<livermark.Solution of {} unknowns: {}>", s.degrees_of_freedom,
                               core::to_string(s.status));
        });
    problem.def("solve", &solve, py::arg("model"),
                "Solves with one of models(). Other Python threads run meanwhile. Returns Solution; that one was not "
                "found is a status,\nnot an error. Raises InputError.");
}

} // namespace livermark::python
