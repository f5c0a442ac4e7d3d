#include "msm/springs/mean_parts.hpp"

#include <array>
#include <map>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::msm {

namespace {

/// What is shared between the tetrahedra of a kind of parts: nodes, edges, or nothing.
class PartsOfOneKind {
  public:
    PartsOfOneKind(const core::Body &body, double weight, int first_part)
        : body_(body), weight_(weight), first_part_(first_part) {}

    /// @param places  numbers of the nodes or edges of the tetrahedron, each with an equal share
    void add(int tetrahedron, std::span<const int> places, double volume) {
        for (const int place : places) {
            const int region = body_.mesh.region[tetrahedron];
            const auto [at, is_new] = number_.try_emplace({place, region}, static_cast<int>(volume_.size()));
            if (is_new) {
                volume_.push_back(0.0);
                region_.push_back(region);
            }
            volume_[at->second] += volume / static_cast<double>(places.size());
            part_.push_back(at->second);
        }
    }

    int part(int tetrahedron, int place, int num_places) const { return part_[tetrahedron * num_places + place]; }

    void append_to(MeanParts &parts) const {
        for (std::size_t c = 0; c < volume_.size(); ++c) {
            parts.volume.push_back(weight_ * volume_[c]);
            parts.modulus.push_back(body_.materials[region_[c]].shear_modulus());
        }
    }

    int first_part() const { return first_part_; }
    double weight() const { return weight_; }
    double volume_of(int part) const { return volume_[part]; }

  private:
    const core::Body &body_;
    double weight_;
    int first_part_;
    std::map<std::pair<int, int>, int> number_; // of each place and region
    std::vector<double> volume_;
    std::vector<int> region_, part_;
};

} // namespace

MeanParts mean_parts(const core::Body &body, const StrainDomains &domains) {
    const auto &mesh = body.mesh;
    const auto volumes = core::tetrahedron_volumes(mesh);
    MeanParts parts;
    struct Kind {
        PartsOfOneKind parts;
        int num_places;
    };
    std::vector<Kind> kinds;
    const auto add_kind = [&](double weight, int num_places, const auto &places_of) {
        if (weight == 0.0)
            return;
        PartsOfOneKind kind(body, weight, parts.num_parts());
        for (int t = 0; t < mesh.num_tetrahedra(); ++t)
            kind.add(t, places_of(t), volumes[t]);
        kind.append_to(parts);
        kinds.push_back({std::move(kind), num_places});
    };
    add_kind(domains.nodes, 4, [&](int t) { return std::span<const int>(mesh.tetrahedra[t]); });
    const auto edges = domains.edges > 0.0 ? core::edge_table(mesh.tetrahedra) : core::EdgeTable{};
    add_kind(domains.edges, 6, [&](int t) { return std::span<const int>(edges.tetrahedron_edge[t]); });
    std::array<int, 1> itself{};
    add_kind(domains.tetrahedra, 1, [&](int t) {
        itself[0] = t;
        return std::span<const int>(itself);
    });
    parts.start.push_back(0);
    for (int t = 0; t < mesh.num_tetrahedra(); ++t) {
        for (const auto &[kind, num_places] : kinds)
            for (int k = 0; k < num_places; ++k) {
                const int part = kind.part(t, k, num_places);
                parts.members.push_back({.part = kind.first_part() + part,
                                         .of_tetrahedron = kind.weight() / num_places,
                                         .in_mean = volumes[t] / (num_places * kind.volume_of(part))});
            }
        parts.start.push_back(static_cast<int>(parts.members.size()));
    }
    return parts;
}

} // namespace livermark::msm
