#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/ostream.h>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include "studies/exchange/formats/export_format.hpp"
#include "studies/exchange/formats/ground_springs.hpp"

namespace livermark::exchange {

using core::Vector3;

namespace {

/// The corners of each face of a tetrahedron, P1 to P4.
constexpr std::array<std::array<int, 3>, 4> face_corners{{{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};

void write_elastic(std::ostream &out, const core::Material &material) {
    fmt::print(out, "*ELASTIC\n{:.12e}, {:.12e}\n", material.young_modulus, material.poisson_ratio);
}

/// W = C10 (J^(-2/3) I1 - 3) + (J - 1)^2 / D1
void write_neo_hooke(std::ostream &out, const core::Material &material) {
    const double bulk_modulus = material.lame_lambda() + 2.0 / 3.0 * material.shear_modulus();
    fmt::print(out, "*HYPERELASTIC, NEO HOOKE\n{:.12e}, {:.12e}\n", 0.5 * material.shear_modulus(), 2.0 / bulk_modulus);
}

std::array<int, 3> sorted(std::array<int, 3> nodes) {
    std::ranges::sort(nodes);
    return nodes;
}

/// The patches as surfaces of faces S1 to S4, numbered as P1 to P4.
void write_patches(std::ostream &out, const core::TetraMesh &mesh) {
    std::map<std::array<int, 3>, int> patch;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        patch[sorted(mesh.boundary_triangles[f])] = mesh.boundary_patch[f];
    std::vector<std::string> faces_of(mesh.patch_names.size());
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t face = 0; face < face_corners.size(); ++face) {
            const auto &[a, b, c] = face_corners[face];
            const auto &nodes = mesh.tetrahedra[t];
            if (const auto found = patch.find(sorted({nodes[a], nodes[b], nodes[c]})); found != patch.end())
                faces_of[found->second] += fmt::format("{}, S{}\n", t + 1, face + 1);
        }
    for (std::size_t p = 0; p < faces_of.size(); ++p)
        fmt::print(out, "** {}\n*SURFACE, NAME=PATCH_{}, TYPE=ELEMENT\n{}", mesh.patch_names[p], p, faces_of[p]);
}

/// Pressures on faces follow them where *STEP says NLGEOM.
void write_follower_pressures(std::ostream &out, const core::TetraMesh &mesh, const core::LoadCase &load_case) {
    std::map<std::array<int, 3>, double> pressure;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (load_case.follows_surface(f))
            pressure[sorted(mesh.boundary_triangles[f])] = core::follower_pressure(load_case, mesh, f);
    if (pressure.empty())
        return;
    fmt::print(out, "*DLOAD\n");
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        for (std::size_t face = 0; face < face_corners.size(); ++face) {
            const auto &[a, b, c] = face_corners[face];
            const auto &nodes = mesh.tetrahedra[t];
            if (const auto found = pressure.find(sorted({nodes[a], nodes[b], nodes[c]})); found != pressure.end())
                fmt::print(out, "{}, P{}, {:.12e}\n", t + 1, face + 1, found->second);
        }
}

/// Sum of terms that is zero. The first of them is taken out of the system, so nothing may constrain it.
class Equation {
  public:
    /// @param node       counted from 1
    /// @param component  of its displacement, counted from 1
    void add(std::size_t node, int component, double factor) { terms_.push_back({node, component, factor}); }
    void put_largest_first() {
        std::iter_swap(terms_.begin(),
                       std::ranges::max_element(terms_, {}, [](const Term &t) { return std::abs(t.factor); }));
    }
    void write(std::ostream &out) const {
        fmt::print(out, "*EQUATION\n{}", terms_.size());
        constexpr std::size_t terms_per_line = 4;
        for (std::size_t k = 0; k < terms_.size(); ++k)
            fmt::print(out, "{}{}, {}, {:.12e}", k % terms_per_line == 0 ? "\n" : ", ", terms_[k].node,
                       terms_[k].component, terms_[k].factor);
        fmt::print(out, "\n");
    }

  private:
    struct Term {
        std::size_t node;
        int component;
        double factor;
    };
    std::vector<Term> terms_;
};

/// The equation of a place that presses: its depth is the displacement of a node that is in no element.
void write_press_equation(std::ostream &out, const std::vector<Vector3> &unit_force,
                          const std::vector<Vector3> &prescribed) {
    Equation equation;
    for (std::size_t node = 0; node < unit_force.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (unit_force[node][i] != 0.0 && std::isnan(prescribed[node][i]))
                equation.add(node + 1, i + 1, unit_force[node][i]);
    equation.put_largest_first();
    equation.add(unit_force.size() + 1, 1, -1.0);
    equation.write(out);
}

/// SPRINGA from a node at the origin to those of the springs, which no element has: behind the node of the depth, and
/// behind the facets.
void write_ground_springs(std::ostream &out, const std::vector<GroundSpring> &springs, const Discretisation &fem) {
    const auto ground = fem.points.size() + 2, first_element = fem.elements.size() + fem.facets.size() + 1;
    const auto node_of = [&](std::size_t spring) { return ground + 1 + spring; };
    fmt::print(out, "** vessels and foundation\n*NODE\n{}, 0, 0, 0\n", ground);
    for (std::size_t s = 0; s < springs.size(); ++s)
        fmt::print(out, "{}, {:.12e}, {:.12e}, {:.12e}\n", node_of(s), springs[s].rest.x(), springs[s].rest.y(),
                   springs[s].rest.z());
    fmt::print(out, "*ELEMENT, TYPE=SPRINGA, ELSET=GROUND_SPRINGS\n");
    for (std::size_t s = 0; s < springs.size(); ++s)
        fmt::print(out, "{}, {}, {}\n", first_element + s, ground, node_of(s));
    fmt::print(out, "*SPRING, ELSET=GROUND_SPRINGS\n\n1.0\n");
    for (std::size_t s = 0; s < springs.size(); ++s)
        for (int i = 0; i < 3; ++i) {
            const auto &terms = springs[s].displacement[i];
            if (terms.empty())
                continue;
            Equation equation;
            equation.add(node_of(s), i + 1, -1.0);
            for (const auto &term : terms)
                equation.add(term.node + 1, term.component + 1, term.factor);
            equation.write(out);
        }
    fmt::print(out, "*BOUNDARY\n{}, 1, 3\n", ground);
    for (std::size_t s = 0; s < springs.size(); ++s)
        for (int i = 0; i < 3; ++i)
            if (springs[s].displacement[i].empty())
                fmt::print(out, "{}, {}\n", node_of(s), i + 1);
}

void write_loads(std::ostream &out, const std::vector<Vector3> &force) {
    fmt::print(out, "*CLOAD\n");
    for (std::size_t node = 0; node < force.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (force[node][i] != 0.0)
                fmt::print(out, "{}, {}, {:.12e}\n", node + 1, i + 1, force[node][i]);
}

/// The capsule as M3D3 on the facets, behind the tetrahedra. CalculiX makes layers of solid elements of them, which
/// bend little and need a Poisson's ratio below 1/2. Its quadratic M3D6 resist little, and under large loads it comes
/// to no rest.
void write_capsule(std::ostream &out, const core::Body &body, const Discretisation &fem) {
    constexpr double poisson_ratio = 0.4999;
    const core::Material material{
        .density = 1.0, .young_modulus = body.capsule->young_modulus, .poisson_ratio = poisson_ratio};
    fmt::print(out, "** capsule\n*ELEMENT, TYPE=M3D3, ELSET=CAPSULE\n");
    for (std::size_t f = 0; f < fem.facets.size(); ++f)
        if (core::Capsule::covers(body.mesh, static_cast<int>(f))) {
            fmt::print(out, "{}", fem.elements.size() + f + 1);
            for (const int node : fem.facets[f])
                fmt::print(out, ", {}", node + 1);
            fmt::print(out, "\n");
        }
    fmt::print(out, "*MATERIAL, NAME=CAPSULE\n");
    write_elastic(out, material);
    fmt::print(out, "*MEMBRANE SECTION, ELSET=CAPSULE, MATERIAL=CAPSULE\n{:.12e}\n", body.capsule->thickness);
}

/// Input of CalculiX and Abaqus for a problem at rest: C3D4 or C3D10 with straight edges, a *MATERIAL and an ELSET
/// for each region, *BOUNDARY for what is prescribed, *CLOAD with the consistent nodal forces of the tractions (a
/// facet's force goes in equal parts to its corners, or to its edge midpoints), *DLOAD GRAV for the acceleration. Node
/// i of the mesh is node i + 1, tetrahedron t is element t + 1, the middle of edge e of core::edge_table is node N + e
/// + 1; lengths are metres, forces newtons. Every displacement goes to the .dat file.
///
/// A load case of the large regime is geometrically nonlinear (NLGEOM) and *HYPERELASTIC, NEO HOOKE with the same Lame
/// parameters, an energy that is not quite that of the suite,
///     W = mu / 2 (J^(-2/3) I1 - 3) + kappa / 2 (J - 1)^2,   kappa = lambda + 2 mu / 3.
/// Pressures that follow the surface are *DLOAD on faces. Vessels as lines and foundations are springs to nodes that no
/// element has, whose displacements are *EQUATION of those of elements.
/// CalculiX reads the first twenty characters of a number, so thirteen digits have to do.
void write_inp(std::ostream &out, const core::Problem &problem, const ExportChoices &choices) {
    const int degree = choices.quadratic ? 2 : 1;
    const auto &mesh = problem.body->mesh;
    const auto &load_case = problem.load_case;
    const bool is_large = load_case.regime == core::Regime::large;
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
        fmt::print(out, "*MATERIAL, NAME=MATERIAL_{}\n", region);
        (is_large ? write_neo_hooke : write_elastic)(out, material);
        fmt::print(out, "*DENSITY\n{1:.12e}\n*SOLID SECTION, ELSET=REGION_{0}, MATERIAL=MATERIAL_{0}\n", region,
                   material.density);
    }
    if (problem.body->capsule)
        write_capsule(out, *problem.body, fem);
    if (const auto springs = ground_springs(problem, fem); !springs.empty())
        write_ground_springs(out, springs, fem);
    write_patches(out, mesh);
    const auto prescribed = prescribed_displacement(load_case, fem);
    const auto force = traction_forces(mesh, is_large ? core::without_follower_pressures(load_case) : load_case, fem);
    const bool presses = load_case.press_depth != 0.0;
    if (presses) {
        fmt::print(out, "*NODE, NSET=DEPTH\n{}, 0, 0, 0\n", fem.points.size() + 1);
        write_press_equation(out, force, prescribed);
    }
    // Increments grow to the whole load, and Newton's method goes on until its corrections are a ten thousandth of one.
    fmt::print(out, "{}",
               is_large ? "*STEP, NLGEOM, INC=1000\n*STATIC\n0.35, 1.0\n"
                          "*CONTROLS, PARAMETERS=FIELD\n1e-5, 1e-4\n"
                        : "*STEP\n*STATIC\n");
    fmt::print(out, "*BOUNDARY\n");
    for (std::size_t node = 0; node < prescribed.size(); ++node)
        for (int i = 0; i < 3; ++i)
            if (!std::isnan(prescribed[node][i]))
                fmt::print(out, "{}, {}, {}, {:.12e}\n", node + 1, i + 1, i + 1, prescribed[node][i]);
    if (presses)
        fmt::print(out, "{}, 1, 1, {:.12e}\n", fem.points.size() + 1, load_case.press_depth);
    else
        write_loads(out, force);
    if (is_large)
        write_follower_pressures(out, mesh, load_case);
    if (const double size = load_case.acceleration.norm(); size > 0.0) {
        const Vector3 direction = load_case.acceleration / size;
        fmt::print(out, "*DLOAD\n");
        for (std::size_t region = 0; region < mesh.region_names.size(); ++region)
            fmt::print(out, "REGION_{}, GRAV, {:.12e}, {:.12e}, {:.12e}, {:.12e}\n", region, size, direction.x(),
                       direction.y(), direction.z());
    }
    fmt::print(out, "*NODE PRINT, NSET=ALL_NODES{}\nU\n*END STEP\n", is_large ? ", FREQUENCY=1000" : "");
}

} // namespace

namespace formats {

namespace {

bool calculix_has(FurtherKind part, const JobKind &job) {
    switch (part) {
    case FurtherKind::capsule:
        return job == JobKind{core::Regime::small, false};
    case FurtherKind::vessels:
        return !job.quadratic;
    default:
        return part == FurtherKind::foundation;
    }
}

} // namespace

ExportFormat calculix() {
    return {
        .name = {}, .summary = "a job of CalculiX or Abaqus", .files = {{".inp", write_inp}}, .job_has = calculix_has};
}

} // namespace formats

} // namespace livermark::exchange
