#include "studies/experiments/experiments.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <utility>

#include "core/stopwatch.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"
#include "studies/models/motion/moving_method.hpp"

namespace livermark::studies {

namespace {

using core::Vector3;
using experiments::MarkerField;
using experiments::MarkerMotion;

constexpr double tau = 2.0 * std::numbers::pi;
/// Part of the frequency by which steps of second order may change it: (omega h)^2 / 12.
constexpr double step_error = 1e-3;
constexpr int num_corrections = 2; ///< of what holds a body, after the first guess

core::LoadCase with_held(core::LoadCase load_case, double factor) {
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.is_loaded(f))
            load_case.value[f] *= factor;
    return load_case;
}

/// One body of a ring-down, and what one model does to it.
class RingingBody {
  public:
    RingingBody(const core::Model &model, const experiments::RingDown &ring_down, double edge_length,
                std::span<const Vector3> positions)
        : model_(model), body_(std::make_shared<const core::Body>(ring_down.body(edge_length))),
          load_case_(ring_down.load_case(body_->mesh)), field_(body_->mesh, positions), nodes_(field_.nodes()),
          is_method_(models::has_free_motion(model.name)) {}

    bool takes_part() const {
        core::Problem problem{body_, load_case_};
        problem.load_case.release.emplace();
        return model_.takes_part_in(problem) && !model_.is_collective;
    }

    core::Solution held_by(double factor, const std::optional<core::Release> &release = std::nullopt) {
        auto load_case = with_held(load_case_, factor);
        load_case.release = release;
        if (!prepared_)
            prepared_ = model_.prepare(body_, nullptr);
        auto solution = prepared_->solve(std::span(&load_case, 1)).front();
        if (release && is_method_ && solution.status == core::SolutionStatus::ok)
            let_go_of_method(solution, load_case);
        return solution;
    }

    core::Release release(double interval, int num_steps, const core::RayleighDamping &damping) const {
        core::Release release{.num_steps = num_steps, .output_interval = interval, .damping = damping, .probes = {}};
        for (const int node : nodes_)
            release.probes.push_back({fmt::format("node {}", node), node});
        return release;
    }

    std::vector<Vector3> markers(const core::Solution &solution) const {
        return field_.at_points(solution.displacement);
    }

    /// Every so many records of a history.
    std::vector<Vector3> markers(const core::History &history, int stride) const {
        std::vector<Vector3> all, field(body_->mesh.points.size(), Vector3::Zero());
        for (std::size_t record = 0; record < history.time.size(); record += stride) {
            for (std::size_t q = 0; q < nodes_.size(); ++q)
                field[nodes_[q]] = history.displacement[record * nodes_.size() + q];
            const auto at_points = field_.at_points(field);
            all.insert(all.end(), at_points.begin(), at_points.end());
        }
        return all;
    }

    int tetrahedra() const { return body_->mesh.num_tetrahedra(); }

    /// Whether it knows damping of the mass alone.
    bool is_method() const { return is_method_; }

  private:
    /// The model of a method is its static solution alone.
    void let_go_of_method(core::Solution &solution, const core::LoadCase &load_case) const {
        solution.history = models::free_motion(model_.name, {body_, load_case}, solution.displacement);
        if (std::isnan(solution.history->diverged_at))
            return;
        solution.status = core::SolutionStatus::diverged;
        solution.message = fmt::format("the motion left all bounds at t = {:.3g} s", solution.history->diverged_at);
    }

    const core::Model &model_;
    std::shared_ptr<const core::Body> body_;
    core::LoadCase load_case_;
    MarkerField field_;
    std::vector<int> nodes_;
    bool is_method_;
    std::unique_ptr<core::PreparedModel> prepared_;
};

/// Factor of the place nearest to the target, along the line between the markers at two factors.
double nearest_factor(double factor_a, const std::vector<Vector3> &a, double factor_b, const std::vector<Vector3> &b,
                      std::span<const Vector3> target, std::span<const int> markers) {
    double along = 0.0, square = 0.0;
    for (const int k : markers) {
        const Vector3 way = b[k] - a[k];
        along += way.dot(target[k] - a[k]);
        square += way.squaredNorm();
    }
    return square > 0.0 ? factor_a + along / square * (factor_b - factor_a) : factor_b;
}

double distance_of(std::span<const Vector3> a, std::span<const Vector3> b, std::span<const int> markers) {
    double sum = 0.0;
    for (const int k : markers)
        sum += (a[k] - b[k]).squaredNorm();
    return std::sqrt(sum / static_cast<double>(markers.size()));
}

/// Numbers of a motion that was computed, as they are measured of a real body.
void describe(results::RingDownRun &run, const results::RingDownResult &measured, std::size_t num_markers,
              std::span<const int> markers) {
    const MarkerMotion motion{measured.interval, static_cast<int>(num_markers), run.displacement};
    const auto ringing = experiments::fit_ringing(motion, markers);
    run.frequency = ringing.frequency;
    run.damping_ratio = ringing.ratio;
    run.swings = experiments::swings(motion, markers, ringing.frequency, results::num_swings);
    double sum = 0.0;
    for (int n = 0; n < results::num_swings; ++n)
        sum += (run.swings[n] - measured.swings[n]) * (run.swings[n] - measured.swings[n]) / results::num_swings;
    run.swing_error = std::sqrt(sum);
    run.error = results::root_mean_square_distance(run.displacement, measured.displacement);
    run.start_error = distance_of(run.displacement, measured.displacement, markers);
}

} // namespace

