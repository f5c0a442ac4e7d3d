#include "msm/needle/moving_insertion.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace livermark::msm {

namespace {

/// Of lengths, over the step of the needle.
constexpr double of_needle_step = 1e-9;

/// A needle in a body, one record after the other.
class DrivingInSteps {
  public:
    DrivingInSteps(const ElasticBody &body, const core::TetraMesh &mesh, const NodalConditions &conditions,
                   const core::Needle &needle, const MovingInsertionOptions &options)
        : body_(body), mesh_(mesh), options_(options), needle_(needle, mesh, body.node_mass, conditions) {
        auto steps = FastSteps::prepare(body, mesh.points, conditions, options.damping, "symplectic_euler",
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

    double kinetic(const State &state) const {
        double sum = 0.0;
        for (std::size_t i = 0; i < body_.node_mass.size(); ++i)
            sum += 0.5 * body_.node_mass[i] * of_node(state.velocity, static_cast<int>(i)).squaredNorm();
        return sum;
    }

    void add_record(double force) {
        const auto state = steps_->state();
        auto positions = mesh_.points;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += of_node(state.displacement, static_cast<int>(i));
        auto &record = found_.record;
        const auto &work = needle_.work();
        record.depth.push_back(needle_.depth());
        record.force.push_back(force);
        record.tip.push_back(needle_.tip());
        record.target.push_back(needle_.target_displacement(*steps_));
        record.entry.push_back(needle_.entry_displacement());
        record.work.push_back(work.hand);
        record.stored.push_back(elastic_energy(body_, positions) - elastic_energy(body_, mesh_.points));
        record.friction.push_back(work.friction);
        record.tearing.push_back(work.tearing);
        found_.kinetic.push_back(kinetic(state));
        record.holding.push_back(work.holding);
        found_.damping.push_back(lost_);
    }

    const ElasticBody &body_;
    const core::TetraMesh &mesh_;
    MovingInsertionOptions options_;
    MovingNeedle needle_;
    std::optional<FastSteps> steps_;
    double lost_ = 0.0;
    MovingInsertion found_;
};

} // namespace

double MovingInsertion::energy_error() const {
    double largest = 0.0;
    for (std::size_t j = 0; j < kinetic.size(); ++j)
        largest = std::max(largest, std::abs(record.work[j] - record.stored[j] - kinetic[j] - record.friction[j] -
                                             record.tearing[j] - record.holding[j] - damping[j]));
    return largest / record.work[static_cast<std::size_t>(record.at_plan)];
}

MovingInsertion insert_in_steps(const ElasticBody &body, const core::TetraMesh &mesh, const NodalConditions &conditions,
                                const core::Needle &needle, const MovingInsertionOptions &options) {
    DrivingInSteps driving(body, mesh, conditions, needle, options);
    const int steps = std::max(1, static_cast<int>(std::ceil(needle.depth() / needle.step - of_needle_step)));
    for (int step = 1; step <= steps; ++step)
        driving.go_to(needle.depth() * step / steps);
    driving.plan_is_reached();
    for (int step = steps - 1; step >= -steps && !driving.is_out(); --step)
        driving.go_to(needle.depth() * step / steps);
    return std::move(driving).take();
}

} // namespace livermark::msm
