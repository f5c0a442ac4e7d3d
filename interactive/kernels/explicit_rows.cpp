#include "interactive/kernels/explicit_steps.hpp"

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/elements/quadratic_tetrahedra.hpp"
#include "interactive/kernels/fans.hpp"

namespace livermark::interactive::kernels {

namespace {

/// Fans: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t fan_window = 512;

/// The corners of fans at each row, in the order of fans, one row behind the other.
class CornersOfRows {
  public:
    /// @param num_corners  (rows)
    explicit CornersOfRows(const std::vector<int> &num_corners) : start_(num_corners.size() + 1, 0) {
        std::partial_sum(num_corners.begin(), num_corners.end(), start_.begin() + 1);
        corners_.resize(start_.back());
        end_.assign(start_.begin(), start_.end() - 1);
    }

    void add(std::size_t row, std::size_t corner) { corners_[end_[row]++] = corner; }
    std::size_t size() const { return end_.size(); }
    std::span<const std::size_t> operator[](std::size_t row) const {
        return std::span(corners_).subspan(start_[row], start_[row + 1] - start_[row]);
    }

  private:
    std::vector<std::size_t> start_, end_, corners_;
};

class Builder {
  public:
    Builder(const Scene &scene, Pressure pressure)
        : scene_(&scene), tetrahedra_(tetrahedra_at_rest(*scene.body)),
          has_orders_(scene.orders && scene.orders->fans.size() > 0) {
        if (has_orders_)
            rows_.fans = scene.orders->fans;
        else
            found_ = cut_into_fans(scene.body->mesh.tetrahedra);
        rows_.pressure = pressure;
        rows_.is_quadratic = !scene.own_nodes.empty();
        rows_.num_corners = scene.body->mesh.num_nodes();
        if (!rows_.is_quadratic)
            return;
        edges_ = core::edge_table(scene.body->mesh.tetrahedra).edges;
        first_edge_.assign(scene.body->mesh.points.size() + 1, 0);
        for (const auto &[low, high] : edges_)
            ++first_edge_[low + 1];
        std::partial_sum(first_edge_.begin(), first_edge_.end(), first_edge_.begin());
    }

    ExplicitRows build() {
        place_nodes();
        place_fans();
        place_slots();
        if (rows_.pressure == Pressure::around_nodes)
            place_pressures();
        return std::move(rows_);
    }

  private:
    /// Node in the middle of an edge, by its ends.
    int middle(int a, int b) const {
        const auto [low, high] = std::minmax(a, b);
        const auto edge = std::lower_bound(edges_.begin() + first_edge_[low], edges_.begin() + first_edge_[low + 1],
                                           std::array{low, high});
        return scene_->body->mesh.num_nodes() + static_cast<int>(edge - edges_.begin());
    }

    /// As FanLines says.
    const std::vector<int> &nodes_of_lines(std::size_t fan) {
        const auto [start, end] = rows_.fans.axis(fan);
        const auto rim = rows_.fans.rim(fan);
        auto &nodes = nodes_of_lines_;
        nodes = {start, end};
        if (rows_.is_quadratic)
            nodes.push_back(middle(start, end));
        for (std::size_t k = 0; k < rim.size(); ++k) {
            nodes.push_back(rim[k]);
            if (!rows_.is_quadratic)
                continue;
            nodes.push_back(middle(start, rim[k]));
            nodes.push_back(middle(end, rim[k]));
            if (k > 0)
                nodes.push_back(middle(rim[k - 1], rim[k]));
        }
        return nodes;
    }

    void place_nodes() {
        if (!has_orders_)
            list_fans();
        std::vector<int> num_slots(scene_->node_mass.size(), 0);
        for (std::size_t f = 0; f < rows_.fans.size(); ++f)
            for (const int node : nodes_of_lines(f))
                ++num_slots[node];
        const auto known = has_orders_ ? scene_->orders->rows : std::vector<int>();
        rows_.place(*scene_, known.size() == num_slots.size()
                                 ? known
                                 : order_of_nodes(scene_->body->mesh.tetrahedra, edges_, num_slots, known));
        std::vector<int> num_corners(rows_.num_rows, 0);
        for (std::size_t i = 0; i < num_slots.size(); ++i)
            num_corners[rows_.row_of_node[i]] = num_slots[i];
        corners_.emplace(num_corners);
    }

    void list_fans() {
        rows_.fans = {};
        rows_.fans.reserve(found_.size(), tetrahedra_.size());
        for (const auto &fan : found_)
            rows_.fans.add(fan.axis, fan.rim, fan.tetrahedra);
    }

    void sort_fans() {
        std::ranges::stable_sort(found_, {}, [&](const Fan &fan) {
            return std::minmax({rows_.row_of_node[fan.axis[0]], rows_.row_of_node[fan.axis[1]]});
        });
        sort_in_windows_of(fan_window, found_,
                           [](const Fan &a, const Fan &b) { return a.tetrahedra.size() > b.tetrahedra.size(); });
        list_fans();
    }

    void place_fans() {
        if (!has_orders_)
            sort_fans();
        const auto &fans = rows_.fans;
        rows_.line_start.assign(1, 0);
        for (std::size_t first = 0; first < fans.size(); first += slice_size) {
            const std::size_t last = std::min(first + slice_size, fans.size());
            std::size_t length = 0;
            for (std::size_t f = first; f < last; ++f)
                length = std::max(length, fans.tetrahedra(f).size());
            const std::size_t line = rows_.line_start.back(), corner = rows_.corner.size();
            rows_.line_start.push_back(line + length);
            const auto lines = rows_.lines();
            rows_.corner.resize(corner + (lines.per_tetrahedron * length + lines.per_fan) * slice_size, 0);
            rows_.tetrahedra.resize((line + length) * numbers_of_tetrahedron * slice_size, 0.0F);
            for (std::size_t f = first; f < last; ++f)
                place_fan(f, corner + f - first, length, line, f - first);
        }
    }

