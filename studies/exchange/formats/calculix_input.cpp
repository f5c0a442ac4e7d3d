#include "studies/exchange/formats/calculix_input.hpp"

#include <cmath>
#include <fmt/ostream.h>
#include <ostream>

#include "studies/exchange/formats/nodal_loads.hpp"

namespace livermark::studies {

using core::Vector3;

// CalculiX reads the first twenty characters of a number, so thirteen digits have to do.
void write_inp(std::ostream &out, const core::Problem &problem, int degree) {
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const auto fem = discretise(mesh, degree);
    fmt::print(out, "** body {}, load case {}\n*NODE, NSET=ALL_NODES\n", problem.body->name, load_case.name);
    for (std::size_t node = 0; node < fem.points.size(); ++node)
        fmt::print(out, "{}, {:.12e}, {:.12e}, {:.12e}\n", node + 1, fem.points[node].x(), fem.points[node].y(),
                   fem.points[node].z());
    for (std::size_t region = 0; region < mesh.region_names.size(); ++region) {
        fmt::print(out, "** {}\n*ELEMENT, TYPE={}, ELSET=REGION_{}\n", mesh.region_names[region],
                   degree == 1 ? "C3D4" : "C3D10", region);
        for (std::size_t t = 0; t < fem.elements.size(); ++t)
            if (mesh.region[t] == static_cast<int>(region)) {
                fmt::print(out, "{}", t + 1);
                for (const int node : fem.elements[t])
                    fmt::print(out, ", {}", node + 1);
                fmt::print(out, "\n");
            }
        const auto &material = problem.body->materials[region];
        fmt::print(out,
                   "*MATERIAL, NAME=MATERIAL_{0}\n*ELASTIC\n{1:.12e}, {2:.12e}\n*DENSITY\n{3:.12e}\n"
                   "*SOLID SECTION, ELSET=REGION_{0}, MATERIAL=MATERIAL_{0}\n",
                   region, material.young_modulus, material.poisson_ratio, material.density);
    }
    fmt::print(out, "*STEP\n*STATIC\n*BOUNDARY\n");
    const auto prescribed = prescribed_displacement(load_case, fem);
    for (std::size_t node = 0; node < prescribed.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (!std::isnan(prescribed[node][i]))
                fmt::print(out, "{}, {}, {}, {:.12e}\n", node + 1, i + 1, i + 1, prescribed[node][i]);
    fmt::print(out, "*CLOAD\n");
    const auto force = traction_forces(mesh, load_case, fem);
    for (std::size_t node = 0; node < force.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (force[node][i] != 0.0)
                fmt::print(out, "{}, {}, {:.12e}\n", node + 1, i + 1, force[node][i]);
    if (const double size = load_case.acceleration.norm(); size > 0.0) {
        const Vector3 direction = load_case.acceleration / size;
        fmt::print(out, "*DLOAD\n");
        for (std::size_t region = 0; region < mesh.region_names.size(); ++region)
            fmt::print(out, "REGION_{}, GRAV, {:.12e}, {:.12e}, {:.12e}, {:.12e}\n", region, size, direction.x(),
                       direction.y(), direction.z());
    }
    fmt::print(out, "*NODE PRINT, NSET=ALL_NODES\nU\n*END STEP\n");
}

} // namespace livermark::studies
