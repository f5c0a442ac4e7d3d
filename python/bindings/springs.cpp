#include "python/bindings/springs.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <set>
#include <span>
#include <utility>
#include <variant>

#include "core/mesh/plausible_liver.hpp"
#include "core/support/input_error.hpp"
#include "msm/engine_parameters.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

namespace {

Springs make_springs(const py::object &points, const py::object &tetrahedra, const py::object &young_modulus,
                     const py::object &poisson_ratio, const std::string &law, const py::object &density,
                     const std::optional<std::string> &volume_term) {
    support::find_named(msm::all_spring_laws(), law, "spring law");
    auto body = std::make_shared<const core::Body>(to_body(points, tetrahedra, young_modulus, poisson_ratio, density));
    return springs_of_body({std::move(body), law, volume_term, false});
}

Springs make_coupled_springs(const py::object &points, const py::object &tetrahedra, const py::object &young_modulus,
                             const py::object &poisson_ratio, const std::string &model, const py::object &density) {
    auto body = std::make_shared<const core::Body>(to_body(points, tetrahedra, young_modulus, poisson_ratio, density));
    return springs_of_body({std::move(body), model, {}, true});
}

/// Rows of an array of an engine, without a second axis where it has one column.
template <class Scalar> py::array_t<Scalar> rows_of(const std::vector<Scalar> &values, std::size_t columns) {
    std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size() / columns)};
    if (columns > 1)
        shape.push_back(static_cast<py::ssize_t>(columns));
    py::array_t<Scalar> array(shape);
    std::copy(values.begin(), values.end(), array.mutable_data());
    return array;
}

py::dict parameters_of_engine(const py::object &points, const py::object &tetrahedra, const py::object &young_modulus,
                              const py::object &poisson_ratio, const std::string &engine, const std::string &law,
                              const py::object &density, std::optional<int> substeps, double frame) {
    const auto body = to_body(points, tetrahedra, young_modulus, poisson_ratio, density);
    const auto parameters = msm::engine_parameters(body, engine, {law, substeps, frame});
    py::dict settings, arrays, units, meanings;
    const auto describe = [&](const auto &item) {
        units[py::str(item.name)] = item.unit;
        meanings[py::str(item.name)] = item.meaning;
    };
    for (const auto &setting : parameters.settings) {
        settings[py::str(setting.name)] = setting.value;
        describe(setting);
    }
    for (const auto &array : parameters.arrays) {
        arrays[py::str(array.name)] =
            std::visit([&](const auto &values) -> py::object { return rows_of(values, array.columns); }, array.values);
        describe(array);
    }
    py::dict result;
    result["engine"] = parameters.engine;
    result["settings"] = settings;
    result["arrays"] = arrays;
    result["units"] = units;
    result["meanings"] = meanings;
    result["notes"] = parameters.notes;
    result["cannot"] = parameters.cannot;
    result["text"] = parameters.text ? py::object(py::str(parameters.text->text)) : py::object(py::none());
    return result;
}

void refuse_not_positive(const std::vector<double> &values, const char *name) {
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!(values[i] > 0.0))
            throw support::InputError(fmt::format("{}: number {} is {}; it has to be positive", name, i, values[i]));
}

void refuse_wrong_edges(const std::vector<core::Vector3> &nodes, const std::vector<std::array<int, 2>> &edges) {
    std::set<std::array<int, 2>> seen;
    for (const auto &[i, j] : edges) {
        if (!seen.insert({std::min(i, j), std::max(i, j)}).second)
            throw support::InputError(
                fmt::format("edges: nodes {} and {} are joined twice; add the two stiffnesses", i, j));
        if (!((nodes[j] - nodes[i]).norm() > 0.0))
            throw support::InputError(
                fmt::format("edges: nodes {} and {} have the same coordinates; merge them", i, j));
    }
}

