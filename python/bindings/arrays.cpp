#include "python/bindings/arrays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <map>
#include <memory>
#include <numbers>
#include <utility>

#include "core/mesh/plausible_liver.hpp"
#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"

namespace livermark::python {

namespace {

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Integers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

std::string shape_of(const py::array &array) {
    const std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim());
    return fmt::format("({}{})", fmt::join(shape, ", "), shape.size() == 1 ? "," : "");
}

/// numpy.ma hides numbers that are not known, and they would come to light here.
void refuse_masked(const py::handle &values, const std::string &name) {
    if (!py::hasattr(values, "mask") || !py::hasattr(values, "filled"))
        return;
    const auto mask = py::array::ensure(values.attr("mask"));
    if (mask && py::bool_(mask.attr("any")()))
        throw support::InputError(
            fmt::format("{0}: it has masked entries; give {0}.filled(...) with numbers for them", name));
    PyErr_Clear();
}

py::array as_array(const py::handle &values, const std::string &name, const char *wanted) {
    refuse_masked(values, name);
    auto array = py::array::ensure(values);
    if (!array || std::string_view("biuf").find(array.dtype().kind()) == std::string_view::npos) {
        PyErr_Clear();
        throw support::InputError(fmt::format("{}: this is no array of numbers; give {}", name, wanted));
    }
    return array;
}

[[noreturn]] void refuse_shape(const std::string &name, const py::array &array, const std::string &wanted) {
    throw support::InputError(fmt::format("{}: the shape is {}; give {}", name, shape_of(array), wanted));
}

void refuse_not_finite(const std::string &name, double value, py::ssize_t row) {
    if (!std::isfinite(value))
        throw support::InputError(fmt::format("{}: row {} has a {}; every entry has to be finite", name, row, value));
}

bool is_of_integers(const py::array &array) {
    return array.dtype().kind() == 'i' || array.dtype().kind() == 'u';
}

/// Whether it is a column, as files of meshes have values of cells and nodes: one number in each row.
bool is_column(const py::array &array) {
    return array.ndim() == 2 && array.shape(1) == 1;
}

Integers checked_nodes(const py::array &array, const std::string &name, std::size_t num_nodes) {
    if (!is_of_integers(array))
        throw support::InputError(fmt::format("{}: node numbers have to be integers", name));
    auto numbers = Integers::ensure(array);
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        if (const auto node = numbers.data()[i]; node < 0 || static_cast<std::size_t>(node) >= num_nodes)
            throw support::InputError(fmt::format("{}: there is no node {}; nodes are numbered from 0 to {}", name,
                                                  node, static_cast<std::int64_t>(num_nodes) - 1));
    return numbers;
}

/// As many zeros and ones as there are nodes are a mask, as files hold it, and no nodes.
void refuse_mask_of_integers(const Integers &numbers, const std::string &name, std::size_t num_nodes) {
    constexpr py::ssize_t fewest = 3; // of two or fewer nodes 0 and 1 are all there are
    const auto *begin = numbers.data();
    const bool is_mask = static_cast<std::size_t>(numbers.size()) == num_nodes && numbers.size() >= fewest &&
                         std::all_of(begin, begin + numbers.size(), [](std::int64_t n) { return n == 0 || n == 1; });
    if (is_mask)
        throw support::InputError(fmt::format("{0}: these are {1} zeros and ones, a mask and no node numbers; give "
                                              "{0}.astype(bool)",
                                              name, numbers.size()));
}

} // namespace

std::vector<core::Vector3> to_vectors(const py::handle &values, const std::string &name,
                                      std::optional<std::size_t> count) {
    const auto wanted = count ? fmt::format("one of shape ({}, 3)", *count) : std::string("one of shape (N, 3)");
    const auto array = as_array(values, name, wanted.c_str());
    if (array.ndim() != 2 || array.shape(1) != 3 || (count && static_cast<std::size_t>(array.shape(0)) != *count))
        refuse_shape(name, array, wanted);
    const auto numbers = Numbers::ensure(array);
    std::vector<core::Vector3> vectors;
    vectors.reserve(static_cast<std::size_t>(array.shape(0)));
    for (py::ssize_t i = 0; i < array.shape(0); ++i) {
        const double *row = numbers.data() + 3 * i;
        for (int c = 0; c < 3; ++c)
            refuse_not_finite(name, row[c], i);
        vectors.emplace_back(row[0], row[1], row[2]);
    }
    return vectors;
}

