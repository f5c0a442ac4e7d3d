#include "load_cases/experiments/solids.hpp"

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/support/toml_input.hpp"
#include "meshes/generators/box_generator.hpp"
#include "meshes/io/body_reader.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

Vector3 optional_vector(const toml::table &table, const char *key) {
    return table.contains(key) ? support::required_vector(table, key) : Vector3::Zero();
}

core::TetraMesh moved(core::TetraMesh mesh, const Vector3 &by) {
    for (auto &point : mesh.points)
        point += by;
    return mesh;
}

/// Meshes of a solid by the length of edges.
struct Solid {
    std::function<core::TetraMesh(double)> mesh;
    std::function<double(double)> side_of_cube; ///< of about its volume [m]
    Vector3 at = Vector3::Zero();               ///< where its corner, base or centre is [m]
    bool is_curved = true;
};

Solid read_box(const toml::table &box) {
    support::refuse_unknown_keys(box, {"size", "edge_length", "corner"});
    const auto size = support::required_vector(box, "size");
    return {[=](double edge) { return meshes::generate_box(size, edge, meshes::BoxTopology::body_centred); },
            [=](double edge) { return meshes::side_of_cube_like_box(size, edge); }, optional_vector(box, "corner"),
            false};
}

Solid read_cylinder(const toml::table &cylinder) {
    support::refuse_unknown_keys(cylinder, {"radius", "height", "edge_length", "base", "quarter"});
    const double radius = support::required_number(cylinder, "radius");
    const double height = support::required_number(cylinder, "height");
    const auto part =
        support::optional_flag(cylinder, "quarter") ? meshes::CylinderPart::quarter : meshes::CylinderPart::whole;
    return {[=](double edge) { return meshes::generate_cylinder(radius, height, edge, part); },
            [=](double edge) { return meshes::side_of_cube_like_cylinder(radius, height, edge, part); },
            optional_vector(cylinder, "base")};
}

Solid read_sphere(const toml::table &sphere) {
    support::refuse_unknown_keys(sphere, {"radius", "edge_length", "centre"});
    const double radius = support::required_number(sphere, "radius");
    return {[=](double edge) { return meshes::generate_sphere(radius, edge); },
            [=](double /*edge*/) { return meshes::side_of_cube_like_sphere(radius); },
            optional_vector(sphere, "centre")};
}

} // namespace

core::Material material_of(const toml::table &table) {
    auto material = meshes::read_material(table, "laws");
    if (table.contains("laws")) {
        const auto &laws = support::required_table(table, "laws");
        for (const auto &[law, constants] : laws)
            material.law_constants[std::string(law.str())] = support::required_numbers(laws, law.str());
    }
    return material;
}

void read_solid(const toml::table &table, const core::Material &material, Experiment &experiment) {
    const std::string key = table.contains("box") ? "box" : table.contains("cylinder") ? "cylinder" : "sphere";
    const auto &solid_table = support::required_table(table, key);
    experiment.edge_length = support::required_number(solid_table, "edge_length");
    const auto solid = key == "box"        ? read_box(solid_table)
                       : key == "cylinder" ? read_cylinder(solid_table)
                                           : read_sphere(solid_table);
    experiment.expected_tetrahedra = [solid](double edge) {
        return meshes::expected_tetrahedra(solid.side_of_cube(edge), edge);
    };
    experiment.body = [solid, material, name = experiment.name](double edge) {
        return core::Body{.name = name, .mesh = moved(solid.mesh(edge), solid.at), .materials = {material}};
    };
    if (solid.is_curved)
        experiment.finer_body = [body = experiment.body](double edge) { return body(0.5 * edge); };
}

} // namespace livermark::experiments
