#include "msm/cutting/cut_parts.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>
#include <utility>

#include "msm/springs/springs_with_volume.hpp"
#include "msm/springs/tetrahedron_volume.hpp"

namespace livermark::msm {

/// What some tetrahedra have numbers of, each ascending and once.
template <std::size_t n>
std::vector<int> CutParts::once(const std::vector<std::array<int, n>> &numbers, std::span<const int> tetrahedra) {
    std::vector<int> found;
    if (numbers.empty())
        return found;
    for (const int t : tetrahedra)
        for (const int number : numbers[t])
            if (is_seen_[number] == 0) {
                is_seen_[number] = 1;
                found.push_back(number);
            }
    for (const int number : found)
        is_seen_[number] = 0;
    std::ranges::sort(found);
    return found;
}

template std::vector<int> CutParts::once(const std::vector<std::array<int, 4>> &, std::span<const int>);
template std::vector<int> CutParts::once(const std::vector<std::array<int, 6>> &, std::span<const int>);

std::optional<CutParts> CutParts::prepare(const core::Body &body, const ElasticBody &elastic,
                                          std::optional<SpringSource> springs) {
    auto known = step_parts(elastic);
    if (!known)
        return std::nullopt;
    const auto &mesh = body.mesh;
    CutParts result;
    result.parts_ = std::move(*known);
    result.parts_.is_removed.assign(mesh.tetrahedra.size(), 0);
    result.node_mass_ = elastic.node_mass;
    result.source_ = std::move(springs);
    result.tetrahedra_ = mesh.tetrahedra;
    result.of_node_ = NumberLists(mesh.tetrahedra, mesh.points.size());
    const auto volumes = core::tetrahedron_volumes(mesh);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        result.mass_share_.push_back(body.materials[mesh.region[t]].density * volumes[t] / 4.0);
    if (!result.parts_.edges.empty()) {
        result.edges_ = core::edge_table(mesh.tetrahedra);
        result.of_spring_ = NumberLists(result.edges_.tetrahedron_edge, result.edges_.edges.size());
        result.spring_order_.resize(result.edges_.edges.size());
        std::iota(result.spring_order_.begin(), result.spring_order_.end(), 0);
        if (result.source_ && result.source_->law.of_tetrahedron)
            for (std::size_t t = 0; t < volumes.size(); ++t)
                result.of_edges_.push_back(result.source_->law.of_tetrahedron(result.source_->body, t));
    }
    const auto &parts = result.parts_;
    const auto x = to_unknowns(mesh.points);
    result.volume_.resize(static_cast<Eigen::Index>(mesh.tetrahedra.size()));
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        result.volume_[static_cast<Eigen::Index>(t)] = volume_gradient(x, mesh.tetrahedra[t]).volume;
    if (!parts.centre.empty()) {
        result.of_volume_ = NumberLists(parts.corner_volume, parts.centre.size());
        for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
            result.volume_modulus_.push_back(
                modulus_beside_springs(body.materials[mesh.region[result.of_volume_.of(c).front()]]));
    }
    for (auto *lists : {&result.of_node_, &result.of_spring_, &result.of_volume_})
        lists->leave_room();
    for (auto *edges : {&result.edges_.edges, &result.parts_.edges})
        edges->reserve(with_room(edges->size()));
    for (auto *values : {&result.parts_.stiffness, &result.parts_.rest_length, &result.parts_.edge_modulus})
        values->reserve(with_room(values->size()));
    result.is_seen_.assign(
        std::max({mesh.points.size(), parts.edges.size(), parts.centre.size(), parts.edge_modulus.size()}), 0);
    return result;
}

void CutParts::set_spring(int spring) {
    double stiffness = 0.0;
    for (const int t : of_spring_.of(spring))
        if (parts_.is_there(t)) {
            const auto &edges = edges_.tetrahedron_edge[t];
            stiffness += of_edges_[t][std::ranges::find(edges, spring) - edges.begin()];
        }
    parts_.stiffness[spring] = source_->factor * stiffness;
}

/// Of the body without what is gone; nodes keep their numbers.
std::vector<int> CutParts::ask_law_again() {
    auto body = source_->body;
    auto &mesh = body.mesh;
    core::EdgeTable table;
    std::vector<int> number(edges_.edges.size(), -1);
    mesh.tetrahedra.clear();
    mesh.region.clear();
    for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
        if (parts_.is_there(t)) {
            mesh.tetrahedra.push_back(tetrahedra_[t]);
            mesh.region.push_back(source_->body.mesh.region[t]);
            for (const int edge : table.tetrahedron_edge.emplace_back(edges_.tetrahedron_edge[t]))
                number[edge] = 0;
        }
    for (const int s : spring_order_)
        if (number[s] == 0) {
            number[s] = static_cast<int>(table.edges.size());
            table.edges.push_back(edges_.edges[s]);
        }
    for (auto &edges : table.tetrahedron_edge)
        for (int &edge : edges)
            edge = number[edge];
    const auto stiffness = source_->law.stiffness(body, table);
    for (std::size_t s = 0; s < number.size(); ++s)
        parts_.stiffness[s] = number[s] < 0 ? 0.0 : source_->factor * stiffness[number[s]];
    std::vector<int> all(number.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

void CutParts::set_mass(int node) {
    node_mass_[node] = 0.0;
    for (const int t : of_node_.of(node))
        if (parts_.is_there(t))
            node_mass_[node] += mass_share_[t];
}

/// As VolumePenalty does, a product with few rows.
void CutParts::set_volumes(std::span<const int> volumes) {
    Eigen::SparseMatrix<double, Eigen::RowMajor> share(static_cast<Eigen::Index>(volumes.size()), volume_.size());
    Eigen::Index row_of_share = 0;
    for (const int volume : volumes) {
        share.startVec(row_of_share);
        for (const int t : of_volume_.of(volume))
            if (parts_.is_there(t))
                share.insertBack(row_of_share, t) = 0.25;
        ++row_of_share;
    }
    share.finalize();
    const Eigen::VectorXd rest = share * volume_;
    for (std::size_t row = 0; row < volumes.size(); ++row) {
        const double volume = rest[static_cast<Eigen::Index>(row)];
        parts_.volume_stiffness[volumes[row]] = volume > 0.0 ? volume_modulus_[volumes[row]] / volume : 0.0;
    }
}

const CutChanges &CutParts::remove(std::span<const int> tetrahedra) {
    changes_ = {};
    changes_.tetrahedra.assign(tetrahedra.begin(), tetrahedra.end());
    std::ranges::sort(changes_.tetrahedra);
    for (const int t : changes_.tetrahedra)
        parts_.is_removed[t] = 1;
    changes_.nodes = once(tetrahedra_, changes_.tetrahedra);
    changes_.springs = once(edges_.tetrahedron_edge, changes_.tetrahedra);
    if (!parts_.centre.empty())
        changes_.volumes = once(parts_.corner_volume, changes_.tetrahedra);
    changes_.edge_parts = once(parts_.edge_part, changes_.tetrahedra);
    for (const int node : changes_.nodes)
        set_mass(node);
    if (!of_edges_.empty())
        for (const int s : changes_.springs)
            set_spring(s);
    else if (source_)
        changes_.springs = ask_law_again();
    if (!parts_.volume_stiffness.empty())
        set_volumes(changes_.volumes);
    return changes_;
}

} // namespace livermark::msm
