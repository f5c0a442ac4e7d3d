#include "interactive/kernels/explicit_rows.hpp"

#include <algorithm>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "interactive/elements/quadratic_tetrahedra.hpp"
#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/fans.hpp"
#include "interactive/kernels/windows.hpp"

namespace livermark::interactive::kernels {

namespace {

/// Fans: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t fan_window = 512;

/// The corners of fans at each row, in the order of fans.
using CornersOfRows = std::vector<std::vector<std::size_t>>;

class Builder {
  public:
    Builder(const Scene &scene, Pressure pressure)
        : scene_(&scene), tetrahedra_(tetrahedra_at_rest(*scene.body)),
          fans_(cut_into_fans(scene.body->mesh.tetrahedra)) {
        rows_.pressure = pressure;
        rows_.is_quadratic = !scene.own_nodes.empty();
        if (rows_.is_quadratic)
            edges_ = core::edge_table(scene.body->mesh.tetrahedra).edges;
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
    /// Of an edge, by its ends.
    int middle(int a, int b) const {
        const auto edge = std::ranges::lower_bound(edges_, std::array{std::min(a, b), std::max(a, b)});
        return scene_->body->mesh.num_nodes() + static_cast<int>(edge - edges_.begin());
    }

    /// As FanLines says.
    std::vector<int> nodes_of_lines(const Fan &fan) const {
        const auto [start, end] = fan.axis;
        std::vector<int> nodes{start, end};
        if (rows_.is_quadratic)
            nodes.push_back(middle(start, end));
        for (std::size_t k = 0; k < fan.rim.size(); ++k) {
            nodes.push_back(fan.rim[k]);
            if (!rows_.is_quadratic)
                continue;
            nodes.push_back(middle(start, fan.rim[k]));
            nodes.push_back(middle(end, fan.rim[k]));
            if (k > 0)
                nodes.push_back(middle(fan.rim[k - 1], fan.rim[k]));
        }
        return nodes;
    }

    void place_nodes() {
        std::vector<int> num_slots(scene_->node_mass.size(), 0);
        for (const auto &fan : fans_)
            for (const int node : nodes_of_lines(fan))
                ++num_slots[node];
        rows_.place(*scene_, order_of_nodes(scene_->body->mesh.tetrahedra, edges_, num_slots));
    }

    void place_fans() {
        std::ranges::stable_sort(fans_, {}, [&](const Fan &fan) {
            return std::minmax({rows_.row_of_node[fan.axis[0]], rows_.row_of_node[fan.axis[1]]});
        });
        sort_in_windows_of(fan_window, fans_,
                           [](const Fan &a, const Fan &b) { return a.tetrahedra.size() > b.tetrahedra.size(); });
        fans_.resize(filled_up(fans_.size()));
        corners_.resize(rows_.num_rows);
        rows_.line_start.assign(1, 0);
        for (std::size_t first = 0; first < fans_.size(); first += slice_size) {
            std::size_t length = 0;
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                length = std::max(length, fans_[first + lane].tetrahedra.size());
            const std::size_t line = rows_.line_start.back(), corner = rows_.corner.size();
            rows_.line_start.push_back(line + length);
            const auto lines = rows_.lines();
            rows_.corner.resize(corner + (lines.of_tetrahedron * length + lines.of_fan) * slice_size, 0);
            rows_.tetrahedra.resize((line + length) * numbers_of_tetrahedron * slice_size, 0.0F);
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                place_fan(fans_[first + lane], corner + lane, length, line, lane);
        }
    }

    void place_fan(const Fan &fan, std::size_t corner, std::size_t length, std::size_t line, std::size_t lane) {
        if (fan.tetrahedra.empty())
            return;
        const auto nodes = nodes_of_lines(fan);
        const std::size_t num_lines = rows_.lines().of_tetrahedron * length + rows_.lines().of_fan;
        for (std::size_t k = 0; k < num_lines; ++k, corner += slice_size) {
            const int row = rows_.row_of_node[nodes[std::min(k, nodes.size() - 1)]];
            rows_.corner[corner] = 4 * row;
            if (k < nodes.size())
                corners_[row].push_back(corner);
        }
        for (std::size_t k = 0; k < fan.tetrahedra.size(); ++k)
            place_tetrahedron(tetrahedra_[fan.tetrahedra[k]], {fan.axis[1], fan.rim[k], fan.rim[k + 1]},
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
        for (std::size_t first = 0; first < corners_.size(); first += nodes_at_once) {
            std::size_t most = 0;
            for (std::size_t n = 0; n < nodes_at_once; ++n)
                most = std::max(most, corners_[first + n].size());
            rows_.slot_start.push_back(rows_.slot_start.back() + most);
        }
        const std::size_t num_slots = nodes_at_once * rows_.slot_start.back();
        rows_.force.assign(4 * (num_slots + 1), 0.0F);
        rows_.slot.assign(rows_.corner.size(), static_cast<std::int32_t>(4 * num_slots));
        for (std::size_t row = 0; row < corners_.size(); ++row)
            for (std::size_t k = 0; k < corners_[row].size(); ++k) {
                const std::size_t four = rows_.slot_start[row / nodes_at_once] + k;
                rows_.slot[corners_[row][k]] =
                    static_cast<std::int32_t>(4 * (nodes_at_once * four + row % nodes_at_once));
            }
    }

    void place_pressures() {
        rows_.growth.assign(rows_.corner.size() + 1, 0.0F);
        rows_.growth_start.assign(1, 0);
        for (std::size_t first = 0; first < rows_.num_rows; first += slice_size) {
            std::size_t most = 0;
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                most = std::max(most, corners_[first + lane].size());
            const std::size_t at = slice_size * rows_.growth_start.back();
            rows_.growth_start.push_back(rows_.growth_start.back() + most);
            rows_.growth_at.resize(at + most * slice_size, static_cast<std::int32_t>(rows_.corner.size()));
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                for (std::size_t k = 0; k < corners_[first + lane].size(); ++k)
                    rows_.growth_at[at + k * slice_size + lane] = static_cast<std::int32_t>(corners_[first + lane][k]);
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
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<Fan> fans_;
    CornersOfRows corners_;
    ExplicitRows rows_;
};

} // namespace

std::size_t ExplicitRows::bytes() const {
    return NodeRows::bytes() + bytes_of(line_start, corner, slot, tetrahedra, slot_start, force, growth, growth_start,
                                        growth_at, inverse_volume, lambda);
}

ExplicitRows explicit_rows(const Scene &scene, Pressure pressure) {
    return Builder(scene, pressure).build();
}

} // namespace livermark::interactive::kernels
