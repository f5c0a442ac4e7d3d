#include "msm/engine_parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/engine_lines.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::msm {

namespace {

using core::Body;
using core::Material;

std::vector<int> flat(const std::vector<std::array<int, 2>> &rows) {
    std::vector<int> values;
    for (const auto &row : rows)
        values.insert(values.end(), row.begin(), row.end());
    return values;
}

std::vector<int> flat(const std::vector<std::array<int, 4>> &rows) {
    std::vector<int> values;
    for (const auto &row : rows)
        values.insert(values.end(), row.begin(), row.end());
    return values;
}

EngineArray points_of(const std::vector<core::Vector3> &points) {
    std::vector<double> values;
    for (const auto &point : points)
        values.insert(values.end(), point.begin(), point.end());
    return {"points", "m", "positions of the nodes at rest", std::move(values), 3};
}

EngineArray tetrahedra_of(const Body &body) {
    return {"tetrahedra", "", "nodes of each tetrahedron; the last one is on the inner side of the first three",
            flat(body.mesh.tetrahedra), 4};
}

EngineArray node_mass_of(const Body &body) {
    return {"node_mass", "kg", "mass of each node, a quarter of each of its tetrahedra", lumped_masses(body)};
}

/// A number of each tetrahedron.
template <class Value> std::vector<double> in_tetrahedra(const Body &body, Value value) {
    std::vector<double> values;
    for (std::size_t t = 0; t < body.mesh.tetrahedra.size(); ++t)
        values.push_back(value(body.material_of(t)));
    return values;
}

double total_mass(const Body &body) {
    const auto masses = lumped_masses(body);
    return std::accumulate(masses.begin(), masses.end(), 0.0);
}

/// Index of the region of the largest volume.
std::size_t main_region(const Body &body) {
    std::vector<double> volume(body.materials.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[body.mesh.region[t]] += volumes[t];
    return static_cast<std::size_t>(std::ranges::max_element(volume) - volume.begin());
}

/// Sentence on a body of several materials, for an engine that has one.
std::vector<std::string> one_material(const Body &body, const std::string &noun) {
    std::vector<std::string> sentences;
    if (!body.modulus_factor.empty())
        sentences.push_back(fmt::format("{} has one material: the map of stiffness is left out", noun));
    if (body.materials.size() == 1)
        return sentences;
    sentences.push_back(fmt::format(
        "{} has one material: the numbers are those of region {}, and the {} other region{} get them too", noun,
        body.mesh.region_names[main_region(body)], body.materials.size() - 1, body.materials.size() > 2 ? "s" : ""));
    return sentences;
}

EngineSetting substep_setting(std::string name, int substeps, const EngineChoices &choices,
                              const std::string &what = "substeps") {
    return {std::move(name), static_cast<double>(substeps), "",
            fmt::format("{} in a frame of {:.4g} ms", what, 1e3 * choices.frame)};
}

const SpringLaw &law_of(const EngineChoices &choices) {
    return support::find_named(all_spring_laws(), choices.law, "spring law");
}

/// Constraints that come later in a substep h move the nodes of earlier ones again, which softens each by h^2 w / 2 in
/// the mean, with w the sum of |grad C|^2 / m. This part of h^2 w is taken off its compliance, as in
/// examples/engines/jolt.
constexpr double part_of_prediction = 0.5;

/// Soft bodies of Jolt: edges with the energy (l - l0)^2 / (2 a), tetrahedra with (6 V - 6 V0)^2 / (2 a), each
/// satisfied once in a substep. Springs carry lambda = mu, the volumes the rest:
///   edge         a = 1 / k
///   tetrahedron  kappa / 2 (V - V0)^2 / V0 = (6 V - 6 V0)^2 / (2 a),   a = 36 V0 / kappa,   kappa = lambda - mu
EngineParameters jolt(const Body &body, const EngineChoices &choices) {
    const int substeps = choices.substeps.value_or(20);
    const double softer = part_of_prediction * std::pow(choices.frame / substeps, 2);
    const auto &mesh = body.mesh;
    const auto springs = springs_beside_volume(body, law_of(choices));
    std::vector<double> inverse_mass, edge_compliance, six_rest_volume, volume_compliance;
    std::ranges::transform(springs.node_mass, std::back_inserter(inverse_mass), [](double m) { return 1.0 / m; });
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const auto [i, j] = springs.edges[s];
        const double w = inverse_mass[i] + inverse_mass[j];
        edge_compliance.push_back(std::max(0.0, 1.0 / springs.stiffness[s] - softer * w));
    }
    std::vector<std::array<int, 4>> tetrahedra;
    const auto volumes = core::tetrahedron_volumes(mesh);
    bool is_too_compressible = false;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const auto material = body.material_of(t);
        const double modulus = modulus_beside_springs(material);
        constexpr double rounding = 1e-12;
        is_too_compressible = is_too_compressible || modulus < -rounding * material.shear_modulus();
        if (modulus <= rounding * material.shear_modulus())
            continue;
        double w = 0.0; // sum over the corners of |grad 6 V|^2 / m, with grad 6 V twice the area of the other side
        for (std::size_t corner = 0; corner < 4; ++corner) {
            const auto &[a, b, c] = core::tetrahedron_faces[corner];
            const auto &nodes = mesh.tetrahedra[t];
            const core::Vector3 side =
                (mesh.points[nodes[b]] - mesh.points[nodes[a]]).cross(mesh.points[nodes[c]] - mesh.points[nodes[a]]);
            w += side.squaredNorm() * inverse_mass[nodes[corner]];
        }
        tetrahedra.push_back(mesh.tetrahedra[t]);
        six_rest_volume.push_back(6.0 * volumes[t]);
        volume_compliance.push_back(std::max(0.0, 36.0 * volumes[t] / modulus - softer * w));
    }
    EngineParameters parameters;
    parameters.settings = {substep_setting("mNumIterations", substeps, choices),
                           {"mLinearDamping", 0.0, "1/s", "damping of the mass; the default of Jolt is 0.1 1/s"},
                           {"mPressure", 0.0, "J", "pressure of a gas inside, which tissue does not have"}};
    parameters.arrays = {
        points_of(mesh.points),
        {"inverse_mass", "1/kg", "Vertex::mInvMass of each node", std::move(inverse_mass)},
        {"edges", "", "nodes of each Edge", flat(springs.edges), 2},
        {"rest_length", "m", "Edge::mRestLength", springs.rest_length},
        {"edge_compliance", "m/N", "Edge::mCompliance", std::move(edge_compliance)},
        {"volume_tetrahedra", "", "nodes of each Volume", flat(tetrahedra), 4},
        {"six_rest_volume", "m^3", "Volume::mSixRestVolume", std::move(six_rest_volume)},
        {"volume_compliance", "m^5/N", "Volume::mCompliance, for 6 V - 6 V0", std::move(volume_compliance)}};
    parameters.notes = {
        note_on_springs(springs, body, choices.law),
        "Compliances are for this number of substeps: later constraints of a substep soften earlier ones, and what "
        "that makes in the mean is taken off",
        "Set compliances before SoftBodySharedSettings::Optimize(), which changes the order of edges and volumes",
        "mUpdatePosition = false keeps positions in the coordinates of the mesh"};
    if (is_too_compressible)
        parameters.notes.push_back("Poisson's ratio is below 1/4 somewhere: springs alone have 1/4, and volumes can "
                                   "only raise it; they are left out there");
    parameters.cannot = {"Jolt gives no forces: take the gradient of the energies above",
                         "volumes of single tetrahedra lock near Poisson's ratio 1/2, as linear finite elements do"};
    return parameters;
}

