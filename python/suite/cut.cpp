#include <fmt/format.h>
#include <utility>

#include "meshes/cutting/cut_body_file.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "python/bindings/without_interpreter.hpp"
#include "python/suite/problem.hpp"
#include "studies/files.hpp"

namespace livermark::python {

namespace {

using meshes::CutBody;

CutBody cut_body(const std::string &body, const meshes::CutWords &words, const std::optional<std::string> &output) {
    return without_interpreter([&] {
        const auto cut = meshes::cut_of(words, "livermark.cut()");
        auto result = meshes::cut(
            meshes::read_body(studies::find_toml_files({body}, studies::bodies_folder, "body").front()), cut);
        if (output)
            meshes::write_cut_body(*output, result, "livermark.cut()");
        return result;
    });
}

/// Rows of an array that Python cannot write to.
template <class Scalar, class Pick> auto rows(Pick pick, py::ssize_t columns) {
    return [=](const py::object &self) {
        const auto &values = pick(self.cast<const CutBody &>());
        std::vector<py::ssize_t> shape{static_cast<py::ssize_t>(values.size())};
        if (columns > 1)
            shape.push_back(columns);
        return view(reinterpret_cast<const Scalar *>(values.data()), shape, self);
    };
}

} // namespace

void add_cut(py::module_ &module) {
    py::class_<CutBody>(module, "CutBody", "What a cut leaves of a body. Arrays are views that cannot be written to.")
        .def_property_readonly("points",
                               rows<double>(
                                   [](const CutBody &c) -> const auto & { return c.body.mesh.points; }, 3),
                               "(N, 3) [m]")
        .def_property_readonly("tetrahedra",
                               rows<int>(
                                   [](const CutBody &c) -> const auto & { return c.body.mesh.tetrahedra; }, 4),
                               "(M, 4) node numbers")
        .def_property_readonly("region",
                               rows<int>(
                                   [](const CutBody &c) -> const auto & { return c.body.mesh.region; }, 1),
                               "(M) index into region_names")
        .def_property_readonly(
            "region_names", [](const CutBody &c) { return c.body.mesh.region_names; }, "(R) one for each material")
        .def_property_readonly("boundary_triangles",
                               rows<int>(
                                   [](const CutBody &c) -> const auto & { return c.body.mesh.boundary_triangles; }, 3),
                               "(T, 3) node numbers, right-handed seen from outside")
        .def_property_readonly("boundary_patch",
                               rows<int>(
                                   [](const CutBody &c) -> const auto & { return c.body.mesh.boundary_patch; }, 1),
                               "(T) index into patch_names")
        .def_property_readonly(
            "patch_names", [](const CutBody &c) { return c.body.mesh.patch_names; },
            "(Q) named parts of the boundary; the new surface is 'wound'")
        .def_property_readonly("parent_tetrahedron",
                               rows<int>(
                                   [](const CutBody &c) -> const auto & { return c.parents.front(); }, 1),
                               "(M) the tetrahedron before the cut that each is, or is a part of")
        .def_readonly("volume_before", &CutBody::volume_before, "[m^3]")
        .def_readonly("removed_volume", &CutBody::removed_volume, "[m^3]")
        .def_readonly("removed_mass", &CutBody::removed_mass, "[kg]")
        .def_readonly("wound_area", &CutBody::wound_area, "[m^2]")
        .def_property_readonly(
            "num_small_pieces", [](const CutBody &c) { return c.small_pieces.size(); },
            "how many are bodies of their own, with small_pieces='keep'")
        .def_readonly("notes", &CutBody::notes, "sentences on what was taken away")
        .def("__repr__", [](const CutBody &c) {
            return fmt::format("<livermark.CutBody {} of {} tetrahedra>", c.body.name, c.body.mesh.num_tetrahedra());
        });
    module.def(
        "cut",
        [](const std::string &body, std::optional<std::string> region, std::optional<double> margin,
           std::vector<double> half_space, std::vector<double> blade, std::optional<double> thickness, std::string way,
           std::string small_pieces, const std::optional<std::string> &output) {
            return cut_body(body,
                            {std::move(region), margin, std::move(half_space), std::move(blade), thickness,
                             std::move(way), std::move(small_pieces)},
                            output);
        },
        py::arg("body"), py::arg("region"), py::arg("margin"), py::arg("half_space"), py::arg("blade"),
        py::arg("thickness"), py::arg("way"), py::arg("small_pieces"), py::arg("output"),
        "Cuts a body at rest, see livermark.cut(), whose arguments these are.");
}

} // namespace livermark::python
