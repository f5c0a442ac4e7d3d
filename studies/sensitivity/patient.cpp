#include "studies/sensitivity/patient.hpp"

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

#include "core/tool/tool_stiffness.hpp"
#include "load_cases/places/facets.hpp"
#include "load_cases/readers/load_case_tables.hpp"
#include "studies/sensitivity/soft_support.hpp"
#include "support/toml_input.hpp"

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
    }
}

} // namespace

std::vector<int> tumour_regions(const core::Body &body) {
    std::vector<int> regions;
    for (std::size_t r = 1; r < body.materials.size(); ++r)
        if (body.materials[r].young_modulus > body.materials.front().young_modulus)
            regions.push_back(static_cast<int>(r));
    return regions;
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
    problem.body = body;
    if (patient.tool_offset)
        problem.load_case = with_tool_moved(problem.load_case, *body, *patient.tool_offset);
    if (patient.held_share)
        problem.load_case = with_held_share(std::move(problem.load_case), body->mesh, *patient.held_share);
    return patient.support_stiffness ? with_soft_support(problem, *patient.support_stiffness) : problem;
}

} // namespace livermark::studies
