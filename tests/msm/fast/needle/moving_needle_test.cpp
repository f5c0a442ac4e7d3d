#include "tests/samples/needle_in_springs.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <utility>

#include "core/mesh/places.hpp"
#include "msm/dynamics/stepper.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/integrator.hpp"
#include "msm/spring_law.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/moving_samples.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::msm {
namespace {

using core::Vector3;

constexpr double needle_step = 2e-4; // [s]

/// A box of 40 x 30 x 30 mm that stands on a plane: held there upwards alone at some nodes, and wholly at the others.
struct PrickedBox {
    core::Body body = *tests::make_body(tests::box_mesh({0.04, 0.03, 0.03}, {4, 3, 3}), {1060.0, 5e3, 0.45});
    NodalConditions conditions = [this] {
        NodalConditions held;
        for (const auto &x : body.mesh.points) {
            const double free = std::nan("");
            const bool is_below = x.z() < 1e-9;
            held.displacement.emplace_back(is_below && x.x() < 0.015 ? free : (is_below ? 0.0 : free),
                                           is_below ? 0.0 : free, is_below ? 0.0 : free);
            held.constraint.push_back({-1, -1, -1});
            held.force.emplace_back(Vector3::Zero());
        }
        return held;
    }();
    core::Needle needle{.name = "needle",
                        .entry = {0.016, 0.013, 0.03},
                        .target = {0.024, 0.017, 0.012},
                        .diameter = 1e-3,
                        .spread = 7e-3,
                        .toughness = 40.0,
                        .friction = 4.0,
                        .puncture_force = 0.08,
                        .step = 5e-4};

    /// In, so quickly that it rings, a rest, half way out, in again and out.
    double depth_at(int step) const {
        const double way = needle.depth() / 160.0;
        if (step < 160)
            return way * step;
        if (step < 200)
            return needle.depth();
        if (step < 280)
            return needle.depth() - way * (step - 200);
        if (step < 360)
            return needle.depth() - way * (360 - step);
        return needle.depth() - way * (step - 360);
    }
    static constexpr int num_steps = 560;

    FastSteps steps(const ElasticBody &springs, double time_step, ForcePrecision precision) const {
        return FastSteps::prepare(springs, body.mesh.points, conditions, {20.0, 0.0}, "symplectic_euler", time_step,
                                  {.precision = precision})
            .value();
    }
};

ElasticBody springs_named(const core::Body &body, const std::string &name) {
    for (const auto &coupled : all_coupled_springs())
        if (coupled.name == name)
            return coupled_springs_with_volume(body, coupled);
    const auto laws = all_spring_laws();
    const auto &law = *std::ranges::find(laws, name, &SpringLaw::name);
    return springs_with_volume(body, springs_beside_volume(body, law), find_volume_term("nodal_volume")).body;
}

/// The needle, slowly and plainly: matrices of all nodes in three components, and impulses by as many sweeps
/// of Gauss and Seidel as it takes.
class PlainNeedle {
  public:
    PlainNeedle(const PrickedBox &box, const ElasticBody &body)
        : needle_(box.needle), line_(core::needle_line(box.needle)), axis_(box.needle.direction()),
          weights_(core::nodal_weights(line_.places, box.body.mesh)) {
        per_mass_ = Eigen::VectorXd::Zero(3 * weights_.cols());
        Eigen::VectorXd inverse_mass(weights_.cols());
        for (Eigen::Index i = 0; i < weights_.cols(); ++i) {
            const auto &held = box.conditions.displacement[i];
            inverse_mass[i] = held.array().isNaN().any() ? 1.0 / body.node_mass[i] : 0.0;
            for (int c = 0; c < 3; ++c)
                per_mass_[3 * i + c] = std::isnan(held[c]) ? inverse_mass[i] : 0.0;
        }
        places_ = weights_ * inverse_mass.asDiagonal() * weights_.transpose();
        stuck_.assign(weights_.rows(), std::nan(""));
        held_.assign(weights_.rows(), Vector3::Zero());
        before_ = Eigen::MatrixXd::Zero(weights_.rows(), 3);
    }

    double tip = 0.0, tip_force = 0.0, force = 0.0;

