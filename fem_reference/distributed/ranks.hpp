#pragma once

#include <exception>
#include <span>
#include <stdexcept>
#include <vector>

#include "fem_reference/distributed/node_exchange.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::fem_reference {

/// What action() returns. If it throws on one rank of several, the others cannot know, and would wait for ever: it says
/// why and ends them all. std::invalid_argument is for what all ranks find wrong alike, and goes on.
template <class Action> auto on_all_ranks(const Action &action) {
    try {
        return action();
    } catch (const std::invalid_argument &) {
        throw;
    } catch (const std::exception &error) {
        if (support::mpi_num_ranks() == 1)
            throw;
        support::abort_all_ranks(error.what());
    }
}

/// Collective.
/// @param constraint  shape (3 n) of the part, index of the constraint of each unknown, -1 where free
/// @param force       shape (3 n)
/// @return shape (P) sums over the unknowns of all ranks
std::vector<core::Vector3> sum_of_reactions(const NodeExchange &nodes, std::span<const int> constraint,
                                            std::span<const double> force, std::size_t num_constraints);

/// Collective.
/// @param displacement  shape (3 n) of the part
/// @return shape (N) at the nodes of the mesh that was cut, on every rank
std::vector<core::Vector3> on_mesh(const Part &part, const ElasticSystem &system, const NodeExchange &nodes,
                                   std::span<const double> displacement);

} // namespace livermark::fem_reference
