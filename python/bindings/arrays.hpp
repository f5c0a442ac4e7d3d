#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h> // in every source, so that all convert alike
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"

/// Numpy arrays in and out. Input is checked here, once. What goes out is a view of memory that C++ holds, or takes the
/// memory over; nothing is copied.
namespace livermark::python {

namespace py = pybind11;

/// @param name   of the argument, for messages
/// @param count  N, where it is known
/// @return shape (N), each finite
/// @throws support::InputError if the argument has another shape, or entries that are no finite numbers
std::vector<core::Vector3> to_vectors(const py::handle &values, const std::string &name,
                                      std::optional<std::size_t> count = {});

/// A number, or one for each of something.
/// @return shape (count)
/// @throws support::InputError as above
std::vector<double> to_numbers(const py::handle &values, const std::string &name, std::size_t count);

/// Node numbers, `columns` in a row.
/// @return shape (M * columns), each in [0, num_nodes)
/// @throws support::InputError as above, and for a number of a node that is not there
std::vector<int> to_node_numbers(const py::handle &values, const std::string &name, py::ssize_t columns,
                                 std::size_t num_nodes);

/// Which components of which nodes are fixed: None, node numbers, a mask of shape (N), or one of shape (N, 3).
/// @return shape (N)
/// @throws support::InputError as above
std::vector<std::array<bool, 3>> to_mask(const py::handle &fixed, const std::string &name, std::size_t num_nodes);

/// A view that cannot be written to, and keeps its owner alive.
template <class Scalar>
py::array view(const Scalar *data, const std::vector<py::ssize_t> &shape, const py::handle &owner) {
    py::array_t<Scalar> array(shape, data, owner);
    array.attr("setflags")(py::arg("write") = false);
    return array;
}

/// An array that takes over 3N components, 3 i + component for node i.
/// @return shape (N, 3)
py::array_t<double> to_array(Eigen::VectorXd components);

/// Shape (N, 3).
py::array_t<double> to_array(const std::vector<core::Vector3> &field);

/// A body of arrays. Tetrahedra of the same material are a region.
/// @param points         shape (N, 3) [m]
/// @param tetrahedra     shape (M, 4), node numbers, positive volumes
/// @param young_modulus  [Pa], here and below a number or shape (M)
/// @param density        [kg/m^3]
/// @throws support::InputError if shapes, node numbers, volumes or materials are wrong, or if a node is in no
/// tetrahedron
core::Body to_body(const py::handle &points, const py::handle &tetrahedra, const py::handle &young_modulus,
                   const py::handle &poisson_ratio, const py::handle &density);

} // namespace livermark::python
