#include "studies/sensitivity/sensitivity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>

#include "core/mesh/places.hpp"
#include "core/mesh/plausible_liver.hpp"
#include "core/support/input_error.hpp"
#include "core/support/toml_input.hpp"
#include "core/tool/tool_stiffness.hpp"
#include "load_cases/places/selector.hpp"
#include "load_cases/readers/event_reader.hpp"

namespace livermark::studies {

namespace {

using core::Vector3;

/// The discs of the conditions of a load case.
std::vector<toml::table *> discs_of(toml::table &definition) {
    std::vector<toml::table *> discs;
    if (auto *conditions = definition["condition"].as_array())
        for (auto &condition : *conditions)
            if (auto *disc = condition.as_table() ? condition.as_table()->get_as<toml::table>("disc") : nullptr)
                discs.push_back(disc);
    return discs;
}

toml::table definition_of(const core::LoadCase &load_case) {
    return support::parse_toml(load_case.definition, load_case.name + ".toml");
}

/// Two directions along a surface.
std::pair<Vector3, Vector3> along_surface(const Vector3 &normal) {
    constexpr double nearly_along = 0.9; // cosine
    const Vector3 axis = std::abs(normal.x()) > nearly_along ? Vector3::UnitY() : Vector3::UnitX();
    const Vector3 first = (axis - axis.dot(normal) * normal).normalized();
    return {first, normal.cross(first)};
}

/// The same material with a part of its shear modulus and all of its bulk modulus, as tissue that has relaxed.
core::Material with_shear_left(core::Material material, double shear_left) {
    const double shear = shear_left * material.shear_modulus();
    const double three_bulk = 3.0 * material.lame_lambda() + 2.0 * material.shear_modulus();
    material.young_modulus = 3.0 * three_bulk * shear / (three_bulk + shear);
    material.poisson_ratio = (three_bulk - 2.0 * shear) / (2.0 * (three_bulk + shear));
    return material;
}

void set_materials(core::Body &body, const Patient &patient, const std::vector<int> &tumours) {
    const double first = body.materials.front().young_modulus;
    const double modulus = patient.young_modulus.value_or(first);
    for (std::size_t r = 0; r < body.materials.size(); ++r) {
        auto &material = body.materials[r];
        const bool is_tumour = std::ranges::find(tumours, static_cast<int>(r)) != tumours.end();
        const double ratio = material.young_modulus / first;
        material.young_modulus = modulus * (is_tumour ? patient.tumour_contrast.value_or(ratio) : ratio);
        material.poisson_ratio = patient.poisson_ratio.value_or(material.poisson_ratio);
        material.density = patient.density.value_or(material.density);
        if (patient.shear_left)
            material = with_shear_left(material, *patient.shear_left);
    }
}

void set_map(core::Body &body, const Patient &patient) {
    if (!body.modulus_factor.empty() && (patient.map_contrast || patient.map_slope))
        body.modulus_factor =
            with_map_changed(body, patient.map_contrast.value_or(1.0), patient.map_slope.value_or(0.0));
}

/// A membrane is known by E t alone, so that one of any thickness will do.
void set_capsule(core::Body &body, double stiffness) {
    constexpr double thickness = 20e-6; // [m]
    if (!body.capsule)
        body.capsule = core::Capsule{.thickness = thickness};
    body.capsule->young_modulus = stiffness / body.capsule->thickness;
}

/// Joins a patch that no capsule covers to the patches of facets.
void uncover(core::TetraMesh &mesh, const std::vector<int> &facets) {
    std::map<int, int> joined; // the patch beside a patch
    for (const int facet : facets) {
        int &patch = mesh.boundary_patch[facet];
        const auto [entry, is_new] = joined.try_emplace(patch, static_cast<int>(mesh.patch_names.size()));
        if (is_new)
            mesh.patch_names.push_back(std::string(core::wound_patch) + core::patch_joint + mesh.patch_names[patch]);
        patch = entry->second;
    }
}

constexpr double thickness_in_edges = 0.05;
constexpr double layer_poisson_ratio = 0.25;
/// Modulus of a layer that cannot widen, over Young's modulus: (1 - nu) / ((1 + nu)(1 - 2 nu)).
constexpr double confined_modulus =
    (1.0 - layer_poisson_ratio) / ((1.0 + layer_poisson_ratio) * (1.0 - 2.0 * layer_poisson_ratio));

std::array<int, 3> sorted_corners(std::array<int, 3> corners) {
    std::ranges::sort(corners);
    return corners;
}

double held_edge_length(const core::TetraMesh &mesh, const std::vector<int> &facets) {
    double sum = 0.0;
    for (const int facet : facets) {
        const auto [a, b, c] = core::corners_of(mesh, facet);
        sum += (a - b).norm() + (b - c).norm() + (c - a).norm();
    }
    return sum / (3.0 * static_cast<double>(facets.size()));
}

/// The node of the outer side over each node of the facets, in ascending order of both; appended to the mesh.
std::map<int, int> add_outer_nodes(core::TetraMesh &mesh, const std::vector<int> &facets, double thickness) {
    std::map<int, Vector3> normals;
    for (const int facet : facets)
        for (const int node : mesh.boundary_triangles[facet])
            normals.try_emplace(node, Vector3::Zero()).first->second += core::area_vector(mesh, facet);
    std::map<int, int> outer;
    for (const auto &[node, normal] : normals) {
        outer[node] = mesh.num_nodes();
        mesh.points.emplace_back(mesh.points[node] + thickness * normal.normalized());
    }
    return outer;
}

/// A prism over a facet in three tetrahedra that fit those of its neighbours: diagonals start at the lower number.
/// (J. Dompierre et al. 1999, How to subdivide pyramids, prisms and hexahedra into tetrahedra, CERCA R99-78)
std::array<std::array<int, 4>, 3> prism(std::array<int, 3> corners, const std::map<int, int> &outer) {
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    const auto [a, b, c] = corners;
    const int over_a = outer.at(a), over_b = outer.at(b), over_c = outer.at(c);
    if (b < c)
        return {{{a, b, c, over_c}, {a, b, over_c, over_b}, {a, over_b, over_c, over_a}}};
    return {{{a, b, c, over_b}, {a, over_b, c, over_c}, {a, over_b, over_c, over_a}}};
}

/// The free facets around the layer, with the patch of the held ones.
void add_rim(core::TetraMesh &mesh, int num_nodes, int patch) {
    std::set<std::array<int, 3>> known;
    for (const auto &corners : mesh.boundary_triangles)
        known.insert(sorted_corners(corners));
    for (const auto &corners : core::outer_faces(mesh.tetrahedra))
        if (std::ranges::any_of(corners, [&](int node) { return node >= num_nodes; }) &&
            !known.contains(sorted_corners(corners))) {
            mesh.boundary_triangles.push_back(corners);
            mesh.boundary_patch.push_back(patch);
        }
}

template <class Value> void extend(std::vector<Value> &values, std::size_t size, const Value &with) {
    if (!values.empty())
        values.resize(size, with);
}

core::LoadCase on_layer(core::LoadCase load_case, const core::TetraMesh &mesh) {
    const auto num_facets = mesh.boundary_triangles.size(), num_nodes = mesh.points.size();
    load_case.condition_on.resize(num_facets, -1);
    load_case.value.resize(num_facets, Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
    extend(load_case.node_factor, num_nodes, 1.0);
    const Vector3 nowhere = Vector3::Zero();
    extend(load_case.node_shift, num_nodes, nowhere);
    return load_case;
}

/// The tumour of the largest volume.
int largest_tumour(const core::Body &body, const std::vector<int> &tumours) {
    std::vector<double> volume(body.materials.size(), 0.0);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        volume[body.mesh.region[t]] += volumes[t];
    return *std::ranges::max_element(tumours, {}, [&](int region) { return volume[region]; });
}

core::Vector3 centroid_displacement(const core::TetraMesh &mesh, const std::vector<core::Vector3> &displacement,
                                    int region) {
    const std::vector<core::Vector3> rest(displacement.size(), core::Vector3::Zero());
    return core::deformation(mesh, displacement).centroid[region] - core::deformation(mesh, rest).centroid[region];
}

double largest_displacement(const std::vector<core::Vector3> &displacement, int num_nodes) {
    double peak = 0.0;
    for (int i = 0; i < num_nodes; ++i)
        peak = std::max(peak, displacement[i].norm());
    return peak;
}

} // namespace

Patient patient_of(const std::vector<std::string> &names, const std::vector<double> &values) {
    Patient patient;
    for (std::size_t p = 0; p < names.size(); ++p)
        if (names[p] == "young_modulus")
            patient.young_modulus = values[p];
        else if (names[p] == "poisson_ratio")
            patient.poisson_ratio = values[p];
        else if (names[p] == "tumour_contrast")
            patient.tumour_contrast = values[p];
        else if (names[p] == "shear_left")
            patient.shear_left = values[p];
        else if (names[p] == "capsule_stiffness")
            patient.capsule_stiffness = values[p];
        else if (names[p] == "density")
            patient.density = values[p];
        else if (names[p] == "map_contrast")
            patient.map_contrast = values[p];
        else if (names[p] == "map_slope")
            patient.map_slope = values[p];
        else if (names[p] == "held_share")
            patient.held_share = values[p];
        else if (names[p] == "support_stiffness")
            patient.support_stiffness = values[p];
        else if (!patient.tool_offset)
            patient.tool_offset = Eigen::Vector2d(values[p], 0.0);
        else
            patient.tool_offset->y() = values[p];
    return patient;
}

std::vector<int> tumour_regions(const core::Body &body) {
    const auto &names = body.mesh.region_names;
    const auto is_vessel = [&](std::size_t r) {
        return r < names.size() && core::role_of_name(names[r]) == core::SegmentRole::vessel;
    };
    std::vector<int> regions;
    for (std::size_t r = 1; r < body.materials.size(); ++r)
        if (body.materials[r].young_modulus > body.materials.front().young_modulus && !is_vessel(r))
            regions.push_back(static_cast<int>(r));
    return regions;
}

std::vector<double> with_map_changed(const core::Body &body, double contrast, double slope) {
    const auto &mesh = body.mesh;
    const Vector3 posterior = body.axes.from_lps.col(1);
    std::vector<double> depth;
    for (const auto &tetrahedron : mesh.tetrahedra) {
        Vector3 centroid = Vector3::Zero();
        for (const int node : tetrahedron)
            centroid += 0.25 * mesh.points[node];
        depth.push_back(posterior.dot(centroid));
    }
    const auto [least, most] = std::ranges::minmax(depth);
    auto factor = body.modulus_factor;
    for (std::size_t t = 0; t < factor.size(); ++t)
        factor[t] = std::pow(factor[t], contrast) * std::exp(slope * ((depth[t] - least) / (most - least) - 0.5));
    return factor;
}

std::vector<int> held_facets(const core::LoadCase &load_case) {
    std::vector<int> held;
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_constrained(f) && load_case.value[f].isZero(0.0))
            held.push_back(f);
    return held;
}

core::LoadCase with_held_share(core::LoadCase load_case, const core::TetraMesh &mesh, double share) {
    auto facets = held_facets(load_case);
    const Vector3 middle = load_cases::middle_of(facets, mesh);
    const double wanted = share * load_cases::area_of(facets, mesh);
    std::ranges::stable_sort(facets, {}, [&](int f) { return (load_cases::facet_centroid(mesh, f) - middle).norm(); });
    double area = 0.0;
    for (const int f : facets) {
        if (area >= wanted) {
            load_case.free_facet(f);
            load_case.value[f].setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        area += core::area_vector(mesh, f).norm();
    }
    return load_case;
}

bool has_movable_tool(const core::LoadCase &load_case) {
    auto definition = definition_of(load_case);
    const auto discs = discs_of(definition);
    return load_case.round_loads().size() == 1 && discs.size() == 1 &&
           !support::optional_flag(*discs.front(), "opposite");
}

core::LoadCase with_tool_moved(const core::LoadCase &load_case, const core::Body &body, const Eigen::Vector2d &offset) {
    const auto &mesh = body.mesh;
    auto definition = definition_of(load_case);
    load_cases::turn_directions(definition, body.axes); // as long as it names its patches
    load_cases::bring_to_metres(definition);
    auto &disc = *discs_of(definition).front();
    const Vector3 middle = load_case.round_loads().front().middle;
    const auto nearest = load_cases::nearest_point(load_cases::all_facets(mesh), mesh, middle);
    const auto [first, second] = along_surface(core::area_vector(mesh, nearest.facet).normalized());
    const Vector3 moved = middle + offset.x() * first + offset.y() * second;
    for (const auto *key : {"patch", "region", "direction"})
        disc.erase(key);
    disc.insert_or_assign("point", toml::array{moved.x(), moved.y(), moved.z()});
    auto there =
        core::scaled(load_cases::load_case_of_table(definition, load_case.name + ".toml", mesh), load_case.load_scale);
    there.scale_to_target = false;
    there.definition = load_case.definition;
    return there;
}

core::Problem problem_of(const Patient &patient, const core::Problem &nominal) {
    auto problem = nominal;
    const auto tumours = tumour_regions(*nominal.body);
    auto body = std::make_shared<core::Body>(*nominal.body);
    set_materials(*body, patient, tumours);
    set_map(*body, patient);
    if (patient.capsule_stiffness)
        set_capsule(*body, *patient.capsule_stiffness);
    problem.body = body;
    if (patient.tool_offset)
        problem.load_case = with_tool_moved(problem.load_case, *body, *patient.tool_offset);
    if (patient.held_share)
        problem.load_case = with_held_share(std::move(problem.load_case), body->mesh, *patient.held_share);
    return patient.support_stiffness ? with_soft_support(problem, *patient.support_stiffness) : problem;
}

core::Problem with_soft_support(const core::Problem &problem, double stiffness) {
    const auto held = held_facets(problem.load_case);
    auto body = std::make_shared<core::Body>(*problem.body);
    auto &mesh = body->mesh;
    const int num_nodes = mesh.num_nodes();
    const double thickness = thickness_in_edges * held_edge_length(mesh, held);
    const auto outer = add_outer_nodes(mesh, held, thickness);
    const auto region = static_cast<int>(mesh.region_names.size());
    mesh.region_names.emplace_back("support");
    body->materials.push_back({.density = body->materials.front().density,
                               .young_modulus = stiffness * thickness / confined_modulus,
                               .poisson_ratio = layer_poisson_ratio});
    for (const int facet : held) {
        auto &corners = mesh.boundary_triangles[facet];
        for (const auto &tetrahedron : prism(corners, outer)) {
            const auto &[a, b, c, d] = tetrahedron;
            if (!(core::signed_volume(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) > 0.0))
                throw support::InputError(
                    fmt::format("{}: the surface that {} constrains folds back within {:.2g} mm, so no soft support "
                                "fits on it; mesh it more finely, or leave [support_stiffness] out of the ranges",
                                body->name, problem.load_case.name, 1e3 * thickness));
            mesh.tetrahedra.push_back(tetrahedron);
            mesh.region.push_back(region);
            if (!body->modulus_factor.empty())
                body->modulus_factor.push_back(1.0);
        }
        for (int &node : corners)
            node = outer.at(node);
    }
    if (body->capsule)
        uncover(mesh, held);
    add_rim(mesh, num_nodes, mesh.boundary_patch[held.front()]);
    return {body, on_layer(problem.load_case, mesh)};
}

const char *name_of(Output output) {
    switch (output) {
    case Output::stiffness_at_tool:
        return "stiffness_at_tool";
    case Output::peak_displacement:
        return "peak_displacement";
    case Output::tumour_displacement:
        return "tumour_displacement";
    }
    throw std::logic_error("an output without a name");
}

std::vector<Output> outputs_of(const core::Problem &nominal) {
    std::vector<Output> outputs;
    if (!core::tool_places(nominal.body->mesh, nominal.load_case).empty())
        outputs.push_back(Output::stiffness_at_tool);
    outputs.push_back(Output::peak_displacement);
    if (!tumour_regions(*nominal.body).empty())
        outputs.push_back(Output::tumour_displacement);
    return outputs;
}

OutputValues values_of(const std::vector<Output> &outputs, const core::Problem &nominal, const core::Problem &problem,
                       const core::Solution &solution) {
    OutputValues found;
    if (solution.status != core::SolutionStatus::ok) {
        found.values.assign(outputs.size(), std::numeric_limits<double>::quiet_NaN());
        found.tumour.setConstant(std::numeric_limits<double>::quiet_NaN());
        return found;
    }
    const auto &mesh = problem.body->mesh;
    for (const auto output : outputs)
        switch (output) {
        case Output::stiffness_at_tool:
            found.values.push_back(
                core::stiffness_at(mesh, problem.load_case, core::tool_places(mesh, problem.load_case), 0, solution));
            break;
        case Output::peak_displacement:
            found.values.push_back(largest_displacement(solution.displacement, nominal.body->mesh.num_nodes()));
            break;
        case Output::tumour_displacement:
            found.tumour = centroid_displacement(mesh, solution.displacement,
                                                 largest_tumour(*nominal.body, tumour_regions(*nominal.body)));
            found.values.push_back(found.tumour.norm());
            break;
        }
    return found;
}

} // namespace livermark::studies
