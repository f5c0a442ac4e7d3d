#include "app/live/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <limits>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"

namespace livermark::live {

namespace {

using Terms = std::vector<std::shared_ptr<const msm::ElasticTerm>>;

constexpr double reference_young_modulus = 1000.0; // [Pa]
constexpr double largest_poisson_ratio_of_guard = 0.45;

/// Nobody presses a tumour to half its volume when it lies in something softer, and a guard as stiff as it is would ask
/// for shorter steps. Springs alone get a guard as well: they would stay inside out. It does nothing before a
/// tetrahedron has lost half its volume.
std::shared_ptr<const msm::ElasticTerm> guard(const core::Body &body) {
    return msm::inversion_guard(with_material_of_guard(body));
}

/// Body with the Young's modulus that laws are asked with; springs are in proportion to it. Those of a capsule are not.
core::Body reference_of(const core::Body &own) {
    auto body = with_material(own, reference_young_modulus, 0.25);
    body.capsule.reset();
    return body;
}

/// Factor by which springs of a law are stiffer than those of the reference.
double factor_of_springs(const core::Body &body, const Settings &settings) {
    const auto &material = body.materials[largest_region(body.mesh)];
    const double carried = settings.keeps_volume ? 2.5 * material.shear_modulus() : material.young_modulus;
    return carried / reference_young_modulus;
}

msm::MassSprings springs_of_law(const core::Body &own, const core::Body &body, const Settings &settings,
                                SpringsOfLaws &kept) {
    auto known = kept.find(settings.springs);
    if (known == kept.end()) {
        const auto &law = support::find_named(msm::all_spring_laws(), settings.springs, "spring law");
        known = kept.emplace(settings.springs, msm::spring_network(reference_of(own), law)).first;
    }
    auto springs = known->second;
    const double factor = factor_of_springs(body, settings);
    for (double &k : springs.stiffness)
        k *= factor;
    if (body.capsule)
        std::ranges::transform(springs.stiffness, core::capsule_springs(body, core::edge_table(body.mesh.tetrahedra)),
                               springs.stiffness.begin(), std::plus());
    Terms terms{msm::spring_term(springs), guard(body)};
    // At Poisson's ratio 1/4 springs alone are the material.
    if (settings.keeps_volume && settings.poisson_ratio != 0.25)
        terms.push_back(msm::volume_beside_springs(body, msm::find_volume_term("nodal_volume")));
    auto elastic = msm::with_vessel_lines({springs.node_mass, std::move(terms)}, body);
    return {std::move(springs), std::move(elastic)};
}

/// Springs that are coupled around nodes or edges; those with an energy get the guard as well, because a hand that
/// presses hard takes explicit steps past the state in which a tetrahedron is flat.
msm::MassSprings coupled_springs_of(const core::Body &body, const Settings &settings) {
    const auto material = settings.keeps_volume
                              ? body
                              : with_material(body, body.materials[largest_region(body.mesh)].young_modulus, 0.25);
    const auto &coupled = msm::find_coupled_springs(settings.springs);
    Terms terms{msm::coupled_springs(material, coupled)};
    if (auto volume = msm::volume_beside_coupled_springs(material, coupled))
        terms.push_back(std::move(volume));
    if (auto capsule = msm::coupled_capsule(material))
        terms.push_back(std::move(capsule));
    terms.push_back(guard(material));
    core::SpringNetwork springs{.node_mass = msm::lumped_masses(material),
                                .edges = core::edge_table(body.mesh.tetrahedra).edges,
                                .stiffness = {},
                                .rest_length = {}};
    auto elastic = msm::with_vessel_lines({springs.node_mass, std::move(terms)}, material);
    elastic.softness = msm::softness_below_tools(coupled);
    return {std::move(springs), std::move(elastic)};
}

bool is_law(const std::string &springs) {
    const auto laws = msm::all_spring_laws();
    return std::ranges::any_of(laws, [&](const auto &law) { return law.name == springs; });
}

} // namespace

bool keep_from_inverting(const std::string &springs) {
    const auto coupled = msm::all_coupled_springs();
    const auto found = std::ranges::find(coupled, springs, &msm::CoupledSprings::name);
    return found != coupled.end() && !found->energy.is_finite;
}

const std::vector<std::string> &spring_names() {
    static const auto names = [] {
        std::vector<std::string> found;
        for (const auto &law : msm::all_spring_laws())
            found.push_back(law.name);
        for (const auto &springs : msm::all_coupled_springs())
            if (msm::are_in_kernels(springs))
                found.push_back(springs.name);
        return found;
    }();
    return names;
}

core::Body with_material_of_guard(core::Body body) {
    auto material = body.materials[largest_region(body.mesh)];
    material.poisson_ratio = std::min(material.poisson_ratio, largest_poisson_ratio_of_guard);
    body.materials.assign(body.materials.size(), material);
    body.modulus_factor.clear();
    return body;
}

msm::MassSprings mass_springs(const core::Body &own, const Settings &settings, SpringsOfLaws &kept) {
    const auto body = with_material(own, settings.young_modulus, settings.poisson_ratio);
    return is_law(settings.springs) ? springs_of_law(own, body, settings, kept) : coupled_springs_of(body, settings);
}

std::optional<msm::SpringSource> spring_source(const core::Body &own, const Settings &settings) {
    if (!is_law(settings.springs))
        return std::nullopt;
    const auto body = with_material(own, settings.young_modulus, settings.poisson_ratio);
    return msm::SpringSource{support::find_named(msm::all_spring_laws(), settings.springs, "spring law"),
                             reference_of(own), factor_of_springs(body, settings)};
}

int largest_region(const core::TetraMesh &mesh) {
    std::vector<double> volume(mesh.region_names.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[mesh.region[t]] += volumes[t];
    return static_cast<int>(std::ranges::max_element(volume) - volume.begin());
}

core::Body with_material(core::Body body, double young_modulus, double poisson_ratio) {
    const double factor = young_modulus / body.materials[largest_region(body.mesh)].young_modulus;
    for (auto &material : body.materials) {
        material.young_modulus *= factor;
        material.poisson_ratio = poisson_ratio;
    }
    return body;
}

namespace {

/// Part of the critical time step of a pressed body. What is pressed in one direction bulges in others, where its
/// triangles get larger and its springs longer; with 0.8 one poke in two hundred was lost.
constexpr double pressed_part = 0.5;
/// The same of springs whose energy keeps tetrahedra from turning inside out. Of 900 pokes and pulls on the healthy
/// liver as many motions were lost as with 0.5, one; with 0.7 three in 300.
constexpr double pressed_part_of_energies = 0.6;
/// Number of parts into which a step is divided at most. It also keeps the steps of a body of one material at 0.4 of
/// the critical one, because what bulges does so before it is pressed: with 0.8 the healthy liver did not come to rest.
constexpr int most_parts = 3;
constexpr int most_parts_of_energies = 2;
/// Part of the critical step at rest, where only the guard keeps tetrahedra from turning inside out: with 0.8 the liver
/// with tumours did not come to rest after 100 pokes at Poisson's ratio 0.49.
constexpr double guarded_part = 0.5;
/// Part of its volume at rest, below which a tetrahedron is watched: the guard begins at a half.
constexpr double watched_part = 0.7;
/// Factor by which steps have to get longer by scaled masses: a step with them takes up to a fifth more time.
constexpr double least_gain = 1.25;
/// Accuracy of squared frequencies: steps are far from the critical ones, and nobody likes to wait for settings.
constexpr double step_accuracy = 1e-5;
/// The last digits of a longest step are not those that another machine found.
constexpr double rounding = 1.0 + 1e-6;
/// However soft a body is, the mass between it and the hand has to be moved in steps that it bears [s].
constexpr double longest_of_hand = 0.004;
/// Lowest frequency that the damping is looked at, as a part of the highest.
constexpr double lowest_part = 1e-3;

/// Written so that what is no number is outside.
void check_range(const char *what, double value, double least, double most, const char *unit) {
    if (!(value >= least && value <= most))
        throw support::InputError(fmt::format("{} of {}{}: take one from {} to {}", what, value, unit, least, most));
}

const msm::Integrator &symplectic_euler() {
    return msm::find_integrator("symplectic_euler");
}

/// Steps that a body bears with these masses.
Chosen longest_steps(const core::Body &body, const msm::MassSprings &parts, const msm::NodalConditions &conditions,
                     const msm::MassScaling &scaling, const Settings &settings) {
    const auto &points = body.mesh.points;
    const double highest = msm::largest_angular_frequency(parts.body, points, conditions, scaling, step_accuracy);
    if (!(highest > 0.0))
        throw support::InputError("no part of the body can move; constrain less of it");
    Chosen chosen{.num_springs = static_cast<int>(parts.springs.edges.size())};
    chosen.critical_time_step = critical_step(highest, settings);
    auto pressed = parts.body;
    pressed.terms.push_back(msm::pressed_guard(with_material_of_guard(body)));
    const double highest_pressed = msm::largest_angular_frequency(pressed, points, conditions, scaling, step_accuracy);
    const bool has_energy = keep_from_inverting(settings.springs);
    chosen.pressed_time_step =
        (has_energy ? pressed_part_of_energies : pressed_part) * critical_step(highest_pressed, settings);
    const double part = has_energy ? msm::default_safety_factor : guarded_part;
    const int parts_at_most = has_energy ? most_parts_of_energies : most_parts;
    for (const auto &[limit, longest] : {std::pair(StepLimit::rest, part * chosen.critical_time_step),
                                         std::pair(StepLimit::pressed, parts_at_most * chosen.pressed_time_step),
                                         std::pair(StepLimit::hand, longest_of_hand)})
        if (limit == StepLimit::rest || longest < chosen.longest_time_step) {
            chosen.limit = limit;
            chosen.longest_time_step = longest;
        }
    chosen.unscaled_time_step = chosen.longest_time_step;
    return chosen;
}

} // namespace

void check_settings(const Settings &settings) {
    if (std::ranges::find(spring_names(), settings.springs) == spring_names().end())
        throw support::InputError(support::unknown_name("springs", settings.springs, spring_names()));
    check_range("a Young's modulus", settings.young_modulus, 1.0, 1e9, " Pa");
    check_range("a Poisson's ratio", settings.poisson_ratio, 0.0, 0.49, "");
    check_range("a damping by mass", settings.damping.alpha, 0.0, 1000.0, " 1/s");
    check_range("a damping by stiffness", settings.damping.beta, 0.0, 0.1, " s");
    check_range("a time step", settings.time_step, 0.0, 1.0, " s");
}

void check_tool(const Tool &tool, const Surface &surface) {
    if (tool.kind == ToolKind::none || tool.kind == ToolKind::needle)
        return;
    if (tool.kind != ToolKind::probe && tool.kind != ToolKind::pull && tool.kind != ToolKind::grasp)
        throw support::InputError(
            fmt::format("tool {}: take 0 for none, 1 for the probe, 2 for a pull, 3 for a needle or 4 for a grasp",
                        static_cast<int>(tool.kind)));
    if (!tool.target.allFinite() || !(tool.target.norm() < 1e3))
        throw support::InputError("a tool is led to a place that is none, or a kilometre away; lead it to the body");
    check_range("a tool's radius", tool.radius, 1e-3, 0.1, " m");
    check_range("a tool's friction", tool.friction, 0.0, 10.0, "");
    if (tool.kind == ToolKind::grasp) {
        if (!tool.place.allFinite() || !tool.inwards.allFinite() || !(tool.inwards.norm() > 0.0))
            throw support::InputError("a grasp begins at no place, or goes in no direction; press on the body");
        check_range("a grasp's depth", tool.depth, -0.1, 0.1, " m");
    }
    if (tool.face != core::ToolFace::ball && !(tool.inwards.allFinite() && tool.inwards.norm() > 0.0))
        throw support::InputError("a plate goes in no direction; press on the body");
    if (tool.kind == ToolKind::pull && !std::ranges::binary_search(surface.nodes, tool.node))
        throw support::InputError(
            fmt::format("node {} cannot be pulled; take one of the surface that is not constrained", tool.node));
}

double critical_step(double highest, const Settings &settings) {
    return msm::critical_time_step(symplectic_euler(), settings.damping, lowest_part * highest, highest);
}

std::vector<bool> constrained_nodes(const core::TetraMesh &mesh, const std::vector<bool> &is_constrained) {
    std::vector<bool> nodes(mesh.points.size(), false);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (is_constrained[f])
            for (const int node : mesh.boundary_triangles[f])
                nodes[node] = true;
    return nodes;
}

msm::NodalConditions constrained_conditions(const std::vector<bool> &is_constrained) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    msm::NodalConditions conditions;
    conditions.force.assign(is_constrained.size(), core::Vector3::Zero());
    for (const bool constrained : is_constrained) {
        conditions.displacement.emplace_back(core::Vector3::Constant(constrained ? 0.0 : nan));
        conditions.constraint.push_back(constrained ? std::array{0, 0, 0} : std::array{-1, -1, -1});
    }
    return conditions;
}

std::vector<double> watched_volumes(const core::Body &body, const msm::MassSprings &parts,
                                    const msm::NodalConditions &conditions, const Stepping &stepping) {
    const auto &chosen = stepping.chosen;
    if (chosen.time_step <= chosen.pressed_time_step)
        return {};
    auto terms = parts.body.terms;
    terms.push_back(msm::pressed_guard(with_material_of_guard(body)));
    const auto rest = msm::to_unknowns(body.mesh.points);
    std::vector<Eigen::Matrix3d> block(body.mesh.points.size(), Eigen::Matrix3d::Zero());
    for (const auto &term : terms)
        term->add_block_bound(rest, block);
    // No more than the trace, and no less than a third of it: as good a measure as an eigenvalue, and cheaper.
    std::vector<double> bound;
    for (std::size_t i = 0; i < block.size(); ++i)
        bound.push_back(std::isnan(conditions.displacement[i].x()) ? block[i].trace() / parts.body.node_mass[i] : 0.0);
    for (const auto &region : stepping.scaling.parts)
        for (const int node : region.nodes)
            bound[node] /= region.factor;
    const double part = chosen.pressed_time_step / chosen.time_step;
    const double bearable = part * part * *std::ranges::max_element(bound);
    auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const bool is_stiff =
            std::ranges::any_of(body.mesh.tetrahedra[t], [&](int node) { return bound[node] > bearable; });
        volumes[t] *= is_stiff ? watched_part : 0.0;
    }
    return volumes;
}

