#include "python/bindings/arrays.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <utility>

#include "support/input_error.hpp"

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

} // namespace livermark::python
