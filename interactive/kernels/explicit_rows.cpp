#include "interactive/kernels/explicit_rows.hpp"

#include <algorithm>
#include <boost/graph/adjacency_list.hpp>
#include <boost/graph/cuthill_mckee_ordering.hpp>
#include <utility>

#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/fans.hpp"

namespace livermark::interactive::kernels {

namespace {

/// Nodes or fans: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t node_window = 256, fan_window = 512;

constexpr std::size_t filled_up(std::size_t count) {
    return (count + slice_size - 1) / slice_size * slice_size;
}

/// The first ones stay near where they are.
template <class T, class Less> void sort_in_windows_of(std::size_t window, std::vector<T> &items, const Less &less) {
    for (std::size_t first = 0; first < items.size(); first += window)
        std::stable_sort(items.begin() + static_cast<std::ptrdiff_t>(first),
                         items.begin() + static_cast<std::ptrdiff_t>(std::min(first + window, items.size())), less);
}

/// How many fans have each node among their corners.
std::vector<int> corners_at_nodes(const std::vector<Fan> &fans, std::size_t num_nodes) {
    std::vector<int> count(num_nodes, 0);
    for (const auto &fan : fans) {
        for (const int node : fan.axis)
            ++count[node];
        for (const int node : fan.rim)
            ++count[node];
    }
    return count;
}

/// @return (N) nodes in their new order
std::vector<int> order_of_nodes(const std::vector<std::array<int, 4>> &tetrahedra, const std::vector<int> &num_slots) {
    using Properties = boost::property<boost::vertex_color_t, boost::default_color_type>;
    boost::adjacency_list<boost::vecS, boost::vecS, boost::undirectedS, Properties> graph(num_slots.size());
    for (const auto &[a, b] : core::edge_table(tetrahedra).edges)
        boost::add_edge(a, b, graph);
    std::vector<int> order(num_slots.size());
    boost::cuthill_mckee_ordering(graph, order.rbegin(), get(boost::vertex_color, graph),
                                  boost::make_degree_map(graph));
    sort_in_windows_of(node_window, order, [&](int a, int b) { return num_slots[a] > num_slots[b]; });
    return order;
}

/// The corners of fans at each row, in the order of fans.
using CornersOfRows = std::vector<std::vector<std::size_t>>;

class Builder {
  public:
    Builder(const Scene &scene, Pressure pressure)
        : scene_(&scene), tetrahedra_(tetrahedra_at_rest(*scene.body)),
          fans_(cut_into_fans(scene.body->mesh.tetrahedra)) {
        rows_.pressure = pressure;
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
    void place_nodes() {
        const std::size_t num_nodes = scene_->node_mass.size();
        const auto order = order_of_nodes(scene_->body->mesh.tetrahedra, corners_at_nodes(fans_, num_nodes));
        rows_.row_of_node.resize(num_nodes);
        for (std::size_t row = 0; row < num_nodes; ++row)
            rows_.row_of_node[order[row]] = static_cast<int>(row);
        rows_.num_rows = filled_up(num_nodes);
        for (auto *field : {&rows_.displacement, &rows_.velocity, &rows_.external, &rows_.inverse_mass})
            field->assign(4 * rows_.num_rows, 0.0F);
        const auto is_free = free_nodes(*scene_);
        for (std::size_t i = 0; i < num_nodes; ++i)
            if (is_free[i])
                std::fill_n(rows_.inverse_mass.begin() + 4 * static_cast<std::ptrdiff_t>(rows_.row_of_node[i]), 3,
                            static_cast<float>(1.0 / scene_->node_mass[i]));
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
            rows_.corner.resize(corner + (length + 3) * slice_size, 0);
            rows_.tetrahedra.resize((line + length) * numbers_of_tetrahedron * slice_size, 0.0F);
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                place_fan(fans_[first + lane], corner + lane, length, line, lane);
        }
    }

    void place_fan(const Fan &fan, std::size_t corner, std::size_t length, std::size_t line, std::size_t lane) {
        if (fan.tetrahedra.empty())
            return;
        const auto place = [&](int node, bool is_one) {
            rows_.corner[corner] = 4 * rows_.row_of_node[node];
            if (is_one)
                corners_[rows_.row_of_node[node]].push_back(corner);
            corner += slice_size;
        };
        for (const int node : fan.axis)
            place(node, true);
        for (std::size_t k = 0; k <= length; ++k)
            place(fan.rim[std::min(k, fan.rim.size() - 1)], k < fan.rim.size());
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
        put(t.volume * t.mu);
        put(rows_.pressure == Pressure::around_nodes ? 0.25 * t.volume : t.volume * t.lambda);
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
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<Fan> fans_;
    CornersOfRows corners_;
    ExplicitRows rows_;
};

template <class... Arrays> std::size_t bytes_of(const Arrays &...arrays) {
    return ((arrays.size() * sizeof(arrays[0])) + ...);
}

} // namespace

std::size_t ExplicitRows::bytes() const {
    return bytes_of(line_start, corner, slot, tetrahedra, slot_start, force, displacement, velocity, external,
                    inverse_mass, growth, growth_start, growth_at, inverse_volume, lambda);
}

ExplicitRows explicit_rows(const Scene &scene, Pressure pressure) {
    return Builder(scene, pressure).build();
}

} // namespace livermark::interactive::kernels
