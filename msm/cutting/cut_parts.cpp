#include "msm/cutting/cut_parts.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

#include "core/capsule.hpp"
#include "msm/springs/springs.hpp"
#include "msm/springs/tetrahedron.hpp"

namespace livermark::msm {

/// Numbers that some tetrahedra have, ascending and once.
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

namespace {

/// Stiffness that a covered facet adds to each of its edges [N/m].
double stiffness_of_facet(const core::Capsule &capsule) {
    core::Body facet{.name = {}, .mesh = {}, .materials = {}, .capsule = capsule};
    facet.mesh.boundary_triangles = {{0, 1, 2}};
    facet.mesh.boundary_patch = {0};
    facet.mesh.patch_names = {"surface"};
    return core::capsule_springs(facet, {.edges = {{0, 1}, {0, 2}, {1, 2}}, .tetrahedron_edge = {}}).front();
}

} // namespace

std::optional<CutParts> CutParts::prepare(const core::Body &body, const ElasticBody &elastic,
                                          std::optional<SpringSource> springs) {
    auto known = step_parts(part_terms(elastic).in_kernels);
    if (!known)
        return std::nullopt;
    const auto &mesh = body.mesh;
    CutParts result;
    result.parts_ = std::move(*known);
    result.parts_.is_removed.assign(mesh.tetrahedra.size(), 0);
    result.node_mass_ = elastic.node_mass;
    result.source_ = std::move(springs);
    result.tetrahedra_ = mesh.tetrahedra;
    result.node_lists_ = NumberLists(mesh.tetrahedra, mesh.points.size());
    const auto volumes = core::tetrahedron_volumes(mesh);
    if (!body.modulus_factor.empty()) {
        result.modulus_factor_ = body.modulus_factor;
        result.volume_in_means_ = volumes;
    }
    for (std::size_t t = 0; t < volumes.size(); ++t)
        result.mass_share_.push_back(body.materials[mesh.region[t]].density * volumes[t] / 4.0);
    if (!result.parts_.edges.empty()) {
        result.edges_ = core::edge_table(mesh.tetrahedra);
        result.spring_lists_ = NumberLists(result.edges_.tetrahedron_edge, result.edges_.edges.size());
        result.spring_order_.resize(result.edges_.edges.size());
        std::iota(result.spring_order_.begin(), result.spring_order_.end(), 0);
        if (result.source_ && result.source_->law.edge_stiffness)
            for (std::size_t t = 0; t < volumes.size(); ++t)
                result.edge_stiffness_.push_back(result.source_->law.edge_stiffness(result.source_->body, t));
        if (body.capsule) {
            result.stiffness_of_facet_ = stiffness_of_facet(*body.capsule);
            result.is_covered_.assign(mesh.tetrahedra.size(), {});
            for (const auto &[tetrahedron, corners, facet] : covered_faces(body))
                result.is_covered_[tetrahedron][6 - corners[0] - corners[1] - corners[2]] = true;
        }
    }
    const auto &parts = result.parts_;
    const auto x = to_unknowns(mesh.points);
    result.volume_.resize(static_cast<Eigen::Index>(mesh.tetrahedra.size()));
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t)
        result.volume_[static_cast<Eigen::Index>(t)] = volume_gradient(x, mesh.tetrahedra[t]).volume;
    if (!parts.centre.empty()) {
        result.volume_lists_ = NumberLists(parts.corner_volume, parts.centre.size());
        for (int c = 0; c < static_cast<int>(parts.centre.size()); ++c)
            result.volume_modulus_.push_back(
                modulus_beside_springs(body.materials[mesh.region[result.volume_lists_.of(c).front()]]));
    }
    if (!parts.edge_modulus.empty() && !parts.tetrahedron_modulus.empty())
        result.edge_part_lists_ = NumberLists(parts.edge_part, parts.edge_modulus.size());
    for (auto *lists : {&result.node_lists_, &result.spring_lists_, &result.volume_lists_, &result.edge_part_lists_})
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
    for (const int t : spring_lists_.of(spring))
        if (parts_.is_there(t)) {
            const auto &edges = edges_.tetrahedron_edge[t];
            stiffness += edge_stiffness_[t][std::ranges::find(edges, spring) - edges.begin()];
        }
    parts_.stiffness[spring] = source_->factor * stiffness + capsule_spring(spring);
}

/// Stiffness that the capsule adds to a spring [N/m].
double CutParts::capsule_spring(int spring) const {
    double stiffness = 0.0;
    if (is_covered_.empty())
        return stiffness;
    for (const int t : spring_lists_.of(spring))
        if (parts_.is_there(t)) {
            const auto &edges = edges_.tetrahedron_edge[t];
            const auto &ends = core::tetrahedron_edges[std::ranges::find(edges, spring) - edges.begin()];
            for (int opposite = 0; opposite < 4; ++opposite)
                if (is_covered_[t][opposite] && opposite != ends[0] && opposite != ends[1])
                    stiffness += stiffness_of_facet_;
        }
    return stiffness;
}