Springs given_springs(const py::object &points, const py::object &edges, const py::object &stiffness,
                      const py::object &node_mass, const py::object &rest_length) {
    auto nodes = to_vectors(points, "points");
    core::SpringNetwork network;
    const auto ends = to_node_numbers(edges, "edges", 2, nodes.size());
    for (std::size_t i = 0; i < ends.size(); i += 2)
        network.edges.push_back({ends[i], ends[i + 1]});
    network.stiffness = to_numbers(stiffness, "stiffness", network.edges.size());
    network.node_mass = to_numbers(node_mass, "node_mass", nodes.size());
    if (rest_length.is_none())
        for (const auto &[i, j] : network.edges)
            network.rest_length.push_back((nodes[j] - nodes[i]).norm());
    else
        network.rest_length = to_numbers(rest_length, "rest_length", network.edges.size());
    return springs_of_network(std::move(nodes), network);
}

std::vector<core::Vector3> positions_of(const Springs &springs, const py::object &positions) {
    return to_vectors(positions, "positions", springs.points.size());
}

/// Elastic force on each node [N].
py::array_t<double> elastic_forces(const Springs &springs, const py::object &positions) {
    auto force = msm::elastic_gradient(springs.body, positions_of(springs, positions));
    for (auto &f : force)
        f = -f;
    return to_array(force);
}

/// Entries of the second derivative of the energy: their rows, their columns and themselves.
py::tuple tangent(const Springs &springs, const py::object &positions) {
    const auto matrix = msm::elastic_hessian(springs.body, positions_of(springs, positions), msm::Tangent::exact);
    py::array_t<int> rows(matrix.nonZeros()), columns(matrix.nonZeros());
    py::array_t<double> values(matrix.nonZeros());
    py::ssize_t k = 0;
    for (Eigen::Index column = 0; column < matrix.outerSize(); ++column)
        for (Eigen::SparseMatrix<double>::InnerIterator entry(matrix, column); entry; ++entry, ++k) {
            rows.mutable_data()[k] = static_cast<int>(entry.row());
            columns.mutable_data()[k] = static_cast<int>(column);
            values.mutable_data()[k] = entry.value();
        }
    return py::make_tuple(rows, columns, values);
}

std::string summary(const Springs &springs) {
    return fmt::format("<livermark.Springs of {} nodes and {} edges>", springs.points.size(),
                       springs.network.edges.size());
}

/// A read-only property that shows memory of the springs.
template <class Scalar, class Pick> auto shows(Pick pick, py::ssize_t columns) {
    return [=](const py::object &self) {
        const auto &values = pick(self.cast<const Springs &>());
        std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size())};
        if (columns > 1)
            shape.push_back(columns);
        return view(reinterpret_cast<const Scalar *>(values.data()), shape, self);
    };
}

} // namespace

Springs springs_of_body(SpringsSource source) {
    const auto &body = *source.body;
    if (source.is_coupled) {
        auto springs = msm::coupled_springs_with_volume(body, msm::find_coupled_springs(source.name));
        return {body.mesh.points, {springs.node_mass, {}, {}, {}}, springs, std::move(source)};
    }
    const auto &law = support::find_named(msm::all_spring_laws(), source.name, "spring law");
    if (!source.volume_term) {
        auto network = msm::spring_network(body, law);
        return {body.mesh.points, network, network, std::move(source)};
    }
    const auto &term = support::find_named(msm::all_volume_terms(), *source.volume_term, "volume term");
    auto both = msm::springs_with_volume(body, msm::springs_beside_volume(body, law), term);
    return {body.mesh.points, std::move(both.springs), std::move(both.body), std::move(source)};
}

Springs springs_of_network(std::vector<core::Vector3> points, const core::SpringNetwork &network) {
    refuse_wrong_edges(points, network.edges);
    refuse_not_positive(network.stiffness, "stiffness");
    refuse_not_positive(network.node_mass, "node_mass");
    refuse_not_positive(network.rest_length, "rest_length");
    return {std::move(points), network, network};
}

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

