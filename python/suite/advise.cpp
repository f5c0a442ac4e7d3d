#include "studies/advise/advise.hpp"

#include "meshes/io/body_reader.hpp"
#include "python/bindings/body.hpp"
#include "python/bindings/without_interpreter.hpp"
#include "python/suite/problem.hpp"
#include "studies/files.hpp"
#include "support/file_ending.hpp"

namespace livermark::python {

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

} // namespace livermark::python
