#include <algorithm>
#include <fmt/format.h>
#include <utility>

#include "python/bindings/springs.hpp"
#include "support/input_error.hpp"

namespace livermark::python {

namespace {

constexpr const char *of_edges = "edges", *of_law = "law", *of_coupled = "coupled"; ///< what comes first in a pickle
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
        return py::make_tuple(of_edges, points, copied<int>(springs.network.edges, 2),
                              numbers(springs.network.stiffness), numbers(springs.network.node_mass),
                              numbers(springs.network.rest_length));
    std::vector<std::array<double, 3>> materials;
    for (const auto &material : body->materials)
        materials.push_back({material.density, material.young_modulus, material.poisson_ratio});
    return py::make_tuple(is_coupled ? of_coupled : of_law, points, copied<int>(body->mesh.tetrahedra, 4),
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
    if (kind == of_edges && kept.size() == items_of_edges) {
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
    if ((kind == of_law || kind == of_coupled) && kept.size() == items_of_body)
        return springs_of_body({std::make_shared<const core::Body>(body_of(kept)), py::cast<std::string>(kept[5]),
                                py::cast<std::optional<std::string>>(kept[6]), kind == of_coupled});
    refuse();
}

} // namespace

void add_pickling(py::class_<Springs> &springs) {
    springs.def(py::pickle(&to_pickle, &from_pickle));
}

} // namespace livermark::python
