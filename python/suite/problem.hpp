#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/problem.hpp"
#include "python/bindings/arrays.hpp"

namespace livermark::python {

/// Property of an array that Python cannot write to; None where there is none.
/// @param pick  (owner): where the array is, or null
template <class Owner, class Scalar, class Pick> auto read_only(Pick pick, py::ssize_t columns) {
    return [=](const py::object &self) -> py::object {
        const auto *values = pick(self.cast<const Owner &>());
        if (!values)
            return py::none();
        std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values->size())};
        if (columns > 1)
            shape.push_back(columns);
        return view(reinterpret_cast<const Scalar *>(values->data()), shape, self);
    };
}

/// Adds the arrays and names of a mesh.
/// @param mesh_of  (owner): the mesh
template <class Owner, class MeshOf> void add_mesh(py::class_<Owner> &owner, MeshOf mesh_of) {
    const auto add = [&]<class Scalar, class Member>(const char *name, Scalar, Member member, int columns,
                                                     const char *doc) {
        owner.def_property_readonly(
            name, read_only<Owner, Scalar>([=](const Owner &o) { return &(mesh_of(o).*member); }, columns), doc);
    };
    const auto add_names = [&](const char *name, auto member, const char *doc) {
        owner.def_property_readonly(
            name, [=](const Owner &o) { return mesh_of(o).*member; }, doc);
    };
    using Mesh = core::TetraMesh;
    add("points", double{}, &Mesh::points, 3, "(N, 3) [m]");
    add("tetrahedra", int{}, &Mesh::tetrahedra, 4, "(M, 4) node numbers");
    add("region", int{}, &Mesh::region, 1, "(M) index into region_names");
    add("boundary_triangles", int{}, &Mesh::boundary_triangles, 3,
        "(T, 3) node numbers, right-handed seen from outside");
    add("boundary_patch", int{}, &Mesh::boundary_patch, 1, "(T) index into patch_names");
    add_names("region_names", &Mesh::region_names, "(R) one for each material");
    add_names("patch_names", &Mesh::patch_names, "(Q) named parts of the boundary; 'wound' where the body is cut");
}

/// Problem of Python: a body with its loads, scaled, and what a user should know of the input.
struct LoadedBody {
    core::Problem problem;
    std::vector<std::string> notes;
};

/// Adds the class Problem, and the function that reads one.
void add_problem(py::module_ &module);

/// Adds the class Solution and Problem.solve().
void add_solve(py::module_ &module, py::class_<LoadedBody> &problem);

/// Adds the class Score and Problem.score().
void add_score(py::module_ &module, py::class_<LoadedBody> &problem);

/// Adds the class CutBody, and the function that cuts one.
void add_cut(py::module_ &module);

/// Adds the functions behind livermark.advise().
void add_advise(py::module_ &module);

/// Adds the names of bodies, load cases and models.
void add_catalogue(py::module_ &module);

} // namespace livermark::python