std::vector<double> to_numbers(const py::handle &values, const std::string &name, std::size_t count) {
    const auto wanted = fmt::format("a number, or an array of shape ({},)", count);
    const auto array = as_array(values, name, wanted.c_str());
    const bool is_one = array.ndim() == 0;
    if (!is_one && ((array.ndim() != 1 && !is_column(array)) || static_cast<std::size_t>(array.shape(0)) != count))
        refuse_shape(name, array, wanted);
    const auto numbers = Numbers::ensure(array);
    for (py::ssize_t i = 0; i < numbers.size(); ++i)
        refuse_not_finite(name, numbers.data()[i], i);
    if (is_one)
        return std::vector<double>(count, *numbers.data());
    return {numbers.data(), numbers.data() + numbers.size()};
}

std::vector<int> to_node_numbers(const py::handle &values, const std::string &name, py::ssize_t columns,
                                 std::size_t num_nodes) {
    const auto wanted = fmt::format("one of shape (M, {})", columns);
    const auto array = as_array(values, name, wanted.c_str());
    if (array.ndim() != 2 || array.shape(1) != columns)
        refuse_shape(name, array, wanted);
    const auto numbers = checked_nodes(array, name, num_nodes);
    return {numbers.data(), numbers.data() + numbers.size()};
}

std::vector<std::array<bool, 3>> to_mask(const py::handle &fixed, const std::string &name, std::size_t num_nodes) {
    std::vector<std::array<bool, 3>> mask(num_nodes, {false, false, false});
    if (fixed.is_none())
        return mask;
    const auto wanted = fmt::format("node numbers, or a mask of shape ({0},) or ({0}, 3)", num_nodes);
    const auto array = as_array(fixed, name, wanted.c_str());
    if (array.size() == 0 && array.ndim() == 1) // an empty list has no type
        return mask;
    if (array.dtype().kind() != 'b') {
        if (array.ndim() != 1 && !is_column(array))
            refuse_shape(name, array, wanted);
        const auto numbers = checked_nodes(array, name, num_nodes);
        refuse_mask_of_integers(numbers, name, num_nodes);
        for (py::ssize_t i = 0; i < numbers.size(); ++i)
            mask[static_cast<std::size_t>(numbers.data()[i])] = {true, true, true};
        return mask;
    }
    const bool is_of_components = array.ndim() == 2 && array.shape(1) == 3;
    if ((array.ndim() != 1 && !is_column(array) && !is_of_components) ||
        static_cast<std::size_t>(array.shape(0)) != num_nodes)
        refuse_shape(name, array, wanted);
    const auto flags = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(array);
    for (std::size_t i = 0; i < num_nodes; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            mask[i][c] = flags.data()[is_of_components ? 3 * i + c : i];
    return mask;
}

py::array_t<double> to_array(Eigen::VectorXd components) {
    auto owned = std::make_unique<Eigen::VectorXd>(std::move(components));
    const auto *data = owned->data();
    const std::vector<py::ssize_t> shape{owned->size() / 3, 3};
    const py::capsule owner(owned.release(), [](void *memory) { delete static_cast<Eigen::VectorXd *>(memory); });
    return py::array_t<double>(shape, data, owner);
}

py::array_t<double> to_array(const std::vector<core::Vector3> &field) {
    Eigen::VectorXd components(3 * static_cast<Eigen::Index>(field.size()));
    for (std::size_t i = 0; i < field.size(); ++i)
        components.segment<3>(3 * static_cast<Eigen::Index>(i)) = field[i];
    return to_array(std::move(components));
}

namespace {

/// Least volume of a tetrahedron, as a part of that of the regular tetrahedron with its longest edge: flatter ones have
/// no stiffness that a double can hold.
constexpr double flat = 1e-9;

void check_volumes(const core::TetraMesh &mesh) {
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        double longest = 0.0;
        for (const auto &[a, b] : core::tetrahedron_edges)
            longest =
                std::max(longest, (mesh.points[mesh.tetrahedra[t][b]] - mesh.points[mesh.tetrahedra[t][a]]).norm());
        const double part = 6.0 * std::numbers::sqrt2 * volumes[t] / (longest * longest * longest);
        if (!(part > flat))
            throw support::InputError(fmt::format("tetrahedra: number {} {}; {}", t,
                                                  part < -flat ? "is inverted" : "is flat",
                                                  part < -flat ? "exchange two of its nodes" : "remesh there"));
    }
}

void check_nodes(const core::TetraMesh &mesh) {
    std::vector<bool> is_used(mesh.points.size(), false);
    for (const auto &nodes : mesh.tetrahedra)
        for (const int node : nodes)
            is_used[node] = true;
    const auto unused = std::ranges::find(is_used, false);
    if (unused != is_used.end())
        throw support::InputError(
            fmt::format("points: number {} belongs to no tetrahedron; remove it", unused - is_used.begin()));
}

void warn(const std::string &text) {
    if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0)
        throw py::error_already_set();
}

