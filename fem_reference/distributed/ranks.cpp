#include "fem_reference/distributed/ranks.hpp"

#include <deal.II/base/mpi.h>

#include <algorithm>

namespace livermark::fem_reference {

namespace {

/// Over all ranks; what one alone has not zero is exact.
void sum_over_ranks(std::vector<core::Vector3> &vectors) {
    if (!vectors.empty())
        MPI_Allreduce(MPI_IN_PLACE, vectors.front().data(), static_cast<int>(3 * vectors.size()), MPI_DOUBLE, MPI_SUM,
                      MPI_COMM_WORLD);
}

} // namespace

std::vector<core::Vector3> sum_of_reactions(const NodeExchange &nodes, std::span<const int> constraint,
                                            std::span<const double> force, std::size_t num_constraints) {
    std::vector<core::Vector3> sums(num_constraints, core::Vector3::Zero());
    for (const int node : nodes.owned())
        for (int i = 0; i < 3; ++i)
            if (const int owner = constraint[3 * node + i]; owner >= 0)
                sums[owner][i] += force[3 * node + i];
    sum_over_ranks(sums);
    return sums;
}

std::vector<core::Vector3> on_mesh(const Part &part, const ElasticSystem &system, const NodeExchange &nodes,
                                   std::span<const double> displacement) {
    int last = -1;
    for (std::size_t vertex = 0; vertex < part.mesh_node.size(); ++vertex)
        last = std::max(last, part.mesh_node[vertex]);
    std::vector<core::Vector3> result(dealii::Utilities::MPI::max(last, MPI_COMM_WORLD) + 1, core::Vector3::Zero());
    for (std::size_t vertex = 0; vertex < part.mesh_node.size(); ++vertex)
        if (const int node = system.mesh_node[vertex]; part.mesh_node[vertex] >= 0 && nodes.owns(node))
            result[part.mesh_node[vertex]] = core::Vector3::Map(&displacement[3 * node]);
    sum_over_ranks(result);
    return result;
}

} // namespace livermark::fem_reference
