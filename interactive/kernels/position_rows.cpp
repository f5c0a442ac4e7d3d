#include "interactive/kernels/position_rows.hpp"

#include <algorithm>

namespace livermark::interactive::kernels {

namespace {

/// What fills up: finite wherever it is.
std::vector<double> numbers_of_nothing(Constraint kind) {
    std::vector<double> numbers(num_numbers_of(kind), 0.0);
    if (kind == Constraint::distance)
        numbers[0] = numbers[3] = 1.0; // of some length
    for (std::size_t k = 0; k < num_multipliers_of(kind); ++k)
        numbers[numbers.size() - 1 - k] = 1.0; // compliances
    return numbers;
}

} // namespace

PositionRows::PositionRows(const Scene &scene) {
    const std::size_t num_nodes = scene.node_mass.size();
    // Whole slices of four, with one row that no node has.
    const std::size_t num_rows = (num_nodes + nodes_at_once) / nodes_at_once * nodes_at_once;
    for (auto *field : {&displacement, &before, &velocity, &external, &inverse_mass})
        field->assign(4 * num_rows, 0.0F);
    const auto is_free = free_nodes(scene);
    for (std::size_t i = 0; i < num_nodes; ++i)
        if (is_free[i])
            std::fill_n(inverse_mass.begin() + 4 * static_cast<std::ptrdiff_t>(i), 3,
                        static_cast<float>(1.0 / scene.node_mass[i]));
}

std::size_t PositionRows::bytes() const {
    std::size_t bytes = bytes_of(displacement, before, velocity, external, inverse_mass);
    for (const auto &set : sets)
        bytes += bytes_of(set.corner, set.numbers, set.multipliers);
    return bytes;
}

ConstraintRows constraint_rows(Constraint kind, const std::vector<int> &offsets, const std::vector<int> &nodes,
                               const std::vector<double> &numbers, int num_nodes) {
    ConstraintRows rows;
    rows.kind = kind;
    std::size_t num_batches = 0;
    for (std::size_t colour = 0; colour + 1 < offsets.size(); ++colour) {
        const auto begin = static_cast<std::size_t>(offsets[colour]),
                   end = static_cast<std::size_t>(offsets[colour + 1]);
        for (std::size_t k = begin; k < end; ++k)
            rows.place.push_back(slice_size * num_batches + (k - begin));
        num_batches += filled_up(end - begin) / slice_size;
    }
    const std::size_t n = num_nodes_of(kind), m = num_numbers_of(kind);
    rows.corner.assign(n * slice_size * num_batches, 4 * num_nodes);
    rows.numbers.resize(m * slice_size * num_batches);
    rows.multipliers.assign(num_multipliers_of(kind) * slice_size * num_batches, 0.0F);
    const auto nothing = numbers_of_nothing(kind);
    for (std::size_t at = 0; at < rows.numbers.size(); ++at)
        rows.numbers[at] = static_cast<float>(nothing[at / slice_size % m]);
    for (std::size_t k = 0; k < rows.place.size(); ++k) {
        const std::size_t batch = rows.place[k] / slice_size, lane = rows.place[k] % slice_size;
        for (std::size_t a = 0; a < n; ++a)
            rows.corner[(batch * n + a) * slice_size + lane] = 4 * nodes[k * n + a];
        for (std::size_t a = 0; a < m; ++a)
            rows.numbers[(batch * m + a) * slice_size + lane] = static_cast<float>(numbers[k * m + a]);
    }
    return rows;
}

} // namespace livermark::interactive::kernels
