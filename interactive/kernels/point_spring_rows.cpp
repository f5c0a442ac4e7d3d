#include "interactive/kernels/point_spring_rows.hpp"

#include <algorithm>
#include <map>

namespace livermark::interactive::kernels {

namespace {

class PointSpringBuilder {
  public:
    PointSpringBuilder(const Scene &scene, std::span<const PointSpring> springs, const NodeRows &nodes)
        : springs_(springs), rest_(rest_positions(scene)), row_of_node_(&nodes.row_of_node),
          num_slots_of_(nodes.num_rows, 0) {
        place_slots();
    }

    PointSpringRows build() {
        std::map<std::size_t, std::vector<const PointSpring *>> by_size;
        for (const auto &spring : springs_)
            by_size[spring.nodes.size()].push_back(&spring);
        for (const auto &[num_nodes, springs] : by_size)
            place_set(num_nodes, springs);
        return std::move(rows_);
    }

  private:
    std::size_t row_of(int node) const { return static_cast<std::size_t>((*row_of_node_)[node]); }

    void place_slots() {
        for (const auto &spring : springs_)
            for (const int node : spring.nodes)
                ++num_slots_of_[row_of(node)];
        rows_.slot_start.assign(1, 0);
        for (std::size_t first = 0; first < num_slots_of_.size(); first += nodes_at_once) {
            const auto *const four_rows = num_slots_of_.data() + first;
            rows_.slot_start.push_back(rows_.slot_start.back() +
                                       *std::max_element(four_rows, four_rows + nodes_at_once));
        }
        if (!springs_.empty())
            rows_.force.assign(4 * (num_slots() + 1), 0.0F);
        std::ranges::fill(num_slots_of_, 0);
    }

    std::size_t num_slots() const { return nodes_at_once * rows_.slot_start.back(); }

    /// Four times the next slot of a row.
    std::int32_t next_slot(std::size_t row) {
        const std::size_t four = rows_.slot_start[row / nodes_at_once] + num_slots_of_[row]++;
        return static_cast<std::int32_t>(4 * (nodes_at_once * four + row % nodes_at_once));
    }

    void place_set(std::size_t num_nodes, const std::vector<const PointSpring *> &springs) {
        auto &set = rows_.sets.emplace_back();
        set.num_nodes = num_nodes;
        const std::size_t num_lanes = filled_up(springs.size());
        set.corner.assign(num_nodes * num_lanes, 0);
        set.slot.assign(num_nodes * num_lanes, static_cast<std::int32_t>(4 * num_slots()));
        set.numbers.assign(set.num_numbers() * num_lanes, 0.0F);
        for (std::size_t lane = 0; lane < num_lanes; ++lane) {
            const std::size_t batch = lane / slice_size;
            const auto put = [&](auto &of, std::size_t per_batch, std::size_t k, auto value) {
                of[(batch * per_batch + k) * slice_size + lane % slice_size] = value;
            };
            const auto put_number = [&](std::size_t k, double value) {
                put(set.numbers, set.num_numbers(), k, static_cast<float>(value));
            };
            if (lane >= springs.size()) { // of some length
                put_number(num_nodes, 1.0);
                put_number(num_nodes + 3, 1.0);
                continue;
            }
            const auto &spring = *springs[lane];
            for (std::size_t a = 0; a < num_nodes; ++a) {
                const std::size_t row = row_of(spring.nodes[a]);
                put(set.corner, num_nodes, a, static_cast<std::int32_t>(4 * row));
                put(set.slot, num_nodes, a, next_slot(row));
                put_number(a, spring.weights[a]);
            }
            const core::Vector3 at_rest = spring.span(rest_);
            for (std::size_t c = 0; c < 3; ++c)
                put_number(num_nodes + c, at_rest[static_cast<Eigen::Index>(c)]);
            put_number(num_nodes + 3, spring.rest_length);
            put_number(num_nodes + 4, spring.stiffness);
        }
    }

    std::span<const PointSpring> springs_;
    Field rest_;
    const std::vector<int> *row_of_node_;
    std::vector<std::size_t> num_slots_of_; ///< (rows) that are given away
    PointSpringRows rows_;
};

} // namespace

std::size_t PointSpringRows::bytes() const {
    std::size_t bytes = bytes_of(force);
    for (const auto &set : sets)
        bytes += bytes_of(set.corner, set.slot, set.numbers);
    return bytes;
}

PointSpringRows point_spring_rows(const Scene &scene, std::span<const PointSpring> springs, const NodeRows &nodes) {
    return PointSpringBuilder(scene, springs, nodes).build();
}

} // namespace livermark::interactive::kernels