/// A text as the value of an attribute in XML.
std::string attribute(const std::string &text) {
    std::string escaped;
    for (const char c : text)
        escaped += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string{c};
    return escaped;
}

template <class Values> std::string words(const Values &values) {
    std::string text;
    for (const auto &value : values)
        text += fmt::format("{}{}", text.empty() ? "" : " ", value);
    return text;
}

constexpr double mujoco_step = 2e-3; // [s], the default of MuJoCo
constexpr double mujoco_force = 1e6; // units of force in a newton, and of mass in a kilogram, of the model

/// Flexes of MuJoCo: linear elements of the Saint Venant-Kirchhoff law. Every point has the same mass.
EngineParameters mujoco(const Body &body, const EngineChoices &choices) {
    const auto &mesh = body.mesh;
    const auto material = mujoco_material(body.materials[main_region(body)]);
    const double mass = total_mass(body);
    const int steps = choices.substeps.value_or(static_cast<int>(std::ceil(choices.frame / mujoco_step - 1e-9)));
    const double time_step = choices.frame / steps;
    EngineParameters parameters;
    parameters.settings = {
        {"mass", mass, "kg", "flexcomp mass, of all points together"},
        {"young", material.young_modulus, "Pa", "elasticity young, for lambda twice"},
        {"poisson", material.poisson_ratio, "", "elasticity poisson, for lambda twice"},
        {"damping", 0.0, "s", "elasticity damping, a part of the stiffness"},
        {"timestep", time_step, "s", "option timestep"},
        substep_setting("steps", steps, choices, "calls of mj_step"),
    };
    const auto points = points_of(mesh.points);
    const auto nodes = flat(mesh.tetrahedra);
    parameters.text = EngineText{
        ".xml",
        fmt::format("<mujoco model=\"{0}\">\n"
                    "  <!-- {1} steps in a frame of {2:.4g} ms; metres, milligrams, micronewtons; no gravity -->\n"
                    "  <option timestep=\"{3}\" integrator=\"discrete\" gravity=\"0 0 0\"/>\n"
                    "  <size memory=\"{9}M\"/>\n"
                    "  <worldbody>\n"
                    "    <flexcomp name=\"tissue\" type=\"direct\" dim=\"3\" mass=\"{4}\" radius=\"0.001\"\n"
                    "      point=\"{5}\"\n"
                    "      element=\"{6}\">\n"
                    "      <elasticity young=\"{7}\" poisson=\"{8}\" damping=\"0\"/>\n"
                    "      <contact internal=\"false\" selfcollide=\"none\" contype=\"0\" conaffinity=\"0\"/>\n"
                    "      <!-- nodes that do not move: <pin id=\"0 1 2\"/> -->\n"
                    "    </flexcomp>\n"
                    "  </worldbody>\n"
                    "</mujoco>\n",
                    attribute(body.name), steps, 1e3 * choices.frame, time_step, mujoco_force * mass,
                    words(std::get<std::vector<double>>(points.values)), words(nodes),
                    mujoco_force * material.young_modulus, material.poisson_ratio,
                    20 + mesh.points.size() / 50)}; // by itself MuJoCo asks for gigabytes
    parameters.arrays = {points, tetrahedra_of(body)};
    parameters.notes = {
        "The force of a flex has Lame's lambda twice in MuJoCo 3.3.7 to 3.14.0; young and poisson make up for it, and "
        "with E and nu typed in as they are tissue of 0.45 is one of 0.474",
        "The .xml is in milligrams and micronewtons, because MuJoCo ends its iterations at absolute forces; divide its "
        "forces by 1e6",
        "The integrator discrete is implicit, and is of MuJoCo 3.13 on; before, leave it out and take --substeps for "
        "steps of 0.2 ms",
        "Forces on nodes are in xfrc_applied of the body of each point; nodes of a tool are points of <pin> on a mocap "
        "body"};
    parameters.cannot = one_material(body, "A flex");
    parameters.cannot.push_back("every point has the same mass, whatever its tetrahedra weigh");
    parameters.cannot.push_back("linear tetrahedra lock near Poisson's ratio 1/2");
    return parameters;
}