    void act(State &state, double depth, double h) {
        const auto count = static_cast<int>(weights_.rows());
        Eigen::MatrixXd u = places_of(state.displacement);
        const double soft =
            1.0 / (h * h * core::needle_stiffness + h * core::needle_damping_time * core::needle_stiffness);
        const double lead = depth - depth_;
        // Rows of what is asked for: the tip, the shaft, and places across.
        Eigen::VectorXd at_tip = Eigen::VectorXd::Zero(count);
        const auto [below, part] = core::point_of_line(line_, tip);
        at_tip[below] = part;
        at_tip[below + 1] = 1.0 - part;
        const auto impulse_for = [&](double gap, double change) {
            return -soft * core::needle_stiffness * (h * gap + core::needle_damping_time * change);
        };
        const double largest =
            tip < deepest_ ? 0.0 : (is_punctured_ ? needle_.toughness * needle_.diameter : needle_.puncture_force);
        std::vector<Eigen::VectorXd> row{at_tip};
        std::vector<double> wanted{
            impulse_for(tip + at_tip.dot(u * axis_) - depth, at_tip.dot((u - before_) * axis_) - lead)};
        std::vector<double> low{0.0}, high{h * largest};
        std::vector<int> place{-1};
        for (int k = 0; k < count; ++k) {
            const double length = core::shaft_length(line_, k, tip);
            if (length <= 0.0)
                continue;
            if (std::isnan(stuck_[k]))
                stuck_[k] = before_.row(k).dot(axis_) - depth_;
            row.emplace_back(Eigen::VectorXd::Unit(count, k));
            wanted.push_back(
                impulse_for(u.row(k).dot(axis_) - depth - stuck_[k], (u.row(k) - before_.row(k)).dot(axis_) - lead));
            high.push_back(h * needle_.friction * length);
            low.push_back(-high.back());
            place.push_back(k);
        }
        const auto along = within_limits(row, soft, wanted, low, high);
        Eigen::MatrixXd impulse = Eigen::MatrixXd::Zero(count, 3);
        for (std::size_t r = 0; r < row.size(); ++r)
            impulse += along[r] * row[r] * axis_.transpose();
        if (num_held_ > 0) {
            const double bed = needle_.side_stiffness * line_.spacing, softer = 1.0 + core::needle_stiffness / bed;
            const Eigen::MatrixXd block = places_.topLeftCorner(num_held_, num_held_) +
                                          soft * softer * Eigen::MatrixXd::Identity(num_held_, num_held_);
            Eigen::MatrixXd right(num_held_, 3);
            for (int k = 0; k < num_held_; ++k) {
                Vector3 gap = u.row(k).transpose() - held_[k], change = (u.row(k) - before_.row(k)).transpose();
                gap -= axis_ * axis_.dot(gap);
                change -= axis_ * axis_.dot(change);
                right.row(k) = -soft * core::needle_stiffness * (h * gap + core::needle_damping_time * change);
            }
            impulse.topRows(num_held_) += block.fullPivLu().solve(right);
        }
        const Eigen::MatrixXd nodal = weights_.transpose() * impulse; // (N, 3)
        for (Eigen::Index i = 0; i < nodal.rows(); ++i) {
            const Vector3 kick = per_mass_.segment<3>(3 * i).cwiseProduct(nodal.row(i).transpose());
            state.velocity.segment<3>(3 * i) += kick;
            state.displacement.segment<3>(3 * i) += h * kick;
        }
        force = (impulse * axis_).sum() / h;
        tip_force = along[0] / h;
        u += h * (places_ * impulse);
        depth_ = depth;
        go_on(u, place, along, high, h);
        before_ = u;
    }

  private:
    Eigen::MatrixXd places_of(const Eigen::VectorXd &field) const {
        return weights_ * Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>>(
                              field.data(), weights_.cols(), 3);
    }

    std::vector<double> within_limits(const std::vector<Eigen::VectorXd> &row, double soft,
                                      const std::vector<double> &wanted, const std::vector<double> &low,
                                      const std::vector<double> &high) const {
        const std::size_t count = row.size();
        Eigen::MatrixXd matrix(count, count);
        for (std::size_t r = 0; r < count; ++r)
            for (std::size_t c = 0; c < count; ++c)
                matrix(r, c) = row[r].dot(places_ * row[c]) + (r == c ? soft : 0.0);
        std::vector<double> x(count, 0.0);
        double change = 1.0, size = 1.0;
        for (int sweep = 0; sweep < 20000 && change > 1e-15 * size; ++sweep) {
            change = size = 0.0;
            for (std::size_t r = 0; r < count; ++r) {
                double sum = wanted[r];
                for (std::size_t c = 0; c < count; ++c)
                    sum -= c == r ? 0.0 : matrix(r, c) * x[c];
                const double next = std::clamp(sum / matrix(r, r), low[r], high[r]);
                change = std::max(change, std::abs(next - x[r]));
                size = std::max(size, std::abs(next));
                x[r] = next;
            }
        }
        return x;
    }

