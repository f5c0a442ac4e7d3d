#include <fmt/format.h>
#include <ostream>
#include <string>

#include "core/support/processes/child_process.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "studies/exchange/formats/json_text.hpp"

namespace livermark::exchange {

namespace {

/// Job of FEBio 4 (febio_spec 4.0), by python/livermark/convert/febio.py: linear tetrahedra of FEBio's "neo-Hookean",
/// dead forces at nodes, and pressures that follow the surface. FEBio writes <load case>.displacement.csv beside it.
void write_feb(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    std::vector<double> pressure;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        pressure.push_back(core::follower_pressure(load_case, mesh, f));
    const auto tetrahedron_values = [&](double core::Material::*constant) {
        std::vector<double> values;
        for (const int region : mesh.region)
            values.push_back(problem.body->materials[region].*constant);
        return json(values);
    };
    std::string fields;
    const auto add = [&](const char *name, const std::string &value) {
        fields += fmt::format("{}\"{}\":{}", fields.empty() ? "" : ",", name, value);
    };
    add("load_case", json(load_case.name));
    add("regime", json(std::string(core::to_string(load_case.regime))));
    add("press_depth", json(load_case.press_depth));
    add("points", json(mesh.points));
    add("tetrahedra", json(mesh.tetrahedra));
    add("region", json(mesh.region));
    add("region_names", json(mesh.region_names));
    add("young_modulus", tetrahedron_values(&core::Material::young_modulus));
    add("poisson_ratio", tetrahedron_values(&core::Material::poisson_ratio));
    add("density", tetrahedron_values(&core::Material::density));
    const auto fem = discretise(mesh, 1);
    add("prescribed_displacement", json(prescribed_displacement(load_case, fem)));
    add("dead_forces", json(nodal_forces({problem.body, core::without_follower_pressures(load_case)}, fem)));
    add("boundary_triangles", json(mesh.boundary_triangles));
    add("boundary_patch", json(mesh.boundary_patch));
    add("patch_names", json(mesh.patch_names));
    add("follower_pressure", json(pressure));
    out << support::run_python("convert.febio", {load_case.name}, '{' + fields + '}', "a job for FEBio",
                               "python3-numpy");
}

} // namespace

namespace formats {

ExportFormat febio() {
    return {.name = {}, .summary = "a job of FEBio 4", .files = {{".feb", write_feb}}, .only_when_named = true};
}

} // namespace formats

} // namespace livermark::exchange