/// Deformable bodies of Bullet: linear tetrahedra, co-rotational ones with Lame's parameters as they are.
EngineParameters bullet(const Body &body, const EngineChoices &choices) {
    const auto &material = body.materials[main_region(body)];
    const auto neo_hookean = stable_neo_hookean(material);
    const int substeps = choices.substeps.value_or(1);
    EngineParameters parameters;
    parameters.settings = {
        {"mu", material.shear_modulus(), "Pa", "btDeformableLinearElasticityForce, first argument"},
        {"lambda", material.lame_lambda(), "Pa", "btDeformableLinearElasticityForce, second argument"},
        {"damping_alpha", 0.0, "1/s", "third argument: damping of the mass; the default of Bullet is 0.01 1/s"},
        {"damping_beta", 0.0, "s", "fourth argument: damping of the stiffness; the default of Bullet is 0.01 s"},
        {"neo_hookean_mu", neo_hookean.mu, "Pa", "btDeformableNeoHookeanForce in its place: 4/3 mu"},
        {"neo_hookean_lambda", neo_hookean.lambda, "Pa", "the same: lambda + 5/6 mu"},
        {"fixedTimeStep", choices.frame / substeps, "s", "third argument of stepSimulation"},
        substep_setting("maxSubSteps", substeps, choices, "second argument of stepSimulation: implicit steps"),
    };
    parameters.arrays = {points_of(body.mesh.points), tetrahedra_of(body), node_mass_of(body)};
    parameters.notes = {
        "setImplicit(true) has no effect without setUseProjection(true)",
        "setMass(i, node_mass[i]) for each node, after the tetrahedra are there",
        "setLineSearch(true) compares energies that do not belong to the co-rotational forces; leave it"};
    parameters.cannot = one_material(body, "A world with a law of each kind");
    parameters.cannot.push_back("linear tetrahedra lock near Poisson's ratio 1/2");
    return parameters;
}