    void place_fan(std::size_t fan, std::size_t corner, std::size_t length, std::size_t line, std::size_t lane) {
        const auto &nodes = nodes_of_lines(fan);
        const std::size_t num_lines = rows_.lines().per_tetrahedron * length + rows_.lines().per_fan;
        for (std::size_t k = 0; k < num_lines; ++k, corner += slice_size) {
            const int row = rows_.row_of_node[nodes[std::min(k, nodes.size() - 1)]];
            rows_.corner[corner] = 4 * row;
            if (k < nodes.size())
                corners_->add(row, corner);
        }
        const auto rim = rows_.fans.rim(fan), numbers = rows_.fans.tetrahedra(fan);
        for (std::size_t k = 0; k < numbers.size(); ++k)
            place_tetrahedron(tetrahedra_[numbers[k]], {rows_.fans.axis(fan)[1], rim[k], rim[k + 1]},
                              rows_.tetrahedra.data() + (line + k) * numbers_of_tetrahedron * slice_size + lane);
    }

    void place_tetrahedron(const Tetrahedron &t, const std::array<int, 3> &nodes, float *at) const {
        const auto put = [&](double value) {
            *at = static_cast<float>(value);
            at += slice_size;
        };
        const auto gradients = t.shape_gradients();
        for (const int node : nodes)
            for (int j = 0; j < 3; ++j)
                put(gradients(std::ranges::find(t.nodes, node) - t.nodes.begin(), j));
        const double volume = rows_.is_quadratic ? t.volume / QuadraticTetrahedron::num_points : t.volume;
        put(volume * t.mu);
        put(rows_.pressure == Pressure::around_nodes ? 0.25 * volume : volume * t.lambda);
    }

    void place_slots() {
        rows_.slot_start.assign(1, 0);
        const auto &corners = *corners_;
        for (std::size_t first = 0; first < corners.size(); first += nodes_at_once) {
            std::size_t most = 0;
            for (std::size_t n = 0; n < nodes_at_once; ++n)
                most = std::max(most, corners[first + n].size());
            rows_.slot_start.push_back(rows_.slot_start.back() + most);
        }
        const std::size_t num_slots = nodes_at_once * rows_.slot_start.back();
        rows_.force.assign(4 * (num_slots + 1), 0.0F);
        rows_.slot.assign(rows_.corner.size(), static_cast<std::int32_t>(4 * num_slots));
        for (std::size_t row = 0; row < corners.size(); ++row)
            for (std::size_t k = 0; k < corners[row].size(); ++k) {
                const std::size_t four = rows_.slot_start[row / nodes_at_once] + k;
                rows_.slot[corners[row][k]] =
                    static_cast<std::int32_t>(4 * (nodes_at_once * four + row % nodes_at_once));
            }
    }

    void place_pressures() {
        const auto &corners = *corners_;
        rows_.growth.assign(rows_.corner.size() + 1, 0.0F);
        rows_.growth_start.assign(1, 0);
        for (std::size_t first = 0; first < rows_.num_rows; first += slice_size) {
            std::size_t most = 0;
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                most = std::max(most, corners[first + lane].size());
            const std::size_t at = slice_size * rows_.growth_start.back();
            rows_.growth_start.push_back(rows_.growth_start.back() + most);
            rows_.growth_at.resize(at + most * slice_size, static_cast<std::int32_t>(rows_.corner.size()));
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                for (std::size_t k = 0; k < corners[first + lane].size(); ++k)
                    rows_.growth_at[at + k * slice_size + lane] = static_cast<std::int32_t>(corners[first + lane][k]);
        }
        std::vector<double> volume(rows_.num_rows, 0.0), lambda = volume;
        for (const auto &t : tetrahedra_)
            for (const int node : t.nodes) {
                volume[rows_.row_of_node[node]] += 0.25 * t.volume;
                lambda[rows_.row_of_node[node]] += 0.25 * t.volume * t.lambda;
            }
        rows_.inverse_volume.assign(rows_.num_rows, 0.0F);
        rows_.lambda = rows_.inverse_volume;
        for (std::size_t row = 0; row < rows_.row_of_node.size(); ++row) {
            rows_.inverse_volume[row] = static_cast<float>(1.0 / volume[row]);
            rows_.lambda[row] = static_cast<float>(lambda[row] / volume[row]);
        }
    }

    const Scene *scene_;
    std::vector<std::array<int, 2>> edges_; ///< with a node in the middle
    std::vector<int> first_edge_;           ///< (N + 1) whose lower node each is
    std::vector<Tetrahedron> tetrahedra_;
    bool has_orders_;
    std::vector<Fan> found_;          ///< where the scene has no orders
    std::vector<int> nodes_of_lines_; ///< of the fan that was asked for last
    std::optional<CornersOfRows> corners_;
    ExplicitRows rows_;
};

} // namespace

std::size_t ExplicitRows::bytes() const {
    return NodeRows::bytes() + bytes_of(line_start, corner, slot, tetrahedra, slot_start, force, growth, growth_start,
                                        growth_at, inverse_volume, lambda);
}

Orders ExplicitRows::orders() const {
    Orders orders;
    orders.rows = order();
    if (is_quadratic)
        std::erase_if(orders.rows, [&](int node) { return node >= num_corners; });
    orders.fans = fans;
    return orders;
}

ExplicitRows explicit_rows(const Scene &scene, Pressure pressure) {
    return Builder(scene, pressure).build();
}

} // namespace livermark::interactive::kernels
