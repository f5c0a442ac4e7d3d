#include <nlohmann/json.hpp>
#include <ostream>
#include <string>
#include <vector>

#include "core/part_springs.hpp"
#include "core/support/processes/child_process.hpp"
#include "studies/exchange/formats/export_format.hpp"
#include "studies/exchange/formats/ground_springs.hpp"

namespace livermark::exchange {

namespace {

/// Job of FEBio 4 (febio_spec 4.0), by python/livermark/convert/febio.py: linear tetrahedra of FEBio's "neo-Hookean",
/// dead forces at nodes, pressures that follow the surface, springs on edges for a capsule, and springs to nodes of
/// linear constraints for vessels and a foundation. FEBio writes <load case>.displacement.csv beside it.
void write_feb(std::ostream &out, const core::Problem &problem, const ExportChoices &) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    std::vector<double> pressure;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        pressure.push_back(core::follower_pressure(load_case, mesh, f));
    const auto tetrahedron_values = [&](double core::Material::*constant) {
        std::vector<double> values;
        for (int t = 0; t < mesh.num_tetrahedra(); ++t)
            values.push_back(problem.body->material_of(t).*constant);
        return values;
    };
    nlohmann::json fields;
    fields["load_case"] = load_case.name;
    fields["regime"] = std::string(core::to_string(load_case.regime));
    fields["press_depth"] = load_case.press_depth;
    fields["points"] = mesh.points;
    fields["tetrahedra"] = mesh.tetrahedra;
    fields["region"] = mesh.region;
    fields["region_names"] = mesh.region_names;
    fields["young_modulus"] = tetrahedron_values(&core::Material::young_modulus);
    fields["poisson_ratio"] = tetrahedron_values(&core::Material::poisson_ratio);
    fields["density"] = tetrahedron_values(&core::Material::density);
    const auto fem = discretise(mesh, 1);
    fields["prescribed_displacement"] = prescribed_displacement(load_case, fem);
    fields["dead_forces"] = nodal_forces({problem.body, core::without_follower_pressures(load_case)}, fem);
    fields["boundary_triangles"] = mesh.boundary_triangles;
    fields["boundary_patch"] = mesh.boundary_patch;
    fields["patch_names"] = mesh.patch_names;
    fields["follower_pressure"] = pressure;
    if (const auto &ball = load_case.touching)
        fields["ball"] = {ball->shape.radius, ball->start, ball->press};
    const core::CapsuleEdges capsule(*problem.body);
    if (!capsule.nodes.empty())
        fields["edge_springs"] = {capsule.nodes, capsule.stiffness};
    const SpringTable springs(ground_springs(problem, fem));
    if (!springs.rest.empty())
        fields["ground_springs"] = {springs.rest, springs.terms, springs.factor};
    out << support::run_python("convert.febio", {load_case.name}, fields.dump(), "a job for FEBio", "python3-numpy");
}

} // namespace

namespace formats {

namespace {

bool febio_has(FurtherKind part, const JobKind & /*job*/) {
    return part != FurtherKind::other;
}

} // namespace

ExportFormat febio() {
    return {.name = {},
            .summary = "a job of FEBio 4",
            .files = {{".feb", write_feb}},
            .only_when_named = true,
            .job_has = febio_has,
            .capsule_in_job =
                "springs on its edges, which are 12.5 % too stiff in shear and 25 % too soft where it grows "
                "in both directions"};
}

} // namespace formats

} // namespace livermark::exchange