/// SOFA: linear tetrahedra with E and nu as they are, or springs with a stiffness each.
EngineParameters sofa(const Body &body, const EngineChoices &choices) {
    const int substeps = choices.substeps.value_or(1);
    const auto springs = spring_network(body, law_of(choices));
    EngineParameters parameters;
    parameters.settings = {
        {"dt", choices.frame / substeps, "s", "of the root node"},
        substep_setting("steps", substeps, choices, "steps"),
        {"rayleighStiffness", 0.0, "s", "of EulerImplicitSolver and of the force field"},
        {"rayleighMass", 0.0, "1/s", "of EulerImplicitSolver"},
        {"threshold", 1e-30, "kg m^2/s^2", "of CGLinearSolver; the default ends iterations of such a body at once"},
    };
    parameters.arrays = {
        points_of(body.mesh.points),
        tetrahedra_of(body),
        {"node_mass", "kg", "vertexMass of DiagonalMass", lumped_masses(body)},
        {"youngModulus", "Pa", "TetrahedronFEMForceField, of each tetrahedron, the tissue's own",
         in_tetrahedra(body, [](const Material &m) { return m.young_modulus; })},
        {"poissonRatio", "", "TetrahedronFEMForceField, of each tetrahedron, the tissue's own",
         in_tetrahedra(body, [](const Material &m) { return m.poisson_ratio; })},
        {"edges", "", "ends of each spring of SpringForceField, in place of the tetrahedra", flat(springs.edges), 2},
        {"stiffness", "N/m", "ks of each spring; kd is 0", springs.stiffness},
        {"rest_length", "m", "length of each spring", springs.rest_length},
    };
    std::ranges::move(springs_beside(body), std::back_inserter(parameters.arrays));
    parameters.notes = {
        "TetrahedronFEMForceField with method='large' is co-rotational; 'small' is wrong where the body turns",
        "Springs are rows (i, j, ks, kd, length) of SpringForceField; MeshSpringForceField has one linesStiffness for "
        "all",
        note_on_springs(springs, body, choices.law)};
    parameters.cannot = {"springs alone have Poisson's ratio 1/4, whatever the tissue has; SOFA has no volume "
                         "constraint for tetrahedra beside them",
                         "linear tetrahedra lock near Poisson's ratio 1/2"};
    return parameters;
}

/// Nodes of the surface, numbered by themselves.
struct Surface {
    std::vector<int> node;                     ///< (K) of the body
    std::vector<std::array<int, 3>> triangles; ///< (F) clockwise from outside, numbers of the surface
    std::vector<std::array<int, 2>> edges;     ///< (B) numbers of the body, the lower one first
};

Surface surface_of(const Body &body) {
    Surface surface;
    std::map<int, int> number;
    std::set<std::array<int, 2>> edges;
    for (const auto &face : core::outer_faces(body.mesh.tetrahedra)) {
        std::array<int, 3> corners{};
        for (std::size_t c = 0; c < 3; ++c) {
            const auto [at, is_new] = number.emplace(face[c], static_cast<int>(number.size()));
            if (is_new)
                surface.node.push_back(face[c]);
            corners[2 - c] = at->second;
            const auto [lower, higher] = std::minmax({face[c], face[(c + 1) % 3]});
            edges.insert({lower, higher});
        }
        surface.triangles.push_back(corners);
    }
    surface.edges.assign(edges.begin(), edges.end());
    return surface;
}

