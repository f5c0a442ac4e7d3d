#pragma once

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/relaxation.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/elastic_body.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "results/records/needle.hpp"
#include "studies/models/model_table.hpp"
#include "studies/needle/needle_study.hpp"
#include "tests/samples/needle_in_springs.hpp"
#include "tests/samples/random_needles.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

inline core::Needle needle_of_some_tissue() {
    return {.name = "needle",
            .entry = {0.01, 0.02, 0.03},
            .target = {0.01, 0.06, 0.06},
            .diameter = 1e-3,
            .spread = 6e-3,
            .toughness = 200.0,
            .friction = 10.0,
            .puncture_force = 0.2,
            .step = 2.5e-4};
}

/// A needle that goes from above into a box of 40 x 30 x 30 mm, aslant.
inline core::Needle slanted_needle(double puncture_force, double step) {
    return {.name = "needle",
            .entry = {0.016, 0.013, 0.03},
            .target = {0.024, 0.017, 0.012},
            .diameter = 1e-3,
            .spread = 8e-3,
            .toughness = 60.0,
            .friction = 6.0,
            .puncture_force = puncture_force,
            .step = step};
}

/// Tissue in a box that is held below.
inline core::Problem box_held_below(const core::Vector3 &size, const std::array<int, 3> &bricks) {
    core::Problem held{make_body(box_mesh(size, bricks), {1060.0, 5e3, 0.45}), {}};
    held.load_case = empty_load_case(held.body->mesh);
    prescribe(held.load_case, held.body->mesh, "z_min", core::Vector3::Zero());
    return held;
}

/// Patch springs with the volumes around nodes.
inline msm::ElasticBody patch_springs(const core::Body &body) {
    const auto beside =
        msm::springs_beside_volume(body, support::find_named(msm::all_spring_laws(), "patch", "spring law"));
    return msm::springs_with_volume(body, beside, msm::find_volume_term("nodal_volume")).body;
}

/// Tissue whose places give way the less for each other the farther they are apart, and not along the axis alone.
inline Eigen::MatrixXd some_tissue(const core::NeedleLine &line, double compliance, double reach,
                                   std::mt19937 &random) {
    std::normal_distribution<double> normal;
    Eigen::Matrix3d root;
    for (double &entry : root.reshaped())
        entry = normal(random);
    const Eigen::Matrix3d block = Eigen::Matrix3d::Identity() + 0.2 * root * root.transpose();
    const auto places = static_cast<Eigen::Index>(line.places.size());
    Eigen::MatrixXd matrix(3 * places, 3 * places);
    for (Eigen::Index i = 0; i < places; ++i)
        for (Eigen::Index j = 0; j < places; ++j)
            matrix.block<3, 3>(3 * i, 3 * j) =
                compliance * std::exp(-line.spacing * static_cast<double>(std::abs(i - j)) / reach) * block;
    return matrix;
}

/// Largest fault of the balance of work, as a part of the work of the hand.
inline constexpr double most_out_of_balance = 0.02;

/// Fault of an insertion, in steps or not; empty if it has none.
inline std::string fault_of(const core::Insertion &insertion, const core::Needle &needle, double energy_error) {
    const auto is_finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(insertion.force, is_finite) || !std::ranges::all_of(insertion.tip, is_finite) ||
        !std::ranges::all_of(insertion.target, [](const core::Vector3 &u) { return u.allFinite(); }))
        return "something is not finite";
    if (!(energy_error < most_out_of_balance))
        return fmt::format("work is out of balance by {:.2f} %", 100.0 * energy_error);
    const double most = needle.puncture_force + needle.friction * needle.depth();
    if (!(*std::ranges::max_element(insertion.force) <= most * (1.0 + 1e-6)))
        return fmt::format("the hand pushes with {} N, more than {} N", *std::ranges::max_element(insertion.force),
                           most);
    return {};
}

/// The same, of one that ends outside.
inline std::string fault_of(const results::NeedleRun &run, const core::Needle &needle) {
    const auto &insertion = run.insertion;
    auto fault = fault_of(insertion, needle, run.energy_error());
    if (fault.empty() && std::abs(insertion.force.back()) > 1e-6)
        fault = fmt::format("{} N are left when it is out", insertion.force.back());
    return fault;
}