core::RayleighDamping fitted_damping(DampingForces kind, double ratio, double frequency, double lowest,
                                     double highest) {
    const double omega = tau * frequency;
    auto damping = core::rayleigh_damping(1.0, tau * lowest, tau * highest);
    if (kind == DampingForces::mass)
        damping = {.alpha = 2.0 * omega, .beta = 0.0};
    if (kind == DampingForces::stiffness)
        damping = {.alpha = 0.0, .beta = 2.0 / omega};
    const double factor = ratio / damping.ratio(omega);
    return {factor * damping.alpha, factor * damping.beta};
}

results::RingDownResult measured_ring_down(const experiments::RingDown &ring_down, std::span<const Vector3> positions,
                                           std::span<const int> markers) {
    const auto mean = experiments::mean_motion(ring_down.repeats);
    const auto ringing = experiments::measured_ringing(ring_down.repeats, markers);
    results::RingDownResult result{.state = ring_down.state,
                                   .interval = mean.interval,
                                   .displacement = mean.displacement,
                                   .frequency = ringing.value.frequency,
                                   .frequency_uncertainty = ringing.frequency_uncertainty,
                                   .damping_ratio = ringing.value.ratio,
                                   .damping_uncertainty = ringing.ratio_uncertainty,
                                   .swings =
                                       experiments::swings(mean, markers, ringing.value.frequency, results::num_swings),
                                   .runs = {}};
    for (const auto &repeat : ring_down.repeats) {
        const auto count = static_cast<double>(ring_down.repeats.size());
        const double distance = results::root_mean_square_distance(repeat.displacement, mean.displacement);
        result.noise += distance * distance / count;
        const auto swings = experiments::swings(repeat, markers, ringing.value.frequency, results::num_swings);
        for (int n = 0; n < results::num_swings; ++n)
            result.swing_noise += std::pow(swings[n] - result.swings[n], 2) / (count * results::num_swings);
    }
    result.noise = std::sqrt(result.noise);
    result.swing_noise = std::sqrt(result.swing_noise);
    const int num_records = mean.num_records();
    std::vector<Vector3> still(mean.num_markers, Vector3::Zero()), stays, rigid;
    for (int j = 0; j < num_records; ++j)
        for (int k = 0; k < mean.num_markers; ++k)
            still[k] += mean.at(j, k) / num_records;
    for (int j = 0; j < num_records; ++j) {
        std::vector<Vector3> targets;
        for (int k = 0; k < mean.num_markers; ++k)
            targets.emplace_back(positions[k] + mean.at(j, k));
        const auto fitted = experiments::best_rigid_motion(positions, targets);
        for (int k = 0; k < mean.num_markers; ++k) {
            stays.push_back(still[k]);
            rigid.emplace_back(fitted.at(positions[k]) - positions[k]);
        }
    }
    result.no_motion = results::root_mean_square_distance(stays, mean.displacement);
    result.rigid_motion = positions.size() < experiments::fewest_of_rigid_motion
                              ? results::not_known
                              : results::root_mean_square_distance(rigid, mean.displacement);
    return result;
}

std::vector<results::RingDownRun> ring_down_of_model(const core::Model &model, const experiments::RingDown &ring_down,
                                                     const results::RingDownResult &measured, double edge_length,
                                                     const core::RayleighDamping &damping, double at_frequency,
                                                     std::span<const Vector3> positions, std::span<const int> markers) {
    const auto start = core::Clock::now();
    RingingBody body(model, ring_down, edge_length, positions);
    if (!body.takes_part())
        return {};
    const int parts =
        static_cast<int>(std::ceil(measured.interval * tau * measured.frequency / std::sqrt(12.0 * step_error)));
    const double interval = measured.interval / parts;
    results::RingDownRun run{.model = model.name, .tetrahedra = body.tetrahedra(), .damping = damping};
    if (body.is_method())
        run.damping = {2.0 * tau * at_frequency * damping.ratio(tau * at_frequency), 0.0};
    const auto end_early = [&](const core::Solution &solution) {
        run.status = solution.status;
        run.message = solution.message;
        run.swings.assign(results::num_swings, std::numeric_limits<double>::quiet_NaN());
        run.displacement.assign(measured.displacement.size(),
                                Vector3::Constant(std::numeric_limits<double>::quiet_NaN()));
        run.seconds = core::seconds_since(start);
        return std::vector{run};
    };
    const auto once = body.held_by(1.0, body.release(interval, 1, run.damping));
    if (once.status != core::SolutionStatus::ok)
        return end_early(once);
    if (!once.history)
        return {};
    const auto free = body.held_by(0.0);
    if (free.status != core::SolutionStatus::ok)
        return end_early(free);
    double factor_a = 0.0, factor_b = 1.0;
    auto a = body.markers(free), b = body.markers(once);
    for (int correction = 0; correction < num_corrections; ++correction) {
        const double next = nearest_factor(factor_a, a, factor_b, b, measured.displacement, markers);
        const auto held = body.held_by(next);
        if (held.status != core::SolutionStatus::ok)
            return end_early(held);
        factor_a = std::exchange(factor_b, next);
        a = std::exchange(b, body.markers(held));
        if (std::abs(factor_b - factor_a) < 1e-3 * std::abs(factor_b))
            break;
    }
    const auto num_records = measured.num_records(positions.size());
    const auto moved = body.held_by(factor_b, body.release(interval, (num_records - 1) * parts, run.damping));
    if (!moved.history)
        return end_early(moved);
    run.status = moved.status;
    run.message = moved.message;
    run.integrator = moved.history->integrator;
    run.time_step = moved.history->time_step;
    run.displacement = body.markers(*moved.history, parts);
    describe(run, measured, positions.size(), markers);
    run.seconds = core::seconds_since(start);
    return {run};
}

} // namespace livermark::studies
