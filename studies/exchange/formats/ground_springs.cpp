#include "studies/exchange/formats/ground_springs.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/mesh/places.hpp"
#include "core/part_springs.hpp"

namespace livermark::exchange {

using core::Vector3;

namespace {

constexpr double long_rest = 1000.0; // [m]

GroundSpring vessel_spring(const core::Body &body, const core::VesselSpring &spring) {
    const auto &[begin, end] = spring.ends;
    const double root = std::sqrt(spring.stiffness);
    GroundSpring found{.rest = root * (core::point_in(body, spring.tetrahedron, end) -
                                       core::point_in(body, spring.tetrahedron, begin)),
                       .displacement = {}};
    const auto &nodes = body.mesh.tetrahedra[spring.tetrahedron];
    for (int component = 0; component < 3; ++component)
        for (int k = 0; k < 4; ++k)
            found.displacement[component].push_back({nodes[k], component, root * (end[k] - begin[k])});
    return found;
}

/// Shape functions of a facet of three nodes, or of six: corners, then middles of its sides.
Eigen::VectorXd shapes_at(const std::array<double, 3> &at, std::size_t num_nodes) {
    Eigen::VectorXd shapes(static_cast<Eigen::Index>(num_nodes));
    const bool is_linear = num_nodes == 3;
    for (int v = 0; v < 3; ++v) {
        shapes[v] = is_linear ? at[v] : at[v] * (2.0 * at[v] - 1.0);
        if (!is_linear)
            shapes[3 + v] = 4.0 * at[v] * at[(v + 1) % 3];
    }
    return shapes;
}

/// L of L L^T, the mean of N_a N_b over a facet.
Eigen::MatrixXd root_of_mass(std::size_t num_nodes) {
    const auto size = static_cast<Eigen::Index>(num_nodes);
    Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(size, size);
    for (const auto &point : core::facet_points(1)) {
        const auto shapes = shapes_at(point.shape, num_nodes);
        mass += point.part * shapes * shapes.transpose();
    }
    return mass.llt().matrixL();
}

void add_foundation(std::vector<GroundSpring> &springs, const core::Foundation &foundation, const core::TetraMesh &mesh,
                    const Discretisation &fem) {
    const auto root = root_of_mass(fem.facets.front().size());
    for (std::size_t which = 0; which < foundation.facets.size(); ++which) {
        const int facet = foundation.facets[which];
        const Vector3 area = core::area_vector(mesh, facet);
        const double scale = std::sqrt(foundation.stiffness[which] * area.norm());
        const auto add = [&](const Vector3 &direction) {
            for (Eigen::Index column = 0; column < root.cols(); ++column) {
                GroundSpring spring{.rest = {long_rest, 0.0, 0.0}, .displacement = {}};
                for (Eigen::Index a = column; a < root.rows(); ++a) // L is lower
                    for (int i = 0; i < 3; ++i)
                        if (direction[i] != 0.0)
                            spring.displacement[0].push_back({fem.facets[facet][static_cast<std::size_t>(a)], i,
                                                              scale * root(a, column) * direction[i]});
                springs.push_back(std::move(spring));
            }
        };
        if (foundation.normal_only[which] != 0)
            add(area.normalized());
        else
            for (int i = 0; i < 3; ++i)
                add(Vector3::Unit(i));
    }
}

} // namespace

std::vector<GroundSpring> ground_springs(const core::Problem &problem, const Discretisation &fem) {
    std::vector<GroundSpring> springs;
    for (const auto &spring : core::vessel_springs(*problem.body))
        springs.push_back(vessel_spring(*problem.body, spring));
    if (const auto &foundation = problem.load_case.foundation)
        add_foundation(springs, *foundation, problem.body->mesh, fem);
    return springs;
}

SpringTable::SpringTable(const std::vector<GroundSpring> &springs) {
    for (std::size_t s = 0; s < springs.size(); ++s) {
        rest.push_back(springs[s].rest);
        for (int i = 0; i < 3; ++i)
            for (const auto &term : springs[s].displacement[i]) {
                terms.push_back({static_cast<int>(s), i, term.node, term.component});
                factor.push_back(term.factor);
            }
    }
}

} // namespace livermark::exchange