Stepping chosen_steps(const core::Body &body, const msm::MassSprings &parts, const msm::NodalConditions &conditions,
                      const Settings &settings) {
    const auto plain = longest_steps(body, parts, conditions, {}, settings);
    Stepping stepping{.chosen = plain, .scaling = msm::scale_masses(body, parts.body, conditions), .unscaled = plain};
    if (!stepping.scaling.parts.empty())
        stepping.chosen = longest_steps(body, parts, conditions, stepping.scaling, settings);
    auto &chosen = stepping.chosen;
    if (chosen.longest_time_step < least_gain * plain.longest_time_step)
        stepping = {.chosen = plain, .scaling = {}, .unscaled = plain};
    chosen.unscaled_time_step = plain.longest_time_step;
    chosen.time_step = settings.time_step > 0.0 ? settings.time_step : chosen.longest_time_step;
    if (chosen.time_step > chosen.longest_time_step * rounding)
        throw support::InputError(
            fmt::format("a time step of {:.3g} s is too long; {:.3g} s is the longest that is safe", chosen.time_step,
                        chosen.longest_time_step));
    if (!stepping.scaling.parts.empty() && chosen.time_step <= plain.longest_time_step * rounding) {
        chosen.pressed_time_step = plain.pressed_time_step;
        chosen.critical_time_step = plain.critical_time_step;
        stepping.scaling = {};
    }
    return stepping;
}