/// SoftBody3D of Godot: the edges of a surface, all with one stiffness, which a coefficient from 0 to 1 stands for.
EngineParameters godot(const Body &body, const EngineChoices &choices) {
    const int substeps = choices.substeps.value_or(5);
    const auto surface = surface_of(body);
    const auto springs = spring_network(body, law_of(choices));
    std::vector<double> stiffness;
    for (const auto &edge : surface.edges) // both are in lexicographic order
        stiffness.push_back(springs.stiffness[static_cast<std::size_t>(std::ranges::lower_bound(springs.edges, edge) -
                                                                       springs.edges.begin())]);
    const double mean =
        std::accumulate(stiffness.begin(), stiffness.end(), 0.0) / static_cast<double>(stiffness.size());
    const double mass = total_mass(body), point_mass = mass / static_cast<double>(surface.node.size());
    std::vector<core::Vector3> points;
    for (const int node : surface.node)
        points.push_back(body.mesh.points[node]);
    std::vector<int> corners;
    for (const auto &triangle : surface.triangles)
        corners.insert(corners.end(), triangle.begin(), triangle.end());
    EngineParameters parameters;
    parameters.settings = {
        {"linear_stiffness", godot_linear_stiffness(mean, point_mass, choices.frame / substeps), "",
         "Godot 4.7 and newer with Jolt, for this mass and precision"},
        {"linear_stiffness_before_4_7", godot_linear_stiffness_by_cube(mean, 1e5), "",
         "the same in Godot 4.4 to 4.6 with Jolt: (k / 1e5 N/m)^(1/3)"},
        {"linear_stiffness_extension", godot_linear_stiffness_by_cube(mean, 1e6), "",
         "the same in the extension Godot Jolt: (k / 1e6 N/m)^(1/3)"},
        {"edge_stiffness", mean, "N/m", "k of these: the mean of the springs along the edges of the surface"},
        {"total_mass", mass, "kg", "of the whole body, which the points of the surface share alike"},
        substep_setting("simulation_precision", substeps, choices),
        {"pressure_coefficient", 0.0, "J", "a gas inside, which would blow the body up"},
        {"damping_coefficient", 0.0, "1/s", "damping of the mass"},
    };
    parameters.arrays = {
        points_of(points),
        {"triangles", "", "points of each triangle of the mesh, clockwise from outside, as Godot has them",
         std::move(corners), 3},
        {"surface_node", "", "node of the body at each point", surface.node},
        {"surface_edges", "", "nodes of the body at the ends of each edge of the surface", flat(surface.edges), 2},
        {"surface_stiffness", "N/m", "springs along these edges, of which Godot takes the mean", std::move(stiffness)},
    };
    parameters.notes = {
        "The body is hollow, so no number makes it tissue: the coefficient gives edges of the surface the stiffness "
        "that they have in the whole mesh",
        "Godot Physics, the engine before Jolt, moves the ends of an edge by a part of its elongation in each "
        "iteration and keeps no multipliers: its stiffness is that of its iterations, so no coefficient is given for "
        "it"};
    parameters.cannot = {"SoftBody3D has no inside and no volume, only the pressure of a gas: no Poisson's ratio",
                         "all edges have one stiffness: no tumours, and long edges as stiff as short ones"};
    return parameters;
}

/// Soft meshes of Newton: k_mu and k_lambda of each tetrahedron, which each solver reads in its own way.
///
/// SolverXPBD satisfies C1 = tr(F^T F) - 3 and C2 = det F - 1 with the compliances 1 / (V k_mu) and 1 / (V k_lambda),
/// so its energy is V / 2 (k_mu C1^2 + k_lambda C2^2). For small strains e both are traces, C1 = 2 tr e and C2 = tr e:
/// the energy is V / 2 (4 k_mu + k_lambda) (tr e)^2, which resists no shear, whatever k_mu is.
EngineParameters newton(const Body &body, const EngineChoices &choices) {
    const int substeps = choices.substeps.value_or(10);
    const auto mu = [](const Material &m) { return m.shear_modulus(); };
    const auto lambda = [](const Material &m) { return m.lame_lambda(); };
    EngineParameters parameters;
    parameters.settings = {
        substep_setting("substeps", substeps, choices, "calls of solver.step"),
        {"dt", choices.frame / substeps, "s", "of a call"},
        {"k_damp", 0.0, "Pa s", "of add_soft_mesh"},
        {"density",
         total_mass(body) /
             [&] {
                 const auto volumes = core::tetrahedron_volumes(body.mesh);
                 return std::accumulate(volumes.begin(), volumes.end(), 0.0);
             }(),
         "kg/m^3", "of add_soft_mesh: mass over volume of the whole body"},
    };
    parameters.arrays = {
        points_of(body.mesh.points),
        tetrahedra_of(body),
        {"k_mu", "Pa", "SolverVBD, of each tetrahedron: mu", in_tetrahedra(body, mu)},
        {"k_lambda", "Pa", "SolverVBD, of each tetrahedron: lambda", in_tetrahedra(body, lambda)},
        {"k_mu_semi_implicit", "Pa", "SolverSemiImplicit, of each tetrahedron: 4/3 mu",
         in_tetrahedra(body, [](const Material &m) { return stable_neo_hookean(m).mu; })},
        {"k_lambda_semi_implicit", "Pa", "SolverSemiImplicit, of each tetrahedron: lambda + 5/6 mu",
         in_tetrahedra(body, [](const Material &m) { return stable_neo_hookean(m).lambda; })},
    };
    parameters.notes = {
        "SolverVBD stops early: raise its iterations until the answer stays, because fewer make the body softer or "
        "leave it behind its tool",
        "SolverXPBD keeps no multipliers from one iteration to the next (newton#2933): with iterations=1 and "
        "soft_body_relaxation=1 compliances are those of the material in each substep, and every further iteration "
        "makes the body stiffer"};
    parameters.cannot = {
        "SolverXPBD cannot be tissue: both of its constraints are changes of volume at small strains, so it resists no "
        "shear, whatever k_mu is",
        "linear tetrahedra lock near Poisson's ratio 1/2"};
    return parameters;
}

} // namespace

