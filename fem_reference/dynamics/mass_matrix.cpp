#include "fem_reference/dynamics/mass_matrix.hpp"

#include <algorithm>

namespace livermark::fem_reference {

SymmetricMatrix consistent_mass(const core::Body &body, const ElasticSystem &system) {
    auto mass = zero_of_blocks(system.stiffness.rows);
    const auto volumes = core::tetrahedron_volumes(body.mesh);
    const int num_local = system.nodes_per_cell;
    for (std::size_t t = 0; t < volumes.size(); ++t) {
        const double cell_mass = body.materials[body.mesh.region[t]].density * volumes[t];
        const int *const nodes = system.cell_nodes.data() + t * num_local;
        for (int a = 0; a < num_local; ++a) {
            const auto row = mass.column.begin() + mass.row_start[nodes[a]];
            const auto row_end = mass.column.begin() + mass.row_start[nodes[a] + 1];
            for (int b = 0; b < num_local; ++b)
                mass.value[std::lower_bound(row, row_end, nodes[b]) - mass.column.begin()] +=
                    cell_mass * system.reference_mass[a * num_local + b];
        }
    }
    return mass;
}

void multiply_mass(const SymmetricMatrix &mass, std::span<const double> x, std::span<double> out) {
    for (int a = 0; a < mass.num_rows(); ++a) {
        core::Vector3 sum = core::Vector3::Zero();
        for (int k = mass.row_start[a]; k < mass.row_start[a + 1]; ++k)
            sum += mass.value[k] * core::Vector3::Map(&x[3 * mass.column[k]]);
        core::Vector3::Map(&out[3 * a]) = sum;
    }
}

SymmetricMatrix combine(double k, SymmetricMatrix stiffness, double m, const SymmetricMatrix &mass) {
    for (double &value : stiffness.value)
        value *= k;
    for (int a = 0; a < mass.num_rows(); ++a)
        for (int i = 0; i < 3; ++i) {
            int entry = stiffness.row_start[3 * a + i] + i;
            for (int block = mass.row_start[a]; block < mass.row_start[a + 1]; ++block, entry += 3)
                stiffness.value[entry] += m * mass.value[block];
        }
    return stiffness;
}

double dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        sum += a[i] * b[i];
    return sum;
}

} // namespace livermark::fem_reference
