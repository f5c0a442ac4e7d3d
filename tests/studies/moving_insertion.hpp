#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/rayleigh_damping.hpp"
#include "msm/elastic_body.hpp"
#include "tests/samples/needle_in_springs.hpp"

namespace livermark::tests {

/// How a needle is driven in steps.
struct MovingInsertionOptions {
    double speed = 0.01;     ///< of the hand [m/s], > 0
    double time_step = 1e-3; ///< of symplectic Euler [s], > 0
    core::RayleighDamping damping{.alpha = 10.0, .beta = 0.0};
    msm::ForcePrecision precision = msm::ForcePrecision::double_precision;
};

/// What a needle in steps meets. At a record, work of the hand = stored + kinetic + friction + tearing + holding +
/// damping.
struct MovingInsertion {
    core::Insertion record;      ///< `stored` is elastic; forces are means over the steps from record to record
    std::vector<double> kinetic; ///< (J) [J]
    std::vector<double> damping; ///< (J) lost by damping of the masses so far [J]

    /// The largest that the two sides of the balance differ by at a record, over the work that the hand has done until
    /// the tip was at the target.
    double energy_error() const {
        double largest = 0.0;
        for (std::size_t j = 0; j < kinetic.size(); ++j)
            largest = std::max(largest, std::abs(record.work[j] - record.stored[j] - kinetic[j] - record.friction[j] -
                                                 record.tearing[j] - record.holding[j] - damping[j]));
        return largest / record.work[static_cast<std::size_t>(record.at_plan)];
    }
};

/// A needle in a body, one record after the other.
class DrivingInSteps {
  public:
    DrivingInSteps(const msm::ElasticBody &body, const core::TetraMesh &mesh, const msm::NodalConditions &conditions,
                   const core::Needle &needle, const MovingInsertionOptions &options)
        : body_(body), mesh_(mesh), options_(options), needle_(needle, mesh, body.node_mass, conditions) {
        auto steps = msm::FastSteps::prepare(body, mesh.points, conditions, options.damping, "symplectic_euler",
                                             options.time_step, {.precision = options.precision});
        if (!steps || options.damping.beta != 0.0)
            throw std::invalid_argument("fast kernels do not know this body, or its damping is not told apart");
        steps_ = std::move(steps);
        needle_.begin(*steps_);
        add_record(0.0);
    }

    void go_to(double depth) {
        const double start = needle_.depth(), h = options_.time_step;
        const int count = std::max(1, static_cast<int>(std::ceil(std::abs(depth - start) / (options_.speed * h))));
        const bool was_whole = !needle_.is_punctured();
        double force = 0.0;
        for (int i = 1; i <= count; ++i) {
            steps_->take(1);
            needle_.act(*steps_, start + (depth - start) * i / count, h);
            force += needle_.force() / count;
            add_damping(h);
        }
        add_record(force);
        if (was_whole && needle_.is_punctured())
            found_.record.puncture_depth = depth;
    }

    bool is_out() const { return needle_.tip() <= 0.0 && needle_.force() <= 0.0; }
    void plan_is_reached() { found_.record.at_plan = found_.record.num_records() - 1; }
    MovingInsertion take() && { return std::move(found_); }

  private:
    void add_damping(double h) {
        if (options_.damping.alpha != 0.0)
            lost_ += 2.0 * h * options_.damping.alpha * kinetic(steps_->state());
    }

    double kinetic(const msm::State &state) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < body_.node_mass.size(); ++i)
            sum += 0.5 * body_.node_mass[i] * msm::of_node(state.velocity, static_cast<int>(i)).squaredNorm();
        return sum;
    }

    void add_record(double force) {
        const auto state = steps_->state();
        auto positions = mesh_.points;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += msm::of_node(state.displacement, static_cast<int>(i));
        auto &record = found_.record;
        const auto &work = needle_.work();
        record.depth.push_back(needle_.depth());
        record.force.push_back(force);
        record.tip.push_back(needle_.tip());
        record.target.push_back(needle_.target_displacement(*steps_));
        record.entry.push_back(needle_.entry_displacement());
        record.work.push_back(work.hand);
        record.stored.push_back(msm::elastic_energy(body_, positions) - msm::elastic_energy(body_, mesh_.points));
        record.friction.push_back(work.friction);
        record.tearing.push_back(work.tearing);
        found_.kinetic.push_back(kinetic(state));
        record.holding.push_back(work.holding);
        found_.damping.push_back(lost_);
    }

    const msm::ElasticBody &body_;
    const core::TetraMesh &mesh_;
    MovingInsertionOptions options_;
    msm::MovingNeedle needle_;
    std::optional<msm::FastSteps> steps_;
    double lost_ = 0.0;
    MovingInsertion found_;
};

/// Drives a needle into a body at a given speed and draws it out at the same, with the records of studies::insert():
/// slowly, that is what the needle meets there.
/// @param body  at rest on the mesh; fast kernels know it
/// @throws std::invalid_argument if they do not, or as msm::MovingNeedle
inline MovingInsertion insert_in_steps(const msm::ElasticBody &body, const core::TetraMesh &mesh,
                                       const msm::NodalConditions &conditions, const core::Needle &needle,
                                       const MovingInsertionOptions &options) {
    constexpr double rounding = 1e-9; // of lengths, over the step of the needle
    DrivingInSteps driving(body, mesh, conditions, needle, options);
    const int steps = std::max(1, static_cast<int>(std::ceil(needle.depth() / needle.step - rounding)));
    for (int step = 1; step <= steps; ++step)
        driving.go_to(needle.depth() * step / steps);
    driving.plan_is_reached();
    for (int step = steps - 1; step >= -steps && !driving.is_out(); --step)
        driving.go_to(needle.depth() * step / steps);
    return std::move(driving).take();
}

} // namespace livermark::tests