std::size_t EngineArray::rows() const {
    return std::visit([&](const auto &all) { return all.size() / columns; }, values);
}

std::span<const Engine> all_engines() {
    static const std::vector<Engine> engines{
        {"bullet", "linear tetrahedra, co-rotational or neo-Hookean, in implicit steps", "Bullet 3.24", bullet},
        {"godot", "edges of a surface with one coefficient of stiffness", "Godot 4.4 to 4.7, Godot Jolt", godot, true},
        {"jolt", "edges and tetrahedra with compliances, in substeps", "Jolt 5, June 2026", jolt, true},
        {"mujoco", "linear tetrahedra of the Saint Venant-Kirchhoff law, with lambda twice", "MuJoCo 3.3.7 to 3.14.0",
         mujoco},
        {"newton", "linear tetrahedra, of which each solver has its own law", "Newton, August 2026", newton},
        {"sofa", "linear tetrahedra, co-rotational, or springs, in implicit steps", "SOFA 25.12", sofa, true, true},
    };
    return engines;
}

EngineParameters engine_parameters(const core::Body &body, const std::string &engine, const EngineChoices &choices) {
    const auto &found = support::find_named(all_engines(), engine, "engine");
    law_of(choices);
    constexpr int most_substeps = 100000;
    if (choices.substeps && (*choices.substeps < 1 || *choices.substeps > most_substeps))
        throw support::InputError("{} substeps in a frame; give a number from 1 to {}", *choices.substeps,
                                  most_substeps);
    if (!(choices.frame > 0.0 && std::isfinite(choices.frame)))
        throw support::InputError("a frame of {} s; give a positive number of seconds, such as 0.01667", choices.frame);
    auto parameters = found.parameters(body, choices);
    parameters.engine = found.name;
    std::ranges::move(left_out_beside(body, found), std::back_inserter(parameters.cannot));
    return parameters;
}

double mean_shear_modulus_ratio(const std::vector<double> &stiffness, const std::vector<double> &length,
                                const core::Body &body) {
    double springs_sum = 0.0, body_sum = 0.0;
    for (std::size_t s = 0; s < stiffness.size(); ++s)
        springs_sum += stiffness[s] * length[s] * length[s];
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        body_sum += 15.0 * body.shear_modulus_of(t) * volumes[t];
    return springs_sum / body_sum;
}

double godot_linear_stiffness(double stiffness, double point_mass, double step) {
    const double x = 2.0 * stiffness * step * step / point_mass;
    return x / (1.0 + x);
}

double godot_linear_stiffness_by_cube(double stiffness, double largest) {
    return std::min(1.0, std::cbrt(stiffness / largest));
}

core::Material mujoco_material(const core::Material &material) {
    auto typed = material;
    const double nu = material.poisson_ratio;
    typed.poisson_ratio = nu / (2.0 - 2.0 * nu);
    typed.young_modulus = material.young_modulus * (1.0 + typed.poisson_ratio) / (1.0 + nu);
    return typed;
}

LameParameters stable_neo_hookean(const core::Material &material) {
    const double mu = material.shear_modulus();
    return {.mu = 4.0 / 3.0 * mu, .lambda = material.lame_lambda() + 5.0 / 6.0 * mu};
}

} // namespace livermark::msm