    void go_on(const Eigen::MatrixXd &u, const std::vector<int> &place, const std::vector<double> &along,
               const std::vector<double> &high, double h) {
        const bool tears = tip >= deepest_ && along[0] > 0.0 && along[0] >= high[0];
        is_punctured_ = is_punctured_ || tears;
        for (std::size_t r = 1; r < place.size(); ++r)
            if (std::abs(along[r]) >= high[r])
                stuck_[place[r]] = u.row(place[r]).dot(axis_) - depth_ + along[r] / h / core::needle_stiffness;
        const auto [below, part] = core::point_of_line(line_, tip);
        const double first = u.row(below).dot(axis_), next = u.row(below + 1).dot(axis_);
        const double overlap = depth_ - tip - (part * first + (1.0 - part) * next);
        const double stretched = std::max(0.2, 1.0 + (next - first) / line_.spacing);
        const double most = 0.5 * line_.spacing;
        if (tears)
            tip += std::clamp((overlap - along[0] / h / core::needle_stiffness) / stretched, 0.0, most);
        else if (tip < deepest_ || (overlap < 0.0 && along[0] <= 0.0))
            tip = std::clamp(tip + std::clamp(overlap / stretched, -most, most), 0.0, deepest_);
        tip = std::min(tip, line_.spacing * static_cast<double>(line_.places.size() - 1));
        deepest_ = std::max(deepest_, tip);
        for (std::size_t k = 0; k < stuck_.size(); ++k)
            if (core::shaft_length(line_, static_cast<int>(k), tip) <= 0.0)
                stuck_[k] = std::nan("");
        const int held = tip > 0.0 || along[0] > 0.0 ? static_cast<int>(tip / line_.spacing + 1e-9) + 1 : 0;
        for (int k = num_held_; k < held; ++k)
            held_[k] = u.row(k);
        num_held_ = held;
    }

    core::Needle needle_;
    core::NeedleLine line_;
    Vector3 axis_;
    Eigen::SparseMatrix<double, Eigen::RowMajor> weights_;
    Eigen::VectorXd per_mass_;
    Eigen::MatrixXd places_, before_;
    std::vector<double> stuck_;
    std::vector<Vector3> held_;
    int num_held_ = 0;
    bool is_punctured_ = false;
    double depth_ = 0.0, deepest_ = 0.0;
};

/// Difference of displacements, over the largest.
double largest_difference(const State &found, const State &expected) {
    return (found.displacement - expected.displacement).lpNorm<Eigen::Infinity>() /
           expected.displacement.lpNorm<Eigen::Infinity>();
}

TEST(MovingNeedle, DoesWhatThePlainOneDoes) {
    PrickedBox box;
    const core::RayleighDamping damping{20.0, 0.0};
    constexpr double rigid = std::numeric_limits<double>::infinity(), bed = 2e4; // N/m^2
    for (const auto &[name, side_stiffness] :
         {std::pair{"patch", rigid}, std::pair{"nodal_neo_hookean", rigid}, std::pair{"patch", bed}})
        for (const auto precision : tests::both_precisions) {
            SCOPED_TRACE(fmt::format("{} {}", name, side_stiffness));
            box.needle.side_stiffness = side_stiffness;
            const auto body = springs_named(box.body, name);
            auto steps = box.steps(body, needle_step, precision);
            MovingNeedle needle(box.needle, box.body.mesh, body.node_mass, box.conditions);
            needle.begin(steps);
            PlainNeedle plain(box, body);
            const auto equation = elastic_motion(body, box.body.mesh.points, box.conditions, damping);
            const auto step = find_integrator("symplectic_euler").prepare(equation, needle_step);
            const auto size = static_cast<Eigen::Index>(3 * box.body.mesh.points.size());
            State state{Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)};
            const bool is_double = precision == ForcePrecision::double_precision;
            double deepest = 0.0;
            for (int s = 0; s < PrickedBox::num_steps; ++s) {
                step(state);
                plain.act(state, box.depth_at(s + 1), needle_step);
                steps.take(1);
                needle.act(steps, box.depth_at(s + 1), needle_step);
                deepest = std::max(deepest, plain.tip);
                if (s % 20 != 19)
                    continue;
                // With other digits the tissue may let go a step earlier or later.
                EXPECT_LT(largest_difference(steps.state(), state), is_double ? 1e-8 : 1e-2) << s;
                EXPECT_NEAR(needle.tip(), plain.tip, (is_double ? 1e-9 : 1e-3) * box.needle.depth()) << s;
                if (!is_double)
                    continue;
                EXPECT_NEAR(needle.force(), plain.force, 1e-7 * box.needle.puncture_force) << s;
                EXPECT_NEAR(needle.tip_force(), plain.tip_force, 1e-7 * box.needle.puncture_force) << s;
            }
            EXPECT_GT(deepest, 0.5 * box.needle.depth()) << "the surface gives way";
        }
}