void add_springs(py::module_ &module) {
    py::class_<Springs> springs(module, "Springs",
                                "Point masses and the springs between them, which can be pickled. Arrays are "
                                "views that cannot be written to.");
    add_pickling(springs);
    springs
        .def(py::init(&given_springs), py::arg("points"), py::arg("edges"), py::arg("stiffness"), py::arg("node_mass"),
             py::arg("rest_length") = py::none(),
             "Springs of your own.\n\n"
             "points: (N, 3) [m], where the body is at rest. edges: (S, 2) node numbers. stiffness: (S) or a number "
             "[N/m].\nnode_mass: (N) or a number [kg]. rest_length: (S) or a number [m]; by default the lengths at the "
             "points.\nRaises InputError.")
        .def_property_readonly("points",
                               shows<double>(
                                   [](const Springs &s) -> const auto & { return s.points; }, 3),
                               "(N, 3) where the nodes are at rest [m]")
        .def_property_readonly("edges",
                               shows<int>(
                                   [](const Springs &s) -> const auto & { return s.network.edges; }, 2),
                               "(S, 2) int32, the nodes that each spring joins; empty of coupled_springs()")
        .def_property_readonly("stiffness",
                               shows<double>(
                                   [](const Springs &s) -> const auto & { return s.network.stiffness; }, 1),
                               "(S) k [N/m]")
        .def_property_readonly("rest_length",
                               shows<double>(
                                   [](const Springs &s) -> const auto & { return s.network.rest_length; }, 1),
                               "(S) l0 [m]")
        .def_property_readonly("node_mass",
                               shows<double>(
                                   [](const Springs &s) -> const auto & { return s.network.node_mass; }, 1),
                               "(N) [kg]")
        .def(
            "elastic_energy",
            [](const Springs &s, const py::object &x) { return msm::elastic_energy(s.body, positions_of(s, x)); },
            py::arg("positions"), "U [J] of positions of shape (N, 3) [m].")
        .def("elastic_forces", &elastic_forces, py::arg("positions"),
             "-dU/dx, shape (N, 3) [N], of positions of shape (N, 3) [m]: what springs and volumes pull the nodes "
             "with.")
        .def("tangent", &tangent, py::arg("positions"),
             "Second derivative of U [N/m] at positions of shape (N, 3) [m], as rows, columns and values of its "
             "entries, both\ntriangles; component c of node i has the number 3 i + c. "
             "scipy.sparse.csc_matrix((values, (rows, columns))) makes a\nmatrix of them.")
        .def("__repr__", &summary);

    module.def("springs", &make_springs, py::arg("points"), py::arg("tetrahedra"), py::arg("young_modulus"),
               py::arg("poisson_ratio"), py::arg("law") = "lloyd", py::arg("density") = 1060.0,
               py::arg("volume_term") = py::none(),
               "The springs of a mesh, one along each edge.\n\n"
               "points: (N, 3) [m]. tetrahedra: (M, 4) node numbers, positive volumes. young_modulus [Pa], "
               "poisson_ratio and\ndensity [kg/m^3]: a number each, or (M) for bodies of several materials. law: one "
               "of spring_laws(). volume_term:\none of volume_terms(); then springs carry lambda = mu of the material, "
               "and the term the rest of lambda.\nReturns Springs. Raises InputError.");
    module.def("coupled_springs", &make_coupled_springs, py::arg("points"), py::arg("tetrahedra"),
               py::arg("young_modulus"), py::arg("poisson_ratio"), py::arg("model") = "nodal_neo_hookean",
               py::arg("density") = 1060.0,
               "Springs that are coupled to each other, the most accurate ones here. model: one of "
               "coupled_spring_models().\nOther arguments as of springs(). Returns Springs without edges of their own. "
               "Raises InputError.");
    module.def("engine_parameters", &parameters_of_engine, py::arg("points"), py::arg("tetrahedra"),
               py::arg("young_modulus"), py::arg("poisson_ratio"), py::arg("engine"), py::arg("law") = "lloyd",
               py::arg("density") = 1060.0, py::arg("substeps") = py::none(), py::arg("frame") = 1.0 / 60.0,
               "What brings an engine nearest to tissue, as `livermark springs` writes it.\n\n"
               "engine: one of engines(). substeps: in a frame, by default what suits the engine. frame [s]. Other "
               "arguments as of\nsprings(). Returns a dict: engine; settings, numbers by name; arrays, numpy arrays by "
               "name; units and meanings of\nboth, by name; notes and cannot, sentences; text, such as a model file, "
               "or None. SI units. Raises InputError.");
    module.def(
        "engines", [] { return support::names_of(msm::all_engines()); },
        "Names of the engines, for engine_parameters().");
    module.def("_doubts_about_unit",
               [](const py::object &points) { return core::doubts_about_unit(to_vectors(points, "points")); });
    module.def(
        "spring_laws", [] { return support::names_of(msm::all_spring_laws()); },
        "Names of the spring laws, for springs().");
    module.def(
        "volume_terms", [] { return support::names_of(msm::all_volume_terms()); },
        "Names of the volume terms, for springs().");
    module.def(
        "coupled_spring_models", [] { return support::names_of(msm::all_coupled_springs()); },
        "Names of the models, for coupled_springs().");
}