double mean_edge(const core::TetraMesh &mesh) {
    const auto edges = core::edge_table(mesh.tetrahedra).edges;
    double sum = 0.0;
    for (const auto &[a, b] : edges)
        sum += (mesh.points[b] - mesh.points[a]).norm();
    return sum / static_cast<double>(edges.size());
}

double largest_speed(const Eigen::VectorXd &velocity) {
    double square = 0.0;
    for (Eigen::Index i = 0; i < velocity.size(); i += 3)
        square = std::max(square, velocity.segment<3>(i).squaredNorm());
    return std::sqrt(square);
}

double smallest_volume_ratio(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const auto &[a, b, c, d] : mesh.tetrahedra) {
        const auto &x = mesh.points;
        const double rest = core::signed_volume(x[a], x[b], x[c], x[d]);
        const double now = core::signed_volume(x[a] + displacement[a], x[b] + displacement[b], x[c] + displacement[c],
                                               x[d] + displacement[d]);
        smallest = std::min(smallest, now / rest);
    }
    return smallest;
}

double indentation(const Load &load, const std::vector<core::Vector3> &displacement) {
    double work = 0.0;
    for (std::size_t k = 0; k < load.nodes.size(); ++k)
        work += load.nodal[k].dot(displacement[load.nodes[k]]);
    return load.pressed > 0.0 ? work / load.pressed : 0.0;
}

