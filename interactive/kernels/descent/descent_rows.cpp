#include "interactive/kernels/descent/descent_rows.hpp"

#include <algorithm>
#include <utility>

#include "interactive/elements/tetrahedra.hpp"
#include "interactive/kernels/fans.hpp"

namespace livermark::interactive::kernels {

namespace {

/// Nodes of one colour: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t window_of_colour = 256;

class DescentBuilder {
  public:
    explicit DescentBuilder(const Scene &scene)
        : scene_(&scene), tetrahedra_(tetrahedra_at_rest(*scene.body)), is_free_(free_nodes(scene)),
          around_(scene.node_mass.size()), strips_(scene.node_mass.size()) {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            for (const int node : tetrahedra_[t].nodes)
                around_[node].push_back(static_cast<int>(t));
        if (scene.orders && scene.orders->strips.size() == strips_.size())
            strips_ = scene.orders->strips;
        for (std::size_t i = 0; i < strips_.size(); ++i)
            if (is_free_[i] && strips_[i].empty())
                strips_[i] = strips_around(static_cast<int>(i));
        laplacian_.assign(strips_.size(), 0.0);
    }

    DescentRows build(const Colouring &colours) {
        place_nodes(colours);
        rows_.line_start.assign(1, 0);
        for (std::size_t first = 0; first < node_in_row_.size(); first += slice_size)
            place_batch(first);
        for (auto *field : {&rows_.displacement, &rows_.before, &rows_.predicted, &rows_.velocity, &rows_.last_velocity,
                            &rows_.external, &rows_.older, &rows_.oldest})
            field->assign(4 * rows_.num_rows, 0.0F);
        rows_.strips = std::move(strips_);
        return std::move(rows_);
    }

  private:
    static constexpr int nobody = -1;

    /// The three nodes of a tetrahedron that are not this one.
    std::array<int, 3> opposite(int tetrahedron, int node) const {
        std::array<int, 3> facet{};
        std::size_t found = 0;
        for (const int other : tetrahedra_[tetrahedron].nodes)
            if (other != node)
                facet[found++] = other;
        return facet;
    }

    /// With numbers of tetrahedra as those of triangles.
    std::vector<StripNode> strips_around(int node) const {
        std::vector<std::array<int, 3>> facets;
        for (const int t : around_[node])
            facets.push_back(opposite(t, node));
        auto strips = cut_into_strips(facets);
        for (auto &entry : strips)
            if (entry.triangle >= 0)
                entry.triangle = around_[node][entry.triangle];
        return strips;
    }

    void place_nodes(const Colouring &colours) {
        for (int c = 0; c < colours.num_colours(); ++c) {
            std::vector<int> nodes;
            std::copy_if(colours.order.begin() + colours.offsets[c], colours.order.begin() + colours.offsets[c + 1],
                         std::back_inserter(nodes), [&](int node) { return is_free_[node]; });
            sort_in_windows_of(window_of_colour, nodes,
                               [&](int a, int b) { return strips_[a].size() > strips_[b].size(); });
            node_in_row_.insert(node_in_row_.end(), nodes.begin(), nodes.end());
            node_in_row_.resize(filled_up(node_in_row_.size()), nobody);
        }
        rows_.row_of_node.resize(is_free_.size());
        for (std::size_t row = 0; row < node_in_row_.size(); ++row)
            if (node_in_row_[row] != nobody)
                rows_.row_of_node[node_in_row_[row]] = static_cast<int>(row);
        rows_.num_rows = node_in_row_.size();
        for (std::size_t i = 0; i < is_free_.size(); ++i)
            if (!is_free_[i])
                rows_.row_of_node[i] = static_cast<int>(rows_.num_rows++);
        rows_.num_rows = filled_up(rows_.num_rows);
        rows_.mass.assign(node_in_row_.size(), 1.0F);
        rows_.laplacian.assign(node_in_row_.size(), 0.0F);
    }

    void place_batch(std::size_t first) {
        std::size_t length = 0;
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                length = std::max(length, strips_[node_in_row_[row]].size());
        const std::size_t line = rows_.line_start.back();
        rows_.line_start.push_back(line + length);
        rows_.numbers.resize((line + length) * numbers_of_line * slice_size, 0.0F);
        for (std::size_t k = 0; k < length; ++k)
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                rows_.neighbour.push_back(static_cast<std::int32_t>(4 * (first + lane)));
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                place_node(row, line);
    }

    void place_node(std::size_t row, std::size_t line) {
        const int node = node_in_row_[row];
        rows_.mass[row] = static_cast<float>(scene_->node_mass[node]);
        find_laplacian(node);
        rows_.laplacian[row] = static_cast<float>(std::exchange(laplacian_[node], 0.0));
        const auto &points = scene_->body->mesh.points;
        std::array<int, 3> triangle{};
        for (const auto &[neighbour, tetrahedron, keeps_first] : strips_[node]) {
            rows_.neighbour[line * slice_size + row % slice_size] = 4 * rows_.row_of_node[neighbour];
            float *at = rows_.numbers.data() + line * numbers_of_line * slice_size + row % slice_size;
            const auto put = [&](double value) {
                *at = static_cast<float>(value);
                at += slice_size;
            };
            for (const double component : core::Vector3(points[neighbour] - points[node]))
                put(component);
            put(std::exchange(laplacian_[neighbour], 0.0));
            triangle = {keeps_first ? triangle[0] : triangle[1], triangle[2], neighbour};
            if (tetrahedron >= 0) {
                const auto &t = tetrahedra_[tetrahedron];
                put((keeps_first ? -1.0 : 1.0) * (t.lambda + t.mu) / (36.0 * t.volume));
                put(sign_of(node, triangle) * t.mu / 6.0);
            }
            ++line;
        }
    }

    double sign_of(int node, const std::array<int, 3> &triangle) const {
        const auto &points = scene_->body->mesh.points;
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = points[triangle[c]] - points[node];
        return edges.determinant() > 0.0 ? 1.0 : -1.0;
    }

    /// Adds to nothing a node's row of the Laplacian: sum of V mu g . g with itself and its neighbours.
    void find_laplacian(int node) {
        for (const int number : around_[node]) {
            const auto &t = tetrahedra_[number];
            const auto gradients = t.shape_gradients();
            const auto own = gradients.row(std::ranges::find(t.nodes, node) - t.nodes.begin());
            for (int c = 0; c < 4; ++c)
                laplacian_[t.nodes[c]] += t.volume * t.mu * gradients.row(c).dot(own);
        }
    }

    const Scene *scene_;
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<bool> is_free_;
    std::vector<std::vector<int>> around_;       ///< (N) tetrahedra
    std::vector<std::vector<StripNode>> strips_; ///< (N) none where constrained
    std::vector<int> node_in_row_;               ///< of the batches
    std::vector<double> laplacian_;              ///< (N) row of the node that is being placed; zero between nodes
    DescentRows rows_;
};

} // namespace

std::size_t DescentRows::bytes() const {
    return bytes_of(line_start, neighbour, numbers, mass, laplacian, displacement, before, predicted, velocity,
                    last_velocity, external, older, oldest);
}

DescentRows descent_rows(const Scene &scene, const Colouring &colours) {
    return DescentBuilder(scene).build(colours);
}

} // namespace livermark::interactive::kernels