/// At nearly the longest step that the springs bear, in and out, and then the body comes to rest.
TEST(MovingNeedle, LeavesStepsAsLongAsTheyAre) {
    PrickedBox box;
    for (double *const weaker : {&box.needle.toughness, &box.needle.friction, &box.needle.puncture_force})
        *weaker *= 0.1; // nothing is pressed so far that the body itself gets stiffer
    const auto body = springs_named(box.body, "patch");
    const double highest = largest_angular_frequency(body, box.body.mesh.points, box.conditions, MassScaling{}, 1e-4);
    const double longest = 0.97 * 2.0 / highest;
    auto steps = box.steps(body, longest, ForcePrecision::double_precision);
    MovingNeedle needle(box.needle, box.body.mesh, body.node_mass, box.conditions);
    needle.begin(steps);
    const auto go_on = [&](double from, double to, int count) {
        for (int i = 1; i <= count; ++i) {
            steps.take(1);
            needle.act(steps, from + (to - from) * i / count, longest);
        }
    };
    const int count = static_cast<int>(0.5 / longest);
    go_on(0.0, box.needle.depth(), count);
    EXPECT_GT(needle.tip(), 0.5 * box.needle.depth());
    go_on(box.needle.depth(), box.needle.depth(), count);
    const auto state = steps.state();
    EXPECT_LT(state.displacement.lpNorm<Eigen::Infinity>(), 0.01);
    EXPECT_LT(state.velocity.lpNorm<Eigen::Infinity>(), 1e-3);
    const double force = needle.force();
    go_on(box.needle.depth(), box.needle.depth(), count);
    EXPECT_NEAR(needle.force(), force, 0.05 * std::abs(force)) << "it sticks";
    go_on(box.needle.depth(), -0.02, 2 * count);
    EXPECT_EQ(needle.tip(), 0.0);
    EXPECT_EQ(needle.force(), 0.0);
}

/// A step that is too long for a body that is pressed in far.
TEST(MovingNeedle, SaysThatABodyHasDiverged) {
    const PrickedBox box;
    const auto body = springs_named(box.body, "patch");
    auto steps = box.steps(body, needle_step, ForcePrecision::double_precision);
    MovingNeedle needle(box.needle, box.body.mesh, body.node_mass, box.conditions);
    needle.begin(steps);
    int step = 0;
    for (; step < 120; ++step) {
        steps.take(1);
        needle.act(steps, box.depth_at(step), needle_step);
    }
    const double tip = needle.tip();
    ASSERT_GT(tip, 0.0);
    auto state = steps.state();
    state.displacement.setConstant(std::nan(""));
    steps.set_state(state);
    for (; step < box.num_steps; ++step) {
        steps.take(1);
        needle.act(steps, box.depth_at(step), needle_step);
        ASSERT_FALSE(std::isfinite(needle.force()));
    }
    EXPECT_EQ(needle.tip(), tip);
}

TEST(FastSteps, GiveManyNodesWhatTheyGiveOne) {
    const PrickedBox box;
    const auto body = springs_named(box.body, "nodal_neo_hookean");
    for (const auto precision : tests::both_precisions) {
        const auto prepare = [&] {
            auto steps = FastSteps::prepare(body, box.body.mesh.points, box.conditions, {3.0, 1e-4}, "symplectic_euler",
                                            1e-4, {.precision = precision});
            steps->set_load(7, {0.0, 0.1, 0.2});
            steps->take(5);
            return *steps;
        };
        auto together = prepare(), each = prepare();
        const std::vector<int> nodes{3, 0, 40, 7};
        const std::vector<Vector3> velocity{{0.1, 0.2, 0.3}, {1.0, 1.0, 1.0}, {-0.1, 0.0, 0.2}, {0.3, 0.1, -0.1}};
        together.kick(nodes, velocity, 1e-4);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            each.push(nodes[i], 1e-4 * velocity[i], velocity[i]);
        std::vector<Vector3> displacement(nodes.size());
        together.displacements(nodes, displacement);
        for (std::size_t i = 0; i < nodes.size(); ++i)
            EXPECT_EQ(displacement[i], each.displacement(nodes[i]));
        together.take(3);
        each.take(3);
        EXPECT_EQ(together.state().displacement, each.state().displacement);
        EXPECT_EQ(together.state().velocity, each.state().velocity);
    }
}

} // namespace
} // namespace livermark::msm
