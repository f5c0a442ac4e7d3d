#include "msm/kernels/relaxation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>
#include <utility>

namespace livermark::msm {

namespace {

/// 1 - exp(-time / tau)
double faded_part(double time, double tau) {
    return std::isinf(tau) ? 0.0 : -std::expm1(-time / tau);
}

double largest_move(const core::PronySeries &series, double time) {
    double move = 0.0;
    for (std::size_t b = 0; b < series.moduli.size(); ++b)
        move += series.moduli[b] * faded_part(time, series.times[b]);
    return move;
}

} // namespace

int steps_between_turns(const core::PronySeries &series, double largest_error, double time_step) {
    constexpr int most = 1 << 20;
    const auto is_too_many = [&](int m) { return largest_move(series, m * time_step) > largest_error; };
    int enough = 1, too_many = most + 1;
    while (too_many - enough > 1) {
        const int middle = enough + (too_many - enough) / 2;
        (is_too_many(middle) ? too_many : enough) = middle;
    }
    return enough;
}

RelaxationClock::RelaxationClock(core::PronySeries series, double largest_error, double time_step, bool is_staggered)
    : series_(std::move(series)), largest_error_(largest_error), is_staggered_(is_staggered) {
    set_time_step(time_step);
}

void RelaxationClock::set_time_step(double time_step) {
    time_step_ = time_step;
    num_steps_ = steps_between_turns(series_, largest_error_, time_step);
    steps_left_ = 0;
}

std::vector<double> RelaxationClock::shares_after(double time) const {
    std::vector<double> shares;
    for (const double tau : series_.times)
        shares.push_back(faded_part(std::max(time, 0.0), tau));
    return shares;
}

RelaxationShares RelaxationClock::turn() {
    steps_left_ = num_steps_;
    if (moves_in_every_step()) {
        RelaxationShares shares{.share = shares_after(time_step_), .gain = {}, .takes_former = true};
        for (const auto &branch : core::branch_steps(series_, time_step_)) {
            shares.gain.push_back(branch.gain);
            shares.at_once += branch.modulus - branch.gain;
        }
        return shares;
    }
    // From the middle of the steps before to the middle of the next ones.
    const double half = 0.5 * num_steps_ * time_step_, time = std::max(half - ahead_, 0.0);
    ahead_ += time;
    return {.share = shares_after(time), .gain = series_.moduli, .back = is_staggered_ ? 0.5 * time_step_ : 0.0};
}

RelaxationShares RelaxationClock::stay(double time) {
    steps_left_ = 0;
    ahead_ = 0.0;
    RelaxationShares shares{.share = shares_after(time), .gain = series_.moduli};
    if (moves_in_every_step())
        std::ranges::transform(core::branch_steps(series_, time_step_), shares.gain.begin(), &core::BranchStep::gain);
    return shares;
}

void RelaxationClock::count(int steps) {
    steps_left_ -= steps;
    if (!moves_in_every_step())
        ahead_ -= steps * time_step_;
}

namespace {

template <class T> RelaxingStresses<T> relaxing_stresses(std::size_t size, std::size_t num_branches, bool has_faded) {
    RelaxingStresses<T> stresses{.size = size, .high = {}, .low = {}, .faded = {}};
    stresses.high.assign(num_branches * size, T(0));
    if constexpr (std::is_same_v<T, float>)
        stresses.low = stresses.high;
    if (has_faded)
        stresses.faded.assign(size, T(0));
    return stresses;
}

template <class T> void set_to_zero(RelaxingStresses<T> &stresses) {
    for (auto *values : {&stresses.high, &stresses.low, &stresses.faded})
        std::ranges::fill(*values, T(0));
}

/// Stiffness of a pair of nodes that tetrahedra pull, where it stands.
template <class T> T &stiffness_of(SlicedBody<T> &body, std::size_t pair) {
    const std::size_t lane = pair % slice_size;
    return body.mean_gradient[4 * (pair - lane) + 3 * slice_size + lane];
}

/// Place of half the tension at no length of a spring.
std::size_t place_of_rest(std::size_t spring) {
    return 2 * spring - spring % slice_size + slice_size;
}

/// Place of a tetrahedron in its fan.
struct PlaceInFan {
    std::size_t place;         ///< on the lines
    std::array<int, 4> corner; ///< indices of the start and the end of the axis, and of both nodes of the rim
};

template <class T> PlaceInFan place_in_fan(const SlicedBody<T> &body, int place) {
    const int line = place / slice_size, lane = place % slice_size;
    const auto behind = std::ranges::upper_bound(body.fan_start, line);
    const auto slice = static_cast<int>(behind - body.fan_start.begin()) - 1;
    const int first = (body.fan_start[slice] + 3 * slice) * slice_size + lane, rim = line - body.fan_start[slice] + 2;
    const auto corner = [&](int k) { return *(body.corner.begin() + first + k * slice_size); };
    return {static_cast<std::size_t>(place), {corner(0), corner(1), corner(rim), corner(rim + 1)}};
}

/// Place of the pull between two corners of a tetrahedron.
int place_of_pull(std::size_t place, std::size_t one, std::size_t other) {
    constexpr std::array<std::array<int, 4>, 4> edge{{{-1, 0, 1, 2}, {0, -1, 3, 5}, {1, 3, -1, 4}, {2, 5, 4, -1}}};
    const std::size_t lane = place % slice_size;
    return static_cast<int>(6 * (place - lane) + lane) + edge[one][other] * slice_size;
}

/// Which line of a control volume has that neighbour, as an index into SlicedBody::mean_node.
template <class T> std::size_t place_of_neighbour(const SlicedBody<T> &body, int volume, int node) {
    const int lane = volume % slice_size, index = 4 * body.row_of_node[node];
    int at = body.mean_start[volume / slice_size] * slice_size + lane;
    while (body.mean_node[static_cast<std::size_t>(at)] != index)
        at += slice_size;
    return static_cast<std::size_t>(at);
}

/// Which pulls of tetrahedra add up to each stiffness between nodes.
template <class T>
std::vector<std::vector<int>> pulls_of_pairs(const StepParts &parts, const SlicedPlan &plan,
                                             const SlicedBody<T> &body) {
    std::vector<std::vector<int>> pulls(body.mean_node.size());
    for (std::size_t t = 0; t < parts.tetrahedra.size(); ++t) {
        const auto [place, corner] = place_in_fan(body, plan.tetrahedron_place[t]);
        std::array<int, 4> volume{};
        std::array<std::size_t, 4> in_fan{};
        for (std::size_t i = 0; i < 4; ++i) {
            volume[i] = plan.number_of_volume[parts.corner_volume[t][i]];
            in_fan[i] = std::ranges::find(corner, 4 * body.volume_row[volume[i]]) - corner.begin();
        }
        for (std::size_t e = 0; e < 6; ++e) {
            const auto [i, j] = core::tetrahedron_edges[e];
            const int pull = place_of_pull(place, in_fan[i], in_fan[j]);
            pulls[place_of_neighbour(body, volume[i], parts.tetrahedra[t][j])].push_back(pull);
            pulls[place_of_neighbour(body, volume[j], parts.tetrahedra[t][i])].push_back(pull);
        }
    }
    return pulls;
}

} // namespace

template <class T>
RelaxationArrays<T> relaxation_arrays(const StepParts &parts, const SlicedPlan &plan, SlicedBody<T> &body,
                                      std::size_t num_branches) {
    RelaxationArrays<T> arrays;
    arrays.springs = relaxing_stresses<T>(body.spring.size() / 2, num_branches, false);
    for (std::size_t at = 0; at < arrays.springs.size; ++at)
        arrays.rest_tension.push_back(body.spring[place_of_rest(at)]);
    if (parts.inner_modulus.empty())
        return arrays;
    const std::size_t num_means = body.is_around_edges() ? body.edge_modulus.size() : body.volume_row.size();
    arrays.means = relaxing_stresses<T>(6 * num_means, num_branches, true);
    const bool has_pairs = !body.mean_gradient.empty();
    arrays.tetrahedra = relaxing_stresses<T>(6 * body.rest_volume.size(), num_branches, !has_pairs);
    if (!has_pairs)
        return arrays;
    arrays.pull.assign(arrays.tetrahedra.size, T(0));
    arrays.pull_start.assign(1, 0);
    for (const auto &pulls : pulls_of_pairs(parts, plan, body)) {
        arrays.rest_stiffness.push_back(stiffness_of(body, arrays.pull_start.size() - 1));
        arrays.pull_place.insert(arrays.pull_place.end(), pulls.begin(), pulls.end());
        arrays.pull_start.push_back(static_cast<int>(arrays.pull_place.size()));
    }
    return arrays;
}

template <class T> void forget(RelaxationArrays<T> &arrays, SlicedBody<T> &body) {
    for (auto *stresses : {&arrays.springs, &arrays.means, &arrays.tetrahedra})
        set_to_zero(*stresses);
    for (std::size_t at = 0; at < arrays.springs.size; ++at)
        body.spring[place_of_rest(at)] = arrays.rest_tension[at];
    for (std::size_t pair = 0; pair < arrays.rest_stiffness.size(); ++pair)
        stiffness_of(body, pair) = arrays.rest_stiffness[pair];
}

template void forget(RelaxationArrays<float> &, SlicedBody<float> &);
template void forget(RelaxationArrays<double> &, SlicedBody<double> &);
template RelaxationArrays<float> relaxation_arrays(const StepParts &, const SlicedPlan &, SlicedBody<float> &,
                                                   std::size_t);
template RelaxationArrays<double> relaxation_arrays(const StepParts &, const SlicedPlan &, SlicedBody<double> &,
                                                    std::size_t);

} // namespace livermark::msm