void check_overlaps(const core::TetraMesh &mesh) {
    if (const auto two = core::tetrahedra_of_same_nodes(mesh.tetrahedra))
        throw support::InputError(
            fmt::format("tetrahedra: numbers {} and {} have the same nodes; remove one", two->first, two->second));
    if (const auto face = core::face_of_too_many(core::sorted_faces(mesh.tetrahedra)))
        throw support::InputError(
            fmt::format("tetrahedra: more than two have the face of points {} {} {}; remesh without overlaps",
                        face->at(0), face->at(1), face->at(2)));
    // Arrays do not say where a body was parted, so this may be as it is meant.
    if (const auto two = core::nodes_in_one_place(mesh.points))
        warn(fmt::format(
            "points: numbers {} and {} have the same coordinates; merge them, unless a cut parts the body there",
            two->first, two->second));
}

/// Says in a warning what speaks against lengths in metres.
void warn_of_unit(const core::TetraMesh &mesh) {
    for (const auto &doubt : core::doubts_about_unit(mesh.points))
        warn(fmt::format("points: {}", doubt));
}

void check(const core::Material &material) {
    if (!(material.density > 0.0))
        throw support::InputError(fmt::format("density: {} kg/m^3; it has to be positive", material.density));
    if (!(material.young_modulus > 0.0))
        throw support::InputError(fmt::format("young_modulus: {} Pa; it has to be positive", material.young_modulus));
    if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
        throw support::InputError(
            fmt::format("poisson_ratio: {}; it has to lie between -1 and 0.5, both excluded", material.poisson_ratio));
    if (material.poisson_ratio > core::largest_poisson_ratio)
        throw support::InputError(
            fmt::format("poisson_ratio: {:.12g} is so close to 0.5 that its equations have no solution "
                        "in double precision; take {} at most",
                        material.poisson_ratio, core::largest_poisson_ratio));
}

} // namespace

core::Body to_body(const py::handle &points, const py::handle &tetrahedra, const py::handle &young_modulus,
                   const py::handle &poisson_ratio, const py::handle &density) {
    core::Body body;
    body.name = "body";
    auto &mesh = body.mesh;
    mesh.points = to_vectors(points, "points");
    const auto nodes = to_node_numbers(tetrahedra, "tetrahedra", 4, mesh.points.size());
    if (nodes.empty())
        throw support::InputError("tetrahedra: there are none; mesh the volume, not only the surface");
    for (std::size_t i = 0; i < nodes.size(); i += 4)
        mesh.tetrahedra.push_back({nodes[i], nodes[i + 1], nodes[i + 2], nodes[i + 3]});
    check_volumes(mesh);
    check_nodes(mesh);
    check_overlaps(mesh);
    if (const auto apart = core::apart_by_faces(mesh.tetrahedra))
        throw support::InputError(fmt::format(
            "tetrahedra: numbers {} and {} are in parts that are not joined by faces, but at most by an edge or "
            "a node; join them, or keep one part",
            apart->first, apart->second));
    warn_of_unit(mesh);

    const std::size_t count = mesh.tetrahedra.size();
    const auto young = to_numbers(young_modulus, "young_modulus", count);
    const auto poisson = to_numbers(poisson_ratio, "poisson_ratio", count);
    const auto rho = to_numbers(density, "density", count);
    std::map<std::array<double, 3>, int> region_of;
    for (std::size_t t = 0; t < count; ++t) {
        const auto [found, is_new] = region_of.try_emplace({rho[t], young[t], poisson[t]}, mesh.region_names.size());
        if (is_new) {
            body.materials.push_back({rho[t], young[t], poisson[t]});
            check(body.materials.back());
            mesh.region_names.push_back(fmt::format("material {}", mesh.region_names.size()));
        }
        mesh.region.push_back(found->second);
    }
    for (const auto &doubt : core::doubts_about_materials(body.materials, mesh.region_names))
        warn(doubt);
    return body;
}

} // namespace livermark::python
