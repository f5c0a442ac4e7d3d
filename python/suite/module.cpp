#include <fmt/format.h>
#include <utility>

#include "core/support/files.hpp"
#include "meshes/cutting/cut_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "python/bindings/arrays.hpp"
#include "python/bindings/interpreter.hpp"
#include "python/suite/problem.hpp"
#include "results/records/result.hpp"
#include "studies/advise/advise.hpp"
#include "studies/files.hpp"
#include "studies/models/model_table.hpp"

namespace livermark::python {

namespace {

std::vector<std::string> stems(const char *folder, const char *word) {
    std::vector<std::string> names;
    for (const auto &file : studies::find_toml_files({}, folder, word))
        names.push_back(file.stem().string());
    return names;
}

/// What a file says of the program that wrote it, see "Where it comes from" in results/schema.md.
py::dict provenance(const std::string &command) {
    const auto found = results::current_provenance(command);
    py::dict attributes;
    attributes["software_version"] = found.software_version;
    attributes["git_commit"] = found.git_commit;
    attributes["created"] = found.created;
    attributes["command"] = found.command;
    attributes["cpu"] = found.cpu;
    attributes["compiler"] = found.compiler;
    attributes["build_type"] = found.build_type;
    attributes["threads"] = found.threads;
    return attributes;
}

} // namespace

void add_catalogue(py::module_ &module) {
    module.def(
        "bodies", [] { return stems(studies::bodies_folder, "body"); }, "Names of the bodies that ship.");
    module.def(
        "load_cases", [] { return stems(studies::load_cases_folder, "load case"); },
        "Names of the load cases that ship.");
    module.def(
        "models",
        [] {
            std::vector<std::string> names;
            for (const auto &model : models::all_models())
                names.push_back(model.name);
            return names;
        },
        "Names of the models.");
    module.def("_provenance", &provenance, py::arg("command"));
}

namespace {

std::string advise_on(const core::Body &body, const studies::AdviceOptions &options) {
    return studies::to_json(studies::advise(body, options, {}));
}

std::string advise_on_file(const std::string &body, std::optional<double> young_modulus,
                           std::optional<double> poisson_ratio, double tool_radius, std::optional<double> budget) {
    return without_interpreter([&] {
        const auto file = studies::find_toml_files({body}, studies::bodies_folder, "body").front();
        const bool is_mesh = support::file_ending(file) != ".toml";
        return advise_on(meshes::read_body(file, {young_modulus, poisson_ratio}),
                         {.tool_radius = tool_radius,
                          .budget = budget,
                          .is_material_assumed = is_mesh && !young_modulus.has_value()});
    });
}

std::string advise_on_arrays(const py::object &points, const py::object &tetrahedra, const py::object &young_modulus,
                             const py::object &poisson_ratio, const py::object &density, double tool_radius,
                             std::optional<double> budget, bool is_material_assumed) {
    const auto body = to_body(points, tetrahedra, young_modulus, poisson_ratio, density);
    return without_interpreter([&] {
        return advise_on(body,
                         {.tool_radius = tool_radius, .budget = budget, .is_material_assumed = is_material_assumed});
    });
}

} // namespace

void add_advise(py::module_ &module) {
    module.def("_advise_on_file", &advise_on_file, py::arg("body"), py::arg("young_modulus"), py::arg("poisson_ratio"),
               py::arg("tool_radius"), py::arg("budget"), "JSON of livermark.advise() for a body by name or path.");
    module.def("_advise_on_arrays", &advise_on_arrays, py::arg("points"), py::arg("tetrahedra"),
               py::arg("young_modulus"), py::arg("poisson_ratio"), py::arg("density"), py::arg("tool_radius"),
               py::arg("budget"), py::arg("is_material_assumed"), "JSON of livermark.advise() for arrays.");
}

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

/// Problems, models and the reference: the whole suite, with deal.II and CHOLMOD behind it.
PYBIND11_MODULE(_suite, module) {
    module.doc() = "Problems, solutions and scores of Livermark; import livermark instead.";
    livermark::python::translate_input_errors();
    livermark::python::work_at_the_end::register_with();
    livermark::python::add_problem(module);
    livermark::python::add_advise(module);
    livermark::python::add_catalogue(module);
    livermark::python::add_cut(module);
}