/// Random needles in random tissue.
/// @param least_spread  of the places [m]: the narrower, the more of them
/// @return a sentence for each with a fault
inline std::vector<std::string> drive_into_some_tissue(unsigned seed, int count, double least_spread) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part;
    std::vector<std::string> faults;
    for (int n = 0; n < count; ++n) {
        auto some = needle_of_some_tissue();
        some.spread = least_spread + 0.01 * part(random);
        some.toughness = 20.0 + 300.0 * part(random);
        some.friction = n % 5 == 0 ? 0.0 : 60.0 * part(random);
        some.puncture_force = some.tip_force();
        const auto line = core::needle_line(some);
        const double compliance = std::pow(10.0, -3.0 + part(random));
        results::NeedleRun run;
        run.insertion = studies::insert(some_tissue(line, compliance, 0.005 + 0.05 * part(random), random), line, some);
        if (const auto fault = fault_of(run, some); !fault.empty())
            faults.push_back(fmt::format("{}: compliance {}, friction {}, spread {}: {}", n, compliance, some.friction,
                                         some.spread, fault));
    }
    return faults;
}

/// Speed and steps of a needle.
struct MovingInsertionOptions {
    double speed = 0.01;     ///< of the hand [m/s], > 0
    double time_step = 1e-3; ///< of symplectic Euler [s], > 0
    core::RayleighDamping damping{.alpha = 10.0, .beta = 0.0};
    msm::ForcePrecision precision = msm::ForcePrecision::double_precision;
};

/// Records of a needle in steps. At a record, work of the hand = stored + kinetic + friction + tearing + holding +
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
            sum += 0.5 * body_.node_mass[i] * msm::node_part(state.velocity, static_cast<int>(i)).squaredNorm();
        return sum;
    }

    void add_record(double force) {
        const auto state = steps_->state();
        auto positions = mesh_.points;
        for (std::size_t i = 0; i < positions.size(); ++i)
            positions[i] += msm::node_part(state.displacement, static_cast<int>(i));
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

/// Drives needles into models by turns.
/// @return a sentence for each with a fault
inline std::vector<std::string> drive_random_needles(const std::string &body, const std::string &held, unsigned seed,
                                                     int count) {
    constexpr std::array models{"fem_p1", "patch", "van_gelder"};
    const auto all = models::all_models();
    RandomNeedles random(body, held, seed);
    std::vector<std::string> faults;
    for (int n = 0; n < count; ++n) {
        const auto [problem, needle] = random.next();
        const std::string name = models[static_cast<std::size_t>(n) % models.size()];
        const auto line = core::needle_line(needle);
        const auto compliance = support::find_named(all, name, "model").compliance(problem, line.places);
        const results::NeedleRun run{
            .model = name, .insertion = studies::insert(compliance.matrix, line, needle), .setup_seconds = 0.0};
        if (const auto fault = fault_of(run, needle); !fault.empty())
            faults.push_back(fmt::format("{} needle {}, {}: {}", body, n, name, fault));
    }
    return faults;
}

/// Drives needles into patch springs in steps, at 2 to 10 cm/s.
/// @return a sentence for each with a fault
inline std::vector<std::string> step_random_needles(const std::string &body, const std::string &held, unsigned seed,
                                                    int count) {
    constexpr double part_of_critical_step = 0.25; // pressed in by centimetres, springs are stiffer than at rest
    RandomNeedles random(body, held, seed);
    std::vector<std::string> faults;
    std::optional<msm::ElasticBody> springs;
    double time_step = 0.0;
    for (int n = 0; n < count; ++n) {
        auto [problem, needle] = random.next();
        needle.step = 1e-3; // of records
        if (!springs)
            springs = patch_springs(*problem.body);
        const auto conditions = msm::nodal_conditions(problem, springs->node_mass);
        if (time_step == 0.0)
            time_step = part_of_critical_step * 2.0 /
                        msm::largest_angular_frequency(*springs, problem.body->mesh.points, conditions);
        const auto found = insert_in_steps(
            *springs, problem.body->mesh, conditions, needle,
            {.speed = 0.02 + 0.08 * random.part(),
             .time_step = time_step,
             .damping = {20.0, 0.0},
             .precision = n % 4 == 0 ? msm::ForcePrecision::double_precision : msm::ForcePrecision::single_precision});
        const auto fault = fault_of(found.record, needle, found.energy_error());
        if (!fault.empty())
            faults.push_back(fmt::format("{} needle {} in steps: {}", body, n, fault));
    }
    return faults;
}

} // namespace livermark::tests