namespace {

constexpr std::size_t most_nodes = 1'000'000;

/// Whether all entries of some lists are numbers of something.
bool are_below(const auto &lists, std::size_t count) {
    return std::ranges::all_of(lists, [count](const auto &list) {
        return std::ranges::all_of(list, [count](int i) { return i >= 0 && static_cast<std::size_t>(i) < count; });
    });
}

void check_mesh(const core::TetraMesh &mesh) {
    const auto fault = [](const std::string &what) {
        throw support::InputError(what + "; the file is damaged, make it again with `livermark run`");
    };
    if (mesh.points.empty() || mesh.points.size() > most_nodes || mesh.tetrahedra.empty())
        fault(fmt::format("a body of {} nodes and {} tetrahedra", mesh.points.size(), mesh.tetrahedra.size()));
    if (!std::ranges::all_of(mesh.points, [](const auto &x) { return x.allFinite(); }))
        fault("a node has a place that is no number");
    if (!are_below(mesh.tetrahedra, mesh.points.size()) || !are_below(mesh.boundary_triangles, mesh.points.size()))
        fault("a tetrahedron or triangle names a node that is not there");
    if (mesh.region.size() != mesh.tetrahedra.size() || !std::ranges::all_of(mesh.region, [&](int r) {
            return r >= 0 && static_cast<std::size_t>(r) < mesh.region_names.size();
        }))
        fault("a tetrahedron has a material that is not there");
    const auto volumes = core::tetrahedron_volumes(mesh);
    if (!std::ranges::all_of(volumes, [](double v) { return v > 0.0; }))
        fault("a tetrahedron has no volume, or is inverted");
    const auto nodal = core::nodal_volumes(mesh);
    if (!std::ranges::all_of(nodal, [](double v) { return v > 0.0; }))
        fault("a node belongs to no tetrahedron");
}

bool is_above_zero(double value) {
    return value > 0.0 && std::isfinite(value);
}

void check_vessels(const core::VesselTree &tree) {
    const auto fault = [](const char *what) {
        throw support::InputError("{}; the file is damaged, make it again with `livermark run`", what);
    };
    if (tree.radius.size() != tree.points.size() || !std::ranges::all_of(tree.radius, is_above_zero))
        fault("a point of a vessel has no radius");
    if (!std::ranges::all_of(tree.points, [](const auto &x) { return x.allFinite(); }))
        fault("a point of a vessel has a place that is no number");
    if (!are_below(tree.segments, tree.points.size()))
        fault("a segment of a vessel names a point that is not there");
    for (std::size_t s = 0; s < tree.segments.size(); ++s)
        if (!is_above_zero(tree.length(s)))
            fault("a segment of a vessel has no length");
    if (!(is_above_zero(tree.wall_ratio) && tree.wall_ratio <= 1.0) || !is_above_zero(tree.wall_modulus))
        fault("vessels have walls of no thickness or no stiffness");
}

/// Parts of a body that few have.
void check_parts(const core::Body &body) {
    const auto &factors = body.modulus_factor;
    if (!factors.empty() &&
        (factors.size() != body.mesh.tetrahedra.size() || !std::ranges::all_of(factors, is_above_zero)))
        throw support::InputError("the map of stiffness does not have a factor above zero for each tetrahedron; the "
                                  "file is damaged, make it again with `livermark run`");
    if (body.capsule && !(is_above_zero(body.capsule->thickness) && is_above_zero(body.capsule->young_modulus)))
        throw support::InputError("a capsule of {} m and {} Pa; both have to be above zero", body.capsule->thickness,
                                  body.capsule->young_modulus);
    if (body.vessels)
        check_vessels(*body.vessels);
}

} // namespace

