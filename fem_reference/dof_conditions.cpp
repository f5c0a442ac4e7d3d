#include "fem_reference/dof_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace livermark::fem_reference {

namespace {

constexpr double is_free = std::numeric_limits<double>::quiet_NaN();

/// Values at the nodes of the mesh as those of all nodes of the facets, linear along edges.
/// @param at_mesh_nodes  (N), or empty
/// @param elsewhere      at nodes that are on no facet, and everywhere where there are no values
template <class T>
std::vector<T> at_facet_nodes(const std::vector<T> &at_mesh_nodes, const ElasticSystem &system, const T &elsewhere) {
    std::vector<T> values(system.points.size(), elsewhere);
    if (at_mesh_nodes.empty())
        return values;
    for (std::size_t node = 0; node < system.mesh_node.size(); ++node)
        values[system.mesh_node[node]] = at_mesh_nodes[node];
    for (std::size_t first = 0; first < system.facet_nodes.size(); first += system.nodes_per_facet)
        for (int middle = 3; middle < system.nodes_per_facet; ++middle) {
            const int a = system.facet_nodes[first + middle - 3], b = system.facet_nodes[first + (middle - 2) % 3];
            values[system.facet_nodes[first + middle]] = 0.5 * (values[a] + values[b]);
        }
    return values;
}

/// (nodes_per_facet) integrals of the shape functions over a facet, weighted with what a round tool presses [m^2].
std::vector<double> integrals(const core::LoadCase &load_case, int facet, const ElasticSystem &system) {
    const int size = system.nodes_per_facet;
    const auto first = system.facet_integral.begin() + static_cast<std::ptrdiff_t>(facet) * size;
    std::vector<double> integral(first, first + size);
    const auto *load = load_case.round_load_on(facet);
    if (!load)
        return integral;
    const double area = std::accumulate(integral.begin(), integral.end(), 0.0);
    core::Corners corners;
    for (int k = 0; k < 3; ++k)
        corners[k] = system.points[system.facet_nodes[facet * size + k]];
    const auto share = [&](const auto &parts) {
        std::ranges::transform(parts, integral.begin(), [&](double part) { return area * part; });
    };
    size == 3 ? share(core::linear_parts(load, corners)) : share(core::quadratic_parts(load, corners));
    return integral;
}

void add_traction(const core::LoadCase &load_case, int facet, const ElasticSystem &system, std::vector<double> &load) {
    const auto integral = integrals(load_case, facet, system);
    for (int k = 0; k < system.nodes_per_facet; ++k)
        for (int i = 0; i < 3; ++i)
            if (!std::isnan(load_case.value[facet][i]))
                load[3 * system.facet_nodes[facet * system.nodes_per_facet + k] + i] +=
                    load_case.value[facet][i] * integral[k];
}

} // namespace

DofConditions dof_conditions(const core::LoadCase &load_case, const ElasticSystem &system) {
    DofConditions dofs;
    dofs.press_depth = load_case.press_depth;
    dofs.prescribed.assign(3 * system.points.size(), is_free);
    dofs.constraint.assign(3 * system.points.size(), -1);
    dofs.load.reserve(3 * system.points.size());
    for (const double mass : system.mass_integral)
        for (int i = 0; i < 3; ++i)
            dofs.load.push_back(mass * load_case.acceleration[i]);

    const auto factor = at_facet_nodes(load_case.node_factor, system, 1.0);
    const core::Vector3 none = core::Vector3::Zero();
    const auto shift = at_facet_nodes(load_case.node_shift, system, none);
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (load_case.is_loaded(f))
            add_traction(load_case, f, system, dofs.load);
        for (int k = f * system.nodes_per_facet; k < (f + 1) * system.nodes_per_facet; ++k) {
            for (int i = 0; i < 3; ++i) {
                const double value = load_case.value[f][i];
                const int dof = 3 * system.facet_nodes[k] + i;
                if (std::isnan(value))
                    continue;
                int &owner = dofs.constraint[dof];
                if (load_case.is_constrained(f) && (owner < 0 || load_case.constraint_on(f) < owner)) {
                    owner = load_case.constraint_on(f);
                    dofs.prescribed[dof] = factor[system.facet_nodes[k]] * value + shift[system.facet_nodes[k]][i];
                }
            }
        }
    }
    return dofs;
}

} // namespace livermark::fem_reference