namespace {

constexpr const char *kind_edges = "edges", *kind_law = "law",
                     *kind_coupled = "coupled"; ///< what comes first in a pickle
constexpr std::size_t items_of_edges = 6, items_of_body = 7;

template <class Scalar, class Value> py::array_t<Scalar> copied(const std::vector<Value> &values, py::ssize_t columns) {
    py::array_t<Scalar> array({static_cast<py::ssize_t>(values.size()), columns});
    const auto *data = reinterpret_cast<const Scalar *>(values.data());
    std::copy(data, data + array.size(), array.mutable_data());
    return array;
}

py::array_t<double> numbers(const std::vector<double> &values) {
    return py::array_t<double>(static_cast<py::ssize_t>(values.size()), values.data());
}

py::tuple to_pickle(const Springs &springs) {
    const auto &[body, name, volume_term, is_coupled] = springs.source;
    const auto points = copied<double>(springs.points, 3);
    if (!body)
        return py::make_tuple(kind_edges, points, copied<int>(springs.network.edges, 2),
                              numbers(springs.network.stiffness), numbers(springs.network.node_mass),
                              numbers(springs.network.rest_length));
    std::vector<std::array<double, 3>> materials;
    for (const auto &material : body->materials)
        materials.push_back({material.density, material.young_modulus, material.poisson_ratio});
    return py::make_tuple(is_coupled ? kind_coupled : kind_law, points, copied<int>(body->mesh.tetrahedra, 4),
                          copied<int>(body->mesh.region, 1), copied<double>(materials, 3), name, volume_term);
}

[[noreturn]] void refuse() {
    throw support::InputError("springs: the pickle is of another version of livermark; make the springs again");
}

core::Body body_of(const py::tuple &kept) {
    core::Body body;
    body.name = "body";
    body.mesh.points = to_vectors(kept[1], "points");
    const auto nodes = to_node_numbers(kept[2], "tetrahedra", 4, body.mesh.points.size());
    for (std::size_t i = 0; i < nodes.size(); i += 4)
        body.mesh.tetrahedra.push_back({nodes[i], nodes[i + 1], nodes[i + 2], nodes[i + 3]});
    for (const auto &material : to_vectors(kept[4], "materials")) {
        body.materials.push_back({material[0], material[1], material[2]});
        body.mesh.region_names.push_back(fmt::format("material {}", body.mesh.region_names.size()));
    }
    body.mesh.region = to_node_numbers(kept[3], "region", 1, body.materials.size());
    if (body.mesh.region.size() != body.mesh.tetrahedra.size())
        refuse();
    return body;
}

Springs from_pickle(const py::tuple &kept) {
    const auto kind = kept.empty() ? std::string() : py::cast<std::string>(kept[0]);
    if (kind == kind_edges && kept.size() == items_of_edges) {
        core::SpringNetwork network;
        auto points = to_vectors(kept[1], "points");
        const auto ends = to_node_numbers(kept[2], "edges", 2, points.size());
        for (std::size_t i = 0; i < ends.size(); i += 2)
            network.edges.push_back({ends[i], ends[i + 1]});
        network.stiffness = to_numbers(kept[3], "stiffness", network.edges.size());
        network.node_mass = to_numbers(kept[4], "node_mass", points.size());
        network.rest_length = to_numbers(kept[5], "rest_length", network.edges.size());
        return springs_of_network(std::move(points), network);
    }
    if ((kind == kind_law || kind == kind_coupled) && kept.size() == items_of_body)
        return springs_of_body({std::make_shared<const core::Body>(body_of(kept)), py::cast<std::string>(kept[5]),
                                py::cast<std::optional<std::string>>(kept[6]), kind == kind_coupled});
    refuse();
}

} // namespace

void add_pickling(py::class_<Springs> &springs) {
    springs.def(py::pickle(&to_pickle, &from_pickle));
}

} // namespace livermark::python