void check_body(const core::Body &body, const std::vector<bool> &is_constrained) {
    check_mesh(body.mesh);
    if (body.materials.size() != body.mesh.region_names.size() || body.materials.empty())
        throw support::InputError("a region has no material; give each one");
    for (const auto &material : body.materials)
        if (!(material.density > 0.0 && material.density < 1e6 && material.young_modulus > 0.0 &&
              material.young_modulus < 1e12))
            throw support::InputError(fmt::format("a material of {} kg/m^3 and {} Pa; both have to be above zero",
                                                  material.density, material.young_modulus));
    check_parts(body);
    if (is_constrained.size() != body.mesh.boundary_triangles.size())
        throw support::InputError("the constraints are not given for every triangle of the boundary");
    if (std::ranges::none_of(is_constrained, [](bool constrained) { return constrained; }))
        throw support::InputError(
            "this load case does not constrain the body, so it would fly away; open one that does, such "
            "as palpation");
    if (std::ranges::all_of(is_constrained, [](bool constrained) { return constrained; }))
        throw support::InputError("all of the surface is constrained, so nothing can be touched; constrain less of it");
}

void check_foundation(const core::Foundation &foundation, const core::TetraMesh &mesh,
                      const std::vector<bool> &is_constrained) {
    const auto fault = [](const char *what) {
        throw support::InputError("{}; the file is damaged, make it again with `livermark run`", what);
    };
    const auto &facets = foundation.facets;
    if (foundation.stiffness.size() != facets.size() || foundation.normal_only.size() != facets.size() ||
        !std::ranges::all_of(foundation.stiffness, is_above_zero))
        fault("a facet of a foundation has no stiffness");
    if (!std::ranges::all_of(facets, [&](int f) { return f >= 0 && f < mesh.num_boundary_triangles(); }))
        fault("a foundation names a facet that is not there");
    if (std::ranges::adjacent_find(facets, std::greater_equal()) != facets.end())
        fault("a foundation names a facet twice, or not in order");
    if (std::ranges::any_of(facets, [&](int f) { return is_constrained[static_cast<std::size_t>(f)]; }))
        fault("a foundation names a facet that is constrained");
}

} // namespace livermark::live
