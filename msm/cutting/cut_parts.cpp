#include "msm/cutting/cut_parts.hpp"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cstddef>
#include <map>
#include <numeric>
#include <utility>

#include "msm/dynamics/time_step.hpp"
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
    result.node_lists_ = NumberLists(mesh.tetrahedra, mesh.points.size());
    const auto volumes = core::tetrahedron_volumes(mesh);
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
    for (auto *lists : {&result.node_lists_, &result.spring_lists_, &result.volume_lists_})
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
    parts_.stiffness[spring] = source_->factor * stiffness;
}

/// Stiffness of the body without what is gone; nodes keep their numbers.
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
    for (const int t : node_lists_.of(node))
        if (parts_.is_there(t))
            node_mass_[node] += mass_share_[t];
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
    if (!edge_stiffness_.empty())
        for (const int s : changes_.springs)
            set_spring(s);
    else if (source_)
        changes_.springs = ask_law_again();
    if (!parts_.volume_stiffness.empty())
        set_volumes(changes_.volumes);
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
}

void CutParts::part_edges(const Parting &parting) {
    if (parts_.edge_modulus.empty())
        return;
    auto &changed = parted_.edge_parts;
    changed = once(parts_.edge_part, parting.tetrahedra);
    Successors<std::array<int, 2>> successors(parts_.edge_modulus.size());
    const auto first_new_node = static_cast<int>(node_mass_.size() - parting.parent_node.size());
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
        }
    }
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

PartOfBody part_of_body(const core::Body &body, const std::vector<char> &is_in, const NodalConditions &conditions) {
    const auto &mesh = body.mesh;
    PartOfBody part{.body = {.name = body.name, .mesh = {}, .materials = body.materials}, .node = {}, .conditions = {}};
    auto &mesh_of_part = part.body.mesh;
    mesh_of_part.region_names = mesh.region_names;
    std::vector<int> number(mesh.points.size(), -1);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        if (is_in[t] == 0)
            continue;
        for (const int node : mesh_of_part.tetrahedra.emplace_back(mesh.tetrahedra[t]))
            number[node] = 0;
        mesh_of_part.region.push_back(mesh.region[t]);
        if (!body.modulus_factor.empty())
            part.body.modulus_factor.push_back(body.modulus_factor[t]);
    }
    for (std::size_t i = 0; i < number.size(); ++i)
        if (number[i] == 0) {
            number[i] = mesh_of_part.num_nodes();
            part.node.push_back(static_cast<int>(i));
            mesh_of_part.points.push_back(mesh.points[i]);
            part.conditions.displacement.push_back(conditions.displacement[i]);
            part.conditions.force.emplace_back(core::Vector3::Zero());
            part.conditions.constraint.push_back({-1, -1, -1});
        }
    for (auto &tetrahedron : mesh_of_part.tetrahedra)
        for (int &node : tetrahedron)
            node = number[node];
    return part;
}

namespace {

/// Rings of tetrahedra with nodes that move, and rings around these that their springs and means have to know.
constexpr int moving_rings = 2, known_rings = 3;

/// Marks the nodes of the tetrahedra that are left at marked nodes as well.
void add_ring(const core::TetraMesh &mesh, const std::vector<char> &is_removed, std::vector<char> &marked) {
    const auto before = marked;
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        if (is_removed[t] == 0 && (before[a] != 0 || before[b] != 0 || before[c] != 0 || before[d] != 0))
            for (const int node : mesh.tetrahedra[t])
                marked[node] = 1;
    }
}

} // namespace

double frequency_around(const core::Body &body, const std::vector<char> &is_removed, std::span<const int> nodes,
                        const std::function<ElasticBody(const core::Body &)> &make, const NodalConditions &conditions,
                        double tolerance) {
    const auto &mesh = body.mesh;
    std::vector<char> moves(mesh.points.size(), 0);
    for (const int node : nodes)
        moves[node] = 1;
    for (int ring = 0; ring < moving_rings; ++ring)
        add_ring(mesh, is_removed, moves);
    auto is_known = moves;
    for (int ring = 1; ring < known_rings; ++ring)
        add_ring(mesh, is_removed, is_known);
    std::vector<char> is_in(mesh.tetrahedra.size(), 0);
    for (std::size_t t = 0; t < mesh.tetrahedra.size(); ++t) {
        const auto &[a, b, c, d] = mesh.tetrahedra[t];
        is_in[t] = is_removed[t] == 0 && (is_known[a] != 0 || is_known[b] != 0 || is_known[c] != 0 || is_known[d] != 0);
    }
    auto part = part_of_body(body, is_in, conditions);
    if (part.node.empty())
        return 0.0;
    for (std::size_t i = 0; i < part.node.size(); ++i)
        if (moves[part.node[i]] == 0)
            part.conditions.displacement[i].setZero();
    return largest_angular_frequency(make(part.body), part.body.mesh.points, part.conditions, {}, tolerance);
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