/// Stiffness of the body without what is gone; nodes keep their numbers.
std::vector<int> CutParts::ask_law_again() {
    auto body = source_->body;
    auto &mesh = body.mesh;
    core::EdgeTable table;
    std::vector<int> number(edges_.edges.size(), -1);
    mesh.tetrahedra.clear();
    mesh.region.clear();
    body.modulus_factor.clear();
    for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
        if (parts_.is_there(t)) {
            if (!modulus_factor_.empty())
                body.modulus_factor.push_back(modulus_factor_[t]);
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
        parts_.stiffness[s] =
            number[s] < 0 ? 0.0 : source_->factor * stiffness[number[s]] + capsule_spring(static_cast<int>(s));
    std::vector<int> all(number.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
}

void CutParts::set_mass(int node) {
    node_mass_[node] = 0.0;
    for (const int t : node_lists_.of(node))
        if (parts_.is_there(t))
            node_mass_[node] += mass_share_[t];
}

/// Mean of values of tetrahedra, of those that are left, by the volume that they have in a part of the body.
/// @param num_places  parts of a tetrahedron, of equal volume, one of which is in this part of the body
double CutParts::mean_over(std::span<const int> tetrahedra, std::span<const double> values, int num_places) const {
    double volume = 0.0, sum = 0.0;
    for (const int t : tetrahedra)
        if (parts_.is_there(t)) {
            const double share = volume_in_means_[t] / static_cast<double>(num_places);
            volume += share;
            sum += share * values[t];
        }
    return volume > 0.0 ? sum / volume : 0.0;
}

/// Moduli of springs around nodes and edges, where each tetrahedron has its own.
void CutParts::set_moduli(std::span<const int> volumes, std::span<const int> edge_parts) {
    const auto &modulus = parts_.tetrahedron_modulus;
    if (modulus.empty())
        return;
    if (!parts_.coupled_modulus.empty())
        for (const int c : volumes)
            parts_.coupled_modulus[c] = parts_.part_of_means * mean_over(volume_lists_.of(c), modulus, 4);
    for (const int e : edge_parts)
        parts_.edge_modulus[e] = parts_.part_of_means * mean_over(edge_part_lists_.of(e), modulus, 6);
}

/// As VolumePenalty does, a product with few rows.
void CutParts::set_volumes(std::span<const int> volumes) {
    Eigen::SparseMatrix<double, Eigen::RowMajor> share(static_cast<Eigen::Index>(volumes.size()), volume_.size());
    Eigen::Index row_of_share = 0;
    for (const int volume : volumes) {
        share.startVec(row_of_share);
        for (const int t : volume_lists_.of(volume))
            if (parts_.is_there(t))
                share.insertBack(row_of_share, t) = 0.25;
        ++row_of_share;
    }
    share.finalize();
    const Eigen::VectorXd rest = share * volume_;
    for (std::size_t row = 0; row < volumes.size(); ++row) {
        const double volume = rest[static_cast<Eigen::Index>(row)];
        double modulus = volume_modulus_[volumes[row]];
        if (!modulus_factor_.empty())
            modulus *= mean_over(volume_lists_.of(volumes[row]), modulus_factor_, 4);
        parts_.volume_stiffness[volumes[row]] = volume > 0.0 ? modulus / volume : 0.0;
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
    if (!edge_stiffness_.empty())
        for (const int s : changes_.springs)
            set_spring(s);
    else if (source_)
        changes_.springs = ask_law_again();
    if (!parts_.volume_stiffness.empty())
        set_volumes(changes_.volumes);
    set_moduli(changes_.volumes, changes_.edge_parts);
    return changes_;
}

namespace {

/// New things that take over tetrahedra from things that were there: of each node or edge that a blade has made, and
/// of each thing before, one.
template <class Place> class Successors {
  public:
    explicit Successors(std::size_t count) : count_(count) {}

    /// @return the number of the new thing, and whether it was asked for before
    std::pair<int, bool> of(int before, const Place &place) {
        const auto [at, is_new] = number_.try_emplace({before, place}, static_cast<int>(count_ + number_.size()));
        return {at->second, is_new};
    }

  private:
    std::size_t count_;
    std::map<std::pair<int, Place>, int> number_;
};

void sort_and_leave_one(std::vector<int> &numbers) {
    std::ranges::sort(numbers);
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

} // namespace

void CutParts::part_nodes(const Parting &parting) {
    parted_.tetrahedra = parting.tetrahedra;
    parted_.parent_node = parting.parent_node;
    auto &nodes = parted_.nodes;
    nodes = parting.parent_node;
    NewLists added;
    const auto num_nodes = static_cast<int>(node_mass_.size());
    for (std::size_t k = 0; k < parting.parent_node.size(); ++k)
        nodes.push_back(num_nodes + static_cast<int>(k));
    sort_and_leave_one(nodes);
    for (std::size_t i = 0; i < parting.tetrahedra.size(); ++i) {
        const int t = parting.tetrahedra[i];
        tetrahedra_[t] = parting.nodes[i];
        if (!parts_.tetrahedra.empty())
            parts_.tetrahedra[t] = parting.nodes[i];
        for (const int node : parting.nodes[i])
            if (node >= num_nodes)
                added.add(node, t);
    }
    node_mass_.resize(node_mass_.size() + parting.parent_node.size(), 0.0);
    node_lists_.resize(node_mass_.size());
    added.put_into(node_lists_);
    for (const int node : nodes) {
        if (node < num_nodes)
            leave_owners(node, tetrahedra_, node_lists_);
        set_mass(node);
    }
    if (source_)
        for (const int parent : parting.parent_node) {
            auto &points = source_->body.mesh.points;
            points.push_back(core::Vector3(points[parent]));
        }
}

void CutParts::part_springs(const Parting &parting) {
    const std::size_t num_before = edges_.edges.size();
    parted_.first_new_spring = static_cast<int>(num_before);
    if (parts_.edges.empty())
        return;
    Successors<std::array<int, 2>> successors(num_before);
    NewLists added;
    for (const int t : parting.tetrahedra)
        for (std::size_t e = 0; e < 6; ++e) {
            const auto &[a, b] = core::tetrahedron_edges[e];
            const auto [low, high] = std::minmax(tetrahedra_[t][a], tetrahedra_[t][b]);
            const std::array edge{low, high};
            int &spring = edges_.tetrahedron_edge[t][e];
            if (edges_.edges[spring] == edge)
                continue;
            parted_.springs.push_back(spring);
            const auto [number, is_new] = successors.of(0, edge);
            if (is_new) {
                edges_.edges.push_back(edge);
                parts_.edges.push_back(edge);
                parts_.rest_length.push_back(double{parts_.rest_length[spring]});
                parts_.stiffness.push_back(0.0);
                parted_.springs.push_back(number);
            }
            spring = number;
            added.add(number, t);
        }
    sort_and_leave_one(parted_.springs);
    spring_lists_.resize(edges_.edges.size());
    added.put_into(spring_lists_);
    for (const int s : parted_.springs) {
        if (s < parted_.first_new_spring)
            leave_owners(s, edges_.tetrahedron_edge, spring_lists_);
        if (std::ranges::none_of(spring_lists_.of(s), [&](int t) { return parts_.is_there(t); }))
            parted_.gone_springs.push_back(s);
    }
    if (!edge_stiffness_.empty())
        for (const int s : parted_.springs)
            set_spring(s);
    else if (source_) {
        put_in_order(num_before);
        parted_.springs = ask_law_again();
    }
}

/// Springs from this one on among the others.
void CutParts::put_in_order(std::size_t first_new) {
    std::vector<int> added;
    for (std::size_t s = first_new; s < edges_.edges.size(); ++s)
        added.push_back(static_cast<int>(s));
    const auto edge_of = [&](int s) { return edges_.edges[s]; };
    std::ranges::sort(added, {}, edge_of);
    std::vector<int> order(edges_.edges.size());
    std::ranges::merge(spring_order_, added, order.begin(), {}, edge_of, edge_of);
    spring_order_ = std::move(order);
}

void CutParts::part_volumes(const Parting &parting) {
    if (parts_.centre.empty())
        return;
    auto &changed = parted_.volumes;
    changed = once(parts_.corner_volume, parting.tetrahedra);
    const auto num_before = static_cast<int>(parts_.centre.size());
    Successors<int> successors(parts_.centre.size());
    NewLists added;
    std::vector<int> lost;
    for (const int t : parting.tetrahedra)
        for (std::size_t k = 0; k < 4; ++k) {
            int &volume = parts_.corner_volume[t][k];
            const int node = tetrahedra_[t][k], before = volume;
            if (parts_.centre[before] == node)
                continue;
            const auto [number, is_new] = successors.of(before, node);
            if (is_new) {
                parts_.centre.push_back(node);
                volume_modulus_.push_back(double{volume_modulus_[before]});
                for (auto *values : {&parts_.volume_stiffness, &parts_.coupled_modulus})
                    if (!values->empty())
                        values->push_back(double{(*values)[before]});
                changed.push_back(number);
                lost.push_back(number);
            }
            lost.push_back(before);
            volume = number;
            added.add(number, t);
        }
    volume_lists_.resize(parts_.centre.size());
    added.put_into(volume_lists_);
    sort_and_leave_one(changed);
    sort_and_leave_one(lost);
    for (const int c : lost)
        if (c < num_before)
            leave_owners(c, parts_.corner_volume, volume_lists_);
    if (!parts_.volume_stiffness.empty())
        set_volumes(lost);
    set_moduli(lost, {});
}

void CutParts::part_edges(const Parting &parting) {
    if (parts_.edge_modulus.empty())
        return;
    auto &changed = parted_.edge_parts;
    changed = once(parts_.edge_part, parting.tetrahedra);
    Successors<std::array<int, 2>> successors(parts_.edge_modulus.size());
    const auto first_new_node = static_cast<int>(node_mass_.size() - parting.parent_node.size());
    const auto num_before = static_cast<int>(parts_.edge_modulus.size());
    NewLists added;
    for (const int t : parting.tetrahedra) {
        for (std::size_t e = 0; e < 6; ++e) {
            const auto &[a, b] = core::tetrahedron_edges[e];
            const auto [low, high] = std::minmax(tetrahedra_[t][a], tetrahedra_[t][b]);
            if (high < first_new_node)
                continue;
            int &part = parts_.edge_part[t][e];
            const auto [number, is_new] = successors.of(part, std::array{low, high});
            if (is_new) {
                parts_.edge_modulus.push_back(double{parts_.edge_modulus[part]});
                changed.push_back(number);
            }
            part = number;
            if (number >= num_before)
                added.add(number, t);
        }
    }
    if (edge_part_lists_.size() == 0)
        return;
    edge_part_lists_.resize(parts_.edge_modulus.size());
    added.put_into(edge_part_lists_);
    for (const int edge : changed)
        if (edge < num_before)
            leave_owners(edge, parts_.edge_part, edge_part_lists_);
    set_moduli({}, changed);
}

const PartingChanges &CutParts::part(const Parting &parting) {
    parted_ = {};
    part_nodes(parting);
    part_springs(parting);
    part_volumes(parting);
    part_edges(parting);
    is_seen_.resize(
        std::max({node_mass_.size(), parts_.edges.size(), parts_.centre.size(), parts_.edge_modulus.size()}), 0);
    return parted_;
}

KeptNumbers::KeptNumbers(const core::TetraMesh &mesh)
    : tetrahedra_(mesh.tetrahedra), node_(mesh.points.size()), tetrahedron_(mesh.tetrahedra.size()),
      num_nodes_(mesh.num_nodes()) {
    std::iota(node_.begin(), node_.end(), 0);
    std::iota(tetrahedron_.begin(), tetrahedron_.end(), 0);
}

FacetCut KeptNumbers::follow(const core::TetraMesh &after, const std::vector<int> &parent_tetrahedron) {
    FacetCut cut;
    std::vector<int> left, parent(after.points.size(), -1);
    std::size_t next = 0;
    for (std::size_t t = 0; t < tetrahedron_.size(); ++t) {
        if (next == parent_tetrahedron.size() || parent_tetrahedron[next] != static_cast<int>(t)) {
            cut.removed.push_back(tetrahedron_[t]);
            continue;
        }
        left.push_back(tetrahedron_[t]);
        for (std::size_t k = 0; k < 4; ++k)
            parent[after.tetrahedra[next][k]] = tetrahedra_[tetrahedron_[t]][k];
        ++next;
    }
    std::vector<char> is_taken(static_cast<std::size_t>(num_nodes_), 0);
    node_.resize(after.points.size());
    for (std::size_t i = 0; i < node_.size(); ++i) {
        if (is_taken[parent[i]] == 0) {
            is_taken[parent[i]] = 1;
            node_[i] = parent[i];
            continue;
        }
        node_[i] = num_nodes_++;
        cut.parting.parent_node.push_back(parent[i]);
    }
    tetrahedron_ = std::move(left);
    for (std::size_t t = 0; t < tetrahedron_.size(); ++t) {
        std::array<int, 4> nodes{};
        for (std::size_t k = 0; k < 4; ++k)
            nodes[k] = node_[after.tetrahedra[t][k]];
        if (nodes == tetrahedra_[tetrahedron_[t]])
            continue;
        tetrahedra_[tetrahedron_[t]] = nodes;
        cut.parting.tetrahedra.push_back(tetrahedron_[t]);
        cut.parting.nodes.push_back(nodes);
    }
    return cut;
}

} // namespace livermark::msm
