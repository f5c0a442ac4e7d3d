#include <map>

#include "meshes/generators/surface_mesh.hpp"

namespace livermark::meshes {

namespace {

/// The six tetrahedra of a cube around its diagonal 0-7; corner c lies at (c & 1, c >> 1 & 1, c >> 2 & 1).
constexpr std::array<std::array<int, 4>, 6> cube_tetrahedra{
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

class Marcher {
  public:
    Marcher(const LevelFunction &level, const core::Vector3 &low, const core::Vector3 &high, double spacing)
        : low_(low), spacing_(spacing) {
        for (int d = 0; d < 3; ++d)
            count_[d] = static_cast<int>((high[d] - low[d]) / spacing) + 2;
        levels_.reserve(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2]);
        for (int k = 0; k < count_[2]; ++k)
            for (int j = 0; j < count_[1]; ++j)
                for (int i = 0; i < count_[0]; ++i)
                    levels_.push_back(level(position(number(i, j, k))));
    }

    SurfaceMesh run() {
        for (int k = 0; k + 1 < count_[2]; ++k)
            for (int j = 0; j + 1 < count_[1]; ++j)
                for (int i = 0; i + 1 < count_[0]; ++i)
                    for (const auto &corners : cube_tetrahedra) {
                        std::array<int, 4> nodes;
                        for (int c = 0; c < 4; ++c)
                            nodes[c] = number(i + (corners[c] & 1), j + (corners[c] >> 1 & 1), k + (corners[c] >> 2));
                        cut(nodes);
                    }
        return std::move(surface_);
    }

  private:
    int number(int i, int j, int k) const { return (k * count_[1] + j) * count_[0] + i; }

    core::Vector3 position(int n) const {
        const int row = n / count_[0];
        const int layer = row / count_[1];
        return low_ + spacing_ * core::Vector3(n % count_[0], row % count_[1], layer);
    }

    /// The node where the surface crosses a grid edge, made at its first use.
    int crossing(int inside, int outside) {
        const auto [entry, is_new] =
            crossings_.try_emplace({inside, outside}, static_cast<int>(surface_.points.size()));
        if (is_new) {
            const double t = levels_[inside] / (levels_[inside] - levels_[outside]);
            surface_.points.push_back(position(inside) + t * (position(outside) - position(inside)));
        }
        return entry->second;
    }

    void cut(const std::array<int, 4> &nodes) {
        std::vector<int> in;
        std::vector<int> out;
        for (const int node : nodes)
            (levels_[node] < 0.0 ? in : out).push_back(node);
        if (in.empty() || out.empty())
            return;
        const core::Vector3 outward = position(out[0]) - position(in[0]);
        if (in.size() == 1)
            add(crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[0], out[2]), outward);
        else if (out.size() == 1)
            add(crossing(in[0], out[0]), crossing(in[1], out[0]), crossing(in[2], out[0]), outward);
        else {
            const std::array quad{crossing(in[0], out[0]), crossing(in[0], out[1]), crossing(in[1], out[1]),
                                  crossing(in[1], out[0])};
            add(quad[0], quad[1], quad[2], outward);
            add(quad[0], quad[2], quad[3], outward);
        }
    }

    void add(int a, int b, int c, const core::Vector3 &outward) {
        const auto &x = surface_.points;
        const bool is_right_handed = (x[b] - x[a]).cross(x[c] - x[a]).dot(outward) > 0.0;
        surface_.triangles.push_back(is_right_handed ? std::array{a, b, c} : std::array{a, c, b});
    }

    core::Vector3 low_;
    double spacing_;
    std::array<int, 3> count_;
    std::vector<double> levels_;
    std::map<std::array<int, 2>, int> crossings_;
    SurfaceMesh surface_;
};

} // namespace

SurfaceMesh march_tetrahedra(const LevelFunction &level, const core::Vector3 &low, const core::Vector3 &high,
                             double spacing) {
    return Marcher(level, low, high, spacing).run();
}

} // namespace livermark::meshes
