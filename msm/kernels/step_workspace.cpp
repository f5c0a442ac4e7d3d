#include "msm/kernels/step_workspace.hpp"

#include <algorithm>
#include <set>

#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/layout/slicing.hpp"

namespace livermark::msm {

namespace {

/// Cuts what has the given running costs into parts of about equal cost.
std::vector<Partition> partitions(const std::vector<int> &running_cost, int num_threads) {
    std::vector<Partition> parts(num_threads);
    const int total = running_cost.empty() ? 0 : running_cost.back();
    const auto cut = [&](int part) {
        const auto wanted = static_cast<int>(static_cast<long>(total) * part / num_threads);
        return static_cast<int>(std::ranges::lower_bound(running_cost, wanted) - running_cost.begin());
    };
    for (int thread = 0; thread < num_threads; ++thread)
        parts[thread] = {cut(thread), cut(thread + 1)};
    parts.front().first = 0;
    parts.back().last = std::max(static_cast<int>(running_cost.size()) - 1, 0);
    return parts;
}

/// The pairs of slices of a thread, those last that read rows of other threads. The forces of tetrahedra have barriers
/// of their own, and all nodes may be read by the fans of others.
template <class T> PairPartition partition_of_pairs(const SlicedBody<T> &body, const Partition &part) {
    PairPartition result;
    for (int pair = part.first; pair < part.last; ++pair)
        result.order.push_back(pair);
    if (!body.rest_volume.empty() || body.spring_lines.empty())
        return result;
    constexpr int line_size = 64 / sizeof(T);
    std::set<int> ghost;
    const auto is_interior = [&](int pair) {
        bool is = true;
        const auto &lines = body.spring_lines[pair];
        const auto first = body.neighbour.begin() + static_cast<std::ptrdiff_t>(lines.first_neighbour) * slice_size;
        const auto last = first + static_cast<std::ptrdiff_t>(lines.count.total()) * slice_size;
        for (auto index = first; index != last; ++index) {
            const int other = *index / 4 / pair_size;
            if (2 * other >= body.num_slices || (other >= part.first && other < part.last))
                continue;
            ghost.insert(*index / line_size * line_size);
            is = false;
        }
        return is;
    };
    const auto first_shared = std::stable_partition(result.order.begin(), result.order.end(), is_interior);
    result.num_interior = static_cast<std::size_t>(first_shared - result.order.begin());
    result.ghost.index.assign(ghost.begin(), ghost.end());
    for (auto pair = first_shared; pair != result.order.end(); ++pair)
        for (int index = 0; index < 4 * pair_size; index += line_size)
            result.shared.index.push_back(4 * pair_size * *pair + index);
    for (auto *lines : {&result.ghost, &result.shared})
        lines->at_once = lines->index.size() / std::max<std::size_t>(1, result.num_interior / 2) + 1;
    return result;
}

/// Cost of moving the pairs of slices before each one: to fetch a line of neighbours takes about as long as the
/// forces of a line of springs, and where there are no springs, nodes cost what it takes to collect the forces of
/// tetrahedra.
template <class T> std::vector<int> running_cost_of_pairs(const SlicedBody<T> &body) {
    std::vector<int> cost;
    if (!body.spring_lines.empty())
        cost.push_back(0);
    for (const auto &lines : body.spring_lines)
        cost.push_back(cost.back() + lines.count.total() + lines.count.num_springs());
    if (cost.empty())
        for (int slice = 0; slice <= body.num_slices; slice += 2)
            cost.push_back(body.sum_start[slice]);
    return cost;
}

/// Running cost of things that cost the same.
std::vector<int> running_count(int count) {
    std::vector<int> cost;
    for (int i = 0; i <= count; ++i)
        cost.push_back(i);
    return cost;
}

/// Gives each thread its part of the work on a body, of about the same cost.
/// @param workspace    with its body
/// @param num_threads  >= 1
template <class T> void partition_work(StepWorkspace<T> &workspace, int num_threads) {
    const auto &body = workspace.body;
    for (const auto &part : partitions(running_cost_of_pairs(body), num_threads))
        workspace.pairs.push_back(partition_of_pairs(body, part));
    workspace.fan_slices = partitions(body.fan_start, num_threads);
    workspace.chunks = partitions(running_count(static_cast<int>(body.chunk_start.size()) - 1), num_threads);
    workspace.edge_slices = partitions(body.edge_start, num_threads);
    workspace.volume_slices = partitions(body.mean_start.empty() ? body.volume_start : body.mean_start, num_threads);
}

/// Place where springs end that only fill up a slice: so far from any body that they have a length [m].
constexpr float far_away = 1e4F;

template <class V> std::size_t bytes(const V &values) {
    return values.size() * sizeof(typename V::value_type);
}

template <class T> std::size_t num_deficits(const SlicedBody<T> &body) {
    return body.fan_start.size() - 1 + body.volume_row.size() / slice_size + body.edge_modulus.size() / slice_size;
}

template <class T> Aligned<T> moved_rows(const RowMap &map, const Aligned<T> &rows) {
    Aligned<T> moved(4 * (static_cast<std::size_t>(map.num_rows) + 1), T(0));
    std::copy_n(rows.begin(), 4 * static_cast<std::ptrdiff_t>(map.first_copy_before), moved.begin());
    for (std::size_t c = 0; c < map.copy.size(); ++c)
        std::copy_n(rows.begin() + 4 * (map.first_copy_before + static_cast<std::ptrdiff_t>(c)), 4,
                    moved.begin() + 4 * (map.first_copy + std::ptrdiff_t{map.copy[c]}));
    std::copy(rows.end() - 4, rows.end(), moved.end() - 4); // the far one
    return moved;
}

/// For what volumes and strains are around nodes, and for the forces of tetrahedra; or more where the body has become
/// larger. What is new is zero, and so is what stands behind the last.
template <class T> void make_room_for_means(StepWorkspace<T> &at) {
    const auto &body = at.body;
    const bool is_damped = at.beta != 0.0;
    const bool has_gradients = body.has_volumes_in_fans(), has_gains = has_gradients || body.is_around_edges();
    if (body.coupled_modulus.empty() || has_gradients)
        at.gain.resize(body.corner.size() + slice_size, T(0));
    else if (body.inverse_volume.empty())
        at.strain.resize(8 * (body.rest_volume.size() + 1), T(0));
    else
        for (auto &values : at.corner_strain)
            values.resize(4 * (body.corner.size() + slice_size), T(0));
    // Dashpots inside tetrahedra alone would read these, and branches there.
    if (has_gradients && !is_damped && at.relaxation.empty()) {
        at.body.rest_gradient = {};
        at.body.inner_modulus = {};
    }
    if (!body.inverse_volume.empty())
        at.push.resize(body.rest_volume.size(), T(0));
    if (is_damped && has_gains)
        at.gain_rate.resize(at.gain.size(), T(0));
    if (body.is_around_edges()) {
        at.change.resize(body.volume_row.size(), T(0));
        at.change_rate.resize(is_damped ? body.volume_row.size() : 0, T(0));
        at.mean_push.resize(at.change.size(), T(0));
        const auto row = static_cast<std::size_t>(long_row(body.measure));
        at.tetrahedron_strain.resize(row * (body.rest_volume.size() + 1), T(0));
        at.tetrahedron_rate.resize(is_damped ? at.tetrahedron_strain.size() : 0, T(0));
        at.edge_stress.resize(row * body.edge_modulus.size(), T(0));
    }
    if (is_damped && !body.inverse_volume.empty())
        for (std::size_t i = 0; i < at.corner_rate.size(); ++i)
            at.corner_rate[i].resize(at.corner_strain[i].size(), T(0));
    if (!body.coupled_modulus.empty() && !has_gradients)
        for (auto &rows : at.stress)
            rows.resize(4 * static_cast<std::size_t>(body.num_rows + 1), T(0));
    const auto end_of_chunks = static_cast<std::size_t>(body.chunk_start.back());
    const auto num_places =
        has_gradients ? body.first_pull + body.mean_node.size() + body.volume_row.size() : end_of_chunks + 1;
    at.corner_force.resize(4 * num_places, T(0));
    std::fill_n(at.corner_force.begin() + 4 * static_cast<std::ptrdiff_t>(end_of_chunks), 4, T(0));
}

/// For what some partings add, so that none of it has to move then.
template <class T> void leave_room(StepWorkspace<T> &at) {
    auto &body = at.body;
    for (auto *values : {&body.spring,
                         &body.rest_volume,
                         &body.volume_share,
                         &body.tetrahedron_stiffness,
                         &body.least_volume,
                         &body.guard_stiffness,
                         &body.watched_volume,
                         &body.rest_gradient,
                         &body.rest_length,
                         &body.inner_modulus,
                         &body.volume_modulus,
                         &body.coupled_modulus,
                         &body.inverse_volume,
                         &body.mean_gradient,
                         &body.edge_modulus,
                         &body.inverse_edge_volume,
                         &body.mean_weight,
                         &body.volume_stiffness,
                         &at.gain,
                         &at.gain_rate,
                         &at.strain,
                         &at.corner_strain[0],
                         &at.corner_strain[1],
                         &at.corner_rate[0],
                         &at.corner_rate[1],
                         &at.push,
                         &at.tetrahedron_strain,
                         &at.tetrahedron_rate,
                         &at.edge_stress,
                         &at.corner_force})
        values->reserve(with_room(values->size()));
    for (auto *indices : {&body.neighbour, &body.corner, &body.force_slot, &body.mean_node, &body.edge_member,
                          &body.fan_edge, &body.mean_volume, &body.member})
        indices->reserve(with_room(indices->size()));
}

StepFunctions<float> coupled_steps(const EnergyFunctions &energy, const SlicedBody<float> &body, bool is_damped) {
    return energy.steps(body, is_damped);
}
StepFunctions<double> coupled_steps(const EnergyFunctions &energy, const SlicedBody<double> &body, bool is_damped) {
    return energy.double_steps ? energy.double_steps(body, is_damped) : StepFunctions<double>{}; // take_steps() refuses
}

} // namespace

template <class T>
StepWorkspace<T> make_workspace(const StepParts &parts, const std::vector<core::Vector3> &at_rest,
                                const StepScheme &scheme, const core::RayleighDamping &damping, double time_step,
                                const FastStepOptions &options, std::size_t num_branches, int num_threads,
                                SlicedPlan &plan) {
    StepWorkspace<T> at;
    at.body = sliced_body<T>(parts, at_rest, options.may_be_cut || num_branches > 0 ? &plan : nullptr);
    if (num_branches > 0)
        at.relaxation = relaxation_arrays(parts, plan, at.body, num_branches);
    at.scheme = scheme;
    at.scheme.largest_speed = options.largest_speed;
    at.time_step = time_step;
    at.alpha = damping.alpha;
    at.beta = damping.beta;
    at.least_stretch = options.least_stretch;
    if (!at.body.watched_volume.empty())
        at.deficit.assign(num_deficits(at.body), T(0));
    if (parts.kernels)
        at.coupled = coupled_steps(parts.kernels(), at.body, damping.beta != 0.0);
    at.nodes.resize(at.body.num_slices);
    if (scheme.kind == StepScheme::Kind::runge_kutta_chebyshev)
        at.chebyshev_stages.resize(at.body.num_slices);
    else if (scheme.kind != StepScheme::Kind::symplectic_euler)
        at.stages.resize(at.body.num_slices);
    for (auto &rows : at.rows)
        rows.assign(4 * static_cast<std::size_t>(at.body.num_rows + 1), T(0));
    if (damping.beta != 0.0)
        at.velocity_rows = at.rows;
    for (auto &rows : at.rows)
        std::fill(rows.end() - 4, rows.end(), static_cast<T>(far_away));
    make_room_for_means(at);
    if (options.may_be_cut)
        leave_room(at);
    partition_work(at, num_threads);
    return at;
}

template <class T> void make_room_after_parting(const RowMap &map, int num_threads, StepWorkspace<T> &at) {
    at.nodes.resize(static_cast<std::size_t>(at.body.num_slices));
    if (!at.loads.empty())
        at.loads.resize(at.nodes.size(), {});
    if (!at.stages.empty())
        at.stages.resize(at.nodes.size());
    if (!at.chebyshev_stages.empty())
        at.chebyshev_stages.resize(at.nodes.size());
    if (!map.is_identity())
        for (auto *both : {&at.rows, &at.velocity_rows})
            for (auto &rows : *both)
                if (!rows.empty())
                    rows = moved_rows(map, rows);
    if (!at.deficit.empty()) {
        const bool is_pressed = std::ranges::any_of(at.deficit, [](T deficit) { return deficit > T(0); });
        at.deficit.assign(num_deficits(at.body), T(0));
        at.deficit.front() = is_pressed ? T(1) : T(0);
    }
    make_room_for_means(at);
    at.pairs.clear();
    partition_work(at, num_threads);
}

template <class T> std::size_t working_set(const StepWorkspace<T> &at) {
    const auto &body = at.body;
    return bytes(body.neighbour) + bytes(body.spring) + bytes(body.spring_lines) + bytes(body.corner) +
           bytes(body.force_slot) + bytes(body.sum) + bytes(body.rest_volume) + bytes(body.volume_share) +
           bytes(body.tetrahedron_stiffness) + bytes(body.least_volume) + bytes(body.guard_stiffness) +
           bytes(body.member) + bytes(body.volume_stiffness) + bytes(at.nodes) + bytes(at.loads) + bytes(at.stages) +
           bytes(at.chebyshev_stages) + 2 * bytes(at.rows[0]) + 2 * bytes(at.velocity_rows[0]) + bytes(at.gain) +
           bytes(at.corner_force) + bytes(body.rest_gradient) + bytes(body.rest_length) + bytes(body.inner_modulus) +
           bytes(body.coupled_modulus) + bytes(at.strain) + 2 * bytes(at.stress[0]) + bytes(body.inverse_volume) +
           2 * bytes(at.corner_strain[0]) + 2 * bytes(at.corner_rate[0]) + bytes(at.gain_rate) + bytes(at.push) +
           bytes(body.volume_modulus) + bytes(body.mean_node) + bytes(body.mean_gradient) + bytes(body.edge_member) +
           bytes(body.fan_edge) + 2 * bytes(body.edge_modulus) + bytes(at.tetrahedron_strain) +
           bytes(at.tetrahedron_rate) + bytes(at.edge_stress) + bytes(body.mean_volume) + bytes(body.mean_weight) +
           bytes(at.change) + bytes(at.change_rate) + bytes(at.mean_push) + bytes(at.relaxation.means.faded) +
           bytes(at.relaxation.tetrahedra.faded);
}

template void make_room_after_parting(const RowMap &, int, StepWorkspace<float> &);
template void make_room_after_parting(const RowMap &, int, StepWorkspace<double> &);
template std::size_t working_set(const StepWorkspace<float> &);
template std::size_t working_set(const StepWorkspace<double> &);
template StepWorkspace<float> make_workspace(const StepParts &, const std::vector<core::Vector3> &, const StepScheme &,
                                             const core::RayleighDamping &, double, const FastStepOptions &,
                                             std::size_t, int, SlicedPlan &);
template StepWorkspace<double> make_workspace(const StepParts &, const std::vector<core::Vector3> &, const StepScheme &,
                                              const core::RayleighDamping &, double, const FastStepOptions &,
                                              std::size_t, int, SlicedPlan &);

} // namespace livermark::msm
