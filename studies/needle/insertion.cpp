#include "studies/needle/needle_study.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "core/tool/least_within_limits.hpp"
#include "core/tool/needle/needle.hpp"

namespace livermark::studies {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Factor by which a change of forces may be stiffer or softer than the model says, to be learnt from: smaller changes
/// are what searches for equilibria leave.
constexpr double most_surprising = 10.0;

/// Two directions across an axis, and the axis itself, as rows.
Eigen::Matrix3d frame_of(const core::Vector3 &axis) {
    Eigen::Matrix3d frame;
    frame.row(0) = axis;
    frame.row(1) = axis.unitOrthogonal();
    frame.row(2) = axis.cross(frame.row(1).transpose());
    return frame;
}

/// Number of a component of a place, see Tissue.
Index number_of(Index place, int component, Index count) {
    return component == 0 ? place : count + 2 * place + component - 1;
}

MatrixXd in_frame(const MatrixXd &compliance, const Eigen::Matrix3d &frame) {
    const Index count = compliance.rows() / 3;
    MatrixXd result(3 * count, 3 * count);
    for (Index i = 0; i < count; ++i)
        for (Index j = 0; j < count; ++j) {
            // Solvers leave a rounding.
            const Eigen::Matrix3d block =
                0.5 * frame *
                (compliance.block<3, 3>(3 * i, 3 * j) + compliance.block<3, 3>(3 * j, 3 * i).transpose()) *
                frame.transpose();
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b)
                    result(number_of(i, a, count), number_of(j, b, count)) = block(a, b);
        }
    return result;
}

/// Softness of a place against the needle [m/N].
constexpr double place_softness = 1.0 / core::needle_stiffness;

/// A body along the axis of a needle and across it, as if it were linear from where it was pushed to last: u = b + C f.
/// The K components along the axis come first, then the 2 K across it. C begins with that of the body at rest; what the
/// body does under other forces corrects b, so that the model is exact there, and C by the formula of Broyden,
/// Fletcher, Goldfarb and Shanno for an inverse, which makes it exact for the last change of forces (J. Nocedal, S. J.
/// Wright 2006, Numerical Optimization, eq. 6.17).
class Tissue {
  public:
    /// @param body           kept alive by the caller
    /// @param side_softness  of what holds a place across the axis [m/N]
    Tissue(core::PushedBody &body, const core::Vector3 &axis, double side_softness)
        : body_(body), frame_(frame_of(axis)), size_(body.compliance().rows() / 3), side_softness_(side_softness),
          compliance_(in_frame(body.compliance(), frame_)), offset_(VectorXd::Zero(3 * size_)), pushed_force_(offset_),
          pushed_displacement_(offset_) {}

    /// With the first places held across.
    struct Held {
        MatrixXd along;              ///< (K, K) displacement along the axis for forces along it [m/N]
        MatrixXd hold_to_along;      ///< (K, 2 h) the same for displacements across, at which places are held
        Eigen::LLT<MatrixXd> across; ///< of what is held
    };
    const Held &held(Index count) {
        const auto found = held_.find(count);
        if (found != held_.end())
            return found->second;
        Held held;
        MatrixXd across = compliance_.block(size_, size_, 2 * count, 2 * count);
        across.diagonal().array() += side_softness_;
        held.across.compute(across);
        const MatrixXd between = compliance_.block(0, size_, size_, 2 * count);
        held.hold_to_along = held.across.solve(between.transpose()).transpose();
        held.along = compliance_.topLeftCorner(size_, size_) - held.hold_to_along * between.transpose();
        return held_.emplace(count, std::move(held)).first->second;
    }

    /// Displacement along the axis without forces along it.
    /// @param hold  (2 h) displacements across, at which places are held [m]
    /// @return (K) [m]
    VectorXd along_without_forces(const VectorXd &hold) {
        return offset_.head(size_) + held(hold.size() / 2).hold_to_along * (hold - offset_.segment(size_, hold.size()));
    }
    /// @param along  (K) forces along the axis [N]
    /// @return (2 h) what holds the places [N]
    VectorXd forces_across(const VectorXd &along, const VectorXd &hold) {
        return held(hold.size() / 2)
            .across.solve(hold - offset_.segment(size_, hold.size()) -
                          compliance_.block(0, size_, size_, hold.size()).transpose() * along);
    }
    /// @param across  (2 h) forces across it [N]
    /// @return (2 K) [m]
    VectorXd displacement_across(const VectorXd &along, const VectorXd &across) const {
        return offset_.tail(2 * size_) + compliance_.bottomLeftCorner(2 * size_, size_) * along +
               compliance_.block(size_, size_, 2 * size_, across.size()) * across;
    }
    core::Vector3 in_space(double along, double across_1, double across_2) const {
        return frame_.transpose() * core::Vector3(along, across_1, across_2);
    }
    Index size() const { return size_; } ///< K

    /// Pushes the body itself, and corrects the model where it was wrong by more than a tolerance.
    /// @param along, across  (K), (2 h) forces [N]
    /// @return by how much a place was elsewhere than the model said [m]; nothing if the body comes to no rest
    std::optional<double> push(const VectorXd &along, const VectorXd &across, double tolerance) {
        const VectorXd force = joined(along, across);
        VectorXd in_space(3 * size_), displacement(3 * size_);
        for (Index k = 0; k < size_; ++k)
            in_space.segment<3>(3 * k) =
                this->in_space(force[k], force[number_of(k, 1, size_)], force[number_of(k, 2, size_)]);
        const auto found = body_.push(in_space);
        if (!found)
            return std::nullopt;
        for (Index k = 0; k < size_; ++k) {
            const core::Vector3 place_motion = frame_ * found->displacement.segment<3>(3 * k);
            for (int a = 0; a < 3; ++a)
                displacement[number_of(k, a, size_)] = place_motion[a];
        }
        const double farthest = (displacement - offset_ - compliance_ * force).cwiseAbs().maxCoeff();
        if (farthest > tolerance)
            learn(force, displacement);
        pushed_force_ = force;
        pushed_displacement_ = displacement;
        pushed_stored_ = found->stored;
        return farthest;
    }
    /// Energy that the body stores under forces near those that it was pushed with last: that of then, and the work on
    /// the way from there, as the model has it [J].
    double stored(const VectorXd &along, const VectorXd &across) const {
        const VectorXd force = joined(along, across);
        return pushed_stored_ + 0.5 * (force + pushed_force_).dot(compliance_ * (force - pushed_force_));
    }

  private:
    VectorXd joined(const VectorXd &along, const VectorXd &across) const {
        VectorXd all = VectorXd::Zero(3 * size_);
        all.head(size_) = along;
        all.segment(size_, across.size()) = across;
        return all;
    }
    void learn(const VectorXd &force, const VectorXd &displacement) {
        const VectorXd step = displacement - pushed_displacement_, change = force - pushed_force_;
        const VectorXd expected = compliance_ * change;
        const double work = step.dot(change), expected_work = expected.dot(change);
        if (expected_work > 0.0 && work > expected_work / most_surprising && work < expected_work * most_surprising) {
            // (1 - s y^T / w) C (1 - y s^T / w) + s s^T / w, with w = y^T s
            compliance_ += (1.0 + expected_work / work) / work * (step * step.transpose()) -
                           (expected * step.transpose() + step * expected.transpose()) / work;
            held_.clear();
        }
        offset_ = displacement - compliance_ * force;
    }

    core::PushedBody &body_;
    Eigen::Matrix3d frame_; ///< rows: the axis, and two directions across it
    Index size_;
    double side_softness_;                        ///< [m/N]
    MatrixXd compliance_;                         ///< (3 K, 3 K) C [m/N]
    VectorXd offset_;                             ///< (3 K) b [m]
    VectorXd pushed_force_, pushed_displacement_; ///< (3 K) where the body itself was last
    double pushed_stored_ = 0.0;                  ///< [J]
    std::map<Index, Held> held_;
};

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
/// Rounding of lengths, over the spacing.
constexpr double rounding = 1e-9;
/// Distance by which a place may be elsewhere than forces were found for, over the spacing.
constexpr double agreement = 1e-3;
/// Part that a correction of the tissue's model leaves of its fault, at most: tangents differ by percents from step to
/// step.
constexpr double left_by_correction = 0.1;
/// Passes over forces and places, until they agree.
constexpr int most_passes = 60;

/// A needle in a body, one depth after the other.
class Driving {
  public:
    Driving(core::PushedBody &body, const core::NeedleLine &line, const core::Needle &needle)
        : tissue_(body, needle.direction(), place_softness + needle.side_softness(line.spacing)), line_(line),
          needle_(needle), spacing_(line.spacing), target_(line.target),
          stuck_at_(VectorXd::Constant(tissue_.size(), no_number)), along_(VectorXd::Zero(tissue_.size())),
          shaft_(VectorXd::Zero(tissue_.size())), displacement_(VectorXd::Zero(tissue_.size())),
          across_(VectorXd::Zero(2 * tissue_.size())), hold_(VectorXd::Zero(2)) {
        found_.depth.push_back(0.0);
        record(0.0);
        for (auto *const sum : {&found_.work, &found_.friction, &found_.tearing, &found_.holding})
            sum->push_back(0.0);
        found_.stored.push_back(0.0);
    }

    /// @return whether the body comes to rest there; if not, nothing has changed
    bool go_to(double depth) {
        const double before = tip_;
        const bool was_whole = !is_punctured_;
        const VectorXd old_displacement = displacement_, old_shaft = shaft_, old_across = across_;
        const VectorXd old_holding = holding_;
        const double old_tip_force = tip_force_;
        const auto trial = settled(depth);
        if (!trial) {
            tip_ = before;
            is_punctured_ = !was_whole;
            found_.stopped_at = depth;
            return false;
        }
        accept(*trial, depth);
        found_.depth.push_back(depth);
        record(force());
        add_energies(before, old_displacement, old_shaft, old_tip_force);
        add_holding(old_across, old_holding);
        if (was_whole && is_punctured_) {
            found_.puncture_depth = depth;
            const auto j = found_.depth.size() - 1;
            found_.puncture_loss =
                found_.work[j] - found_.stored[j] - found_.friction[j] - found_.tearing[j] - found_.holding[j];
        }
        return true;
    }

    /// A record where nothing is known.
    void skip(double depth) {
        found_.depth.push_back(depth);
        found_.target.push_back(core::Vector3::Constant(no_number));
        for (auto *const values : {&found_.force, &found_.tip, &found_.entry, &found_.work, &found_.stored,
                                   &found_.friction, &found_.tearing, &found_.holding, &found_.moved})
            values->push_back(no_number);
    }

    bool is_out() const { return tip_ <= 0.0 && force() <= 0.0; }
    core::Insertion take() && { return std::move(found_); }
    void plan_is_reached() {
        found_.at_plan = static_cast<int>(found_.depth.size()) - 1;
        if (!std::isnan(found_.stopped_at))
            return;
        for (Index k = 0; k < tissue_.size(); ++k)
            found_.places.push_back(tissue_.in_space(displacement_[k], across_[2 * k], across_[2 * k + 1]));
    }

  private:
    struct Trial {
        double tip = 0.0, tip_force = 0.0;
        VectorXd along;        ///< (K) forces of shaft and tip [N]
        VectorXd shaft;        ///< (K) those of the shaft
        VectorXd displacement; ///< (K) along the axis [m]
        VectorXd hold;         ///< (2 h) displacements across, at which places are held [m]
        VectorXd holding;      ///< (2 h) what holds them [N], once it is settled
        double stored = 0.0;   ///< in the tissue [J], the same
        double overlap = 0.0;  ///< of needle and tissue at the tip, less what the needle gives way by there [m]
    };

    /// (K) parts that the places have of a point of the axis.
    VectorXd parts_at(double point) const {
        VectorXd parts = VectorXd::Zero(tissue_.size());
        const auto [below, part] = core::point_of_line(line_, point);
        parts[below] = part;
        parts[below + 1] = 1.0 - part;
        return parts;
    }

    /// (K) length of the shaft that each place stands for [m].
    VectorXd lengths(double tip) const {
        VectorXd length(tissue_.size());
        for (Index k = 0; k < tissue_.size(); ++k)
            length[k] = core::shaft_length(line_, static_cast<int>(k), tip);
        return length;
    }

    /// The tissue with the tip at a point of it.
    /// @param tip_force  that it exerts; if not given, from nothing to the largest, as it takes to be at the depth
    Trial with_tip_at(double tip, double depth, std::optional<double> tip_force, double largest = 0.0) {
        const double reach = std::min(tip, tip_) / spacing_ + rounding;
        const Index num_held = std::min(hold_.size() / 2, static_cast<Index>(reach) + 1);
        Trial trial{.tip = tip,
                    .tip_force = tip_force.value_or(0.0),
                    .along = {},
                    .shaft = {},
                    .displacement = {},
                    .hold = hold_.head(2 * num_held),
                    .holding = {},
                    .overlap = 0.0};
        const auto &held = tissue_.held(num_held);
        const VectorXd at_tip = parts_at(tip), length = lengths(tip);
        const Index num_touched = (length.array() > 0.0).count();
        const VectorXd without_forces = tissue_.along_without_forces(trial.hold);
        const VectorXd without_shaft = without_forces + held.along * (trial.tip_force * at_tip);

        const Index unknowns = num_touched + (tip_force ? 0 : 1);
        MatrixXd columns = MatrixXd::Zero(tissue_.size(), unknowns);
        columns.topLeftCorner(num_touched, num_touched).setIdentity();
        VectorXd wanted(unknowns), high(unknowns);
        for (Index k = 0; k < num_touched; ++k) {
            const double stuck = std::isnan(stuck_at_[k]) ? displacement_[k] - found_.depth.back() : stuck_at_[k];
            wanted[k] = stuck + depth - without_shaft[k];
            high[k] = needle_.friction * length[k];
        }
        VectorXd low = -high;
        if (!tip_force) {
            columns.col(num_touched) = at_tip;
            wanted[num_touched] = depth - tip - at_tip.dot(without_shaft);
            low[num_touched] = 0.0;
            high[num_touched] = largest;
        }
        MatrixXd matrix = columns.transpose() * held.along * columns;
        matrix.diagonal().array() += place_softness;
        const VectorXd force = core::least_within_limits(matrix, wanted, low, high);
        if (!tip_force)
            trial.tip_force = force[num_touched];
        trial.shaft = VectorXd::Zero(tissue_.size());
        trial.shaft.head(num_touched) = force.head(num_touched);
        trial.along = trial.shaft + trial.tip_force * at_tip;
        trial.displacement = without_forces + held.along * trial.along;
        trial.overlap = depth - tip - at_tip.dot(trial.displacement) - place_softness * trial.tip_force;
        return trial;
    }

    /// The nearest point where the tip is at the depth, on the way to another one; that one if there is none.
    Trial moved(double depth, double tip_force, double limit) {
        const double way = limit > tip_ ? 1.0 : -1.0;
        const auto goes_on = [&](const Trial &trial) { return way * trial.overlap > 0.0; };
        double from = tip_;
        auto trial = with_tip_at(from, depth, tip_force);
        while (goes_on(trial)) {
            double to = from + way * std::min(0.25 * spacing_, std::abs(limit - from));
            trial = with_tip_at(to, depth, tip_force);
            if (!goes_on(trial)) {
                while (std::abs(to - from) > rounding * spacing_) {
                    const double middle = 0.5 * (from + to);
                    auto there = with_tip_at(middle, depth, tip_force);
                    goes_on(there) ? from = middle : to = middle;
                    if (to == middle)
                        trial = std::move(there);
                }
                return trial;
            }
            from = to;
            if (from == limit)
                return trial;
        }
        return trial;
    }

    /// Motion of the tissue if it is as its model says. Where the surface gives way it is still whole here.
    Trial found(double depth) {
        gives_way_ = false;
        const double end = spacing_ * static_cast<double>(tissue_.size() - 1);
        if (tip_ < deepest_) { // in its own hole
            auto trial = with_tip_at(tip_, depth, 0.0);
            if (trial.overlap < 0.0)
                return moved(depth, 0.0, 0.0);
            trial = moved(depth, 0.0, deepest_);
            if (trial.tip < deepest_ || trial.overlap <= 0.0)
                return trial;
            tip_ = deepest_;
        }
        const double largest = is_punctured_ ? needle_.tip_force() : needle_.puncture_force;
        auto trial = with_tip_at(tip_, depth, std::nullopt, largest);
        const double enough = rounding * spacing_;
        if (trial.tip_force <= 0.0 && trial.overlap < -enough && tip_ > 0.0)
            return moved(depth, 0.0, 0.0);
        if (trial.tip_force >= largest && trial.overlap > enough) {
            if (is_punctured_)
                return moved(depth, needle_.tip_force(), end);
            gives_way_ = true;
        }
        return trial;
    }

    /// Forces and places that agree. Each pass finds forces for the tissue as its model says, and pushes the body
    /// itself with them, which corrects the model. Where that was little, the next forces need no push of their own. A
    /// linear body takes one pass, and one more where its surface gives way: that is decided where both agree.
    /// @return nothing where the body finds no equilibrium
    std::optional<Trial> settled(double depth) {
        const double tip = tip_, enough = agreement * spacing_;
        bool is_near = false;
        for (int pass = 0; pass < most_passes; ++pass) {
            tip_ = tip;
            auto trial = found(depth);
            trial.holding = tissue_.forces_across(trial.along, trial.hold);
            if (!is_near || gives_way_) {
                const auto farthest = tissue_.push(trial.along, trial.holding, enough);
                if (!farthest)
                    return std::nullopt;
                is_near = *farthest <= enough / left_by_correction;
                if (*farthest > enough)
                    continue;
                if (gives_way_) {
                    is_punctured_ = true;
                    is_near = false;
                    continue;
                }
            }
            trial.stored = tissue_.stored(trial.along, trial.holding);
            return trial;
        }
        return std::nullopt;
    }

    void accept(const Trial &trial, double depth) {
        holding_ = trial.holding;
        const VectorXd across_before = std::exchange(across_, tissue_.displacement_across(trial.along, holding_));
        stored_ = trial.stored;
        const double tip_before = std::exchange(tip_, trial.tip);
        deepest_ = std::max(deepest_, tip_);
        tip_force_ = trial.tip_force;
        shaft_ = trial.shaft;
        along_ = trial.along;
        displacement_ = trial.displacement;
        const VectorXd length = lengths(tip_);
        for (Index k = 0; k < tissue_.size(); ++k)
            stuck_at_[k] = length[k] > 0.0 ? displacement_[k] + place_softness * shaft_[k] - depth : no_number;
        const Index num_held = static_cast<Index>(tip_ / spacing_ + rounding) + 1;
        const Index were_held = trial.hold.size();
        hold_.resize(2 * num_held);
        hold_.head(were_held) = trial.hold;
        for (Index k = were_held / 2; k < num_held; ++k) { // where it was when the tip passed
            const double way = tip_ - tip_before;
            const double part =
                way > 0.0 ? std::clamp((static_cast<double>(k) * spacing_ - tip_before) / way, 0.0, 1.0) : 1.0;
            hold_.segment<2>(2 * k) = (1.0 - part) * across_before.segment<2>(2 * k) + part * across_.segment<2>(2 * k);
        }
    }

    double force() const { return along_.sum(); }

    void record(double force) {
        found_.force.push_back(force);
        found_.tip.push_back(tip_);
        found_.target.push_back(
            tissue_.in_space(displacement_[target_], across_[2 * target_], across_[2 * target_ + 1]));
        found_.entry.push_back(displacement_[0]);
        double squared = 0.0;
        for (Index k = 0; k < tissue_.size(); ++k)
            squared = std::max(squared, displacement_[k] * displacement_[k] + across_.segment<2>(2 * k).squaredNorm());
        found_.moved.push_back(std::sqrt(squared));
    }

    /// By the trapezoidal rule.
    void add_energies(double tip_before, const VectorXd &old_displacement, const VectorXd &old_shaft,
                      double old_tip_force) {
        const auto j = found_.depth.size() - 1;
        const double step = found_.depth[j] - found_.depth[j - 1];
        const double tip_force = 0.5 * (old_tip_force + tip_force_);
        const VectorXd mean_displacement = 0.5 * (old_displacement + displacement_);
        // Tissue tears over its length as it is, not as it was at rest.
        const double torn = tip_ - tip_before + (parts_at(tip_) - parts_at(tip_before)).dot(mean_displacement);
        const double tearing = tip_ > tip_before ? std::max(tip_force * torn, 0.0) : 0.0;
        const VectorXd mean_shaft = 0.5 * (old_shaft + shaft_);
        const double sliding = mean_shaft.sum() * step - mean_shaft.dot(displacement_ - old_displacement);
        found_.work.push_back(found_.work.back() + 0.5 * (found_.force[j] + found_.force[j - 1]) * step);
        found_.friction.push_back(found_.friction.back() + sliding);
        found_.tearing.push_back(found_.tearing.back() + tearing);
        found_.stored.push_back(stored_);
    }

    /// By the same rule. What is let go loses what was stored by holding it.
    void add_holding(const VectorXd &old_across, const VectorXd &old_holding) {
        const VectorXd moved = across_ - old_across;
        found_.holding.push_back(found_.holding.back() - 0.5 * (old_holding.dot(moved.head(old_holding.size())) +
                                                                holding_.dot(moved.head(holding_.size()))));
    }

    Tissue tissue_;
    core::NeedleLine line_;
    core::Needle needle_;
    double spacing_;
    Index target_;
    double tip_ = 0.0, deepest_ = 0.0, tip_force_ = 0.0, stored_ = 0.0;
    bool is_punctured_ = false, gives_way_ = false;
    VectorXd stuck_at_; ///< (K) where the needle holds what touches the shaft, less the depth, NaN of what does not
    VectorXd along_, shaft_; ///< (K) forces of shaft and tip, and of the shaft alone [N]
    VectorXd displacement_;  ///< (K) along the axis [m]
    VectorXd across_;        ///< (2 K) [m]
    VectorXd holding_;       ///< (2 h) forces across [N]
    VectorXd hold_;          ///< (2 h) displacements across, at which places are held [m]
    core::Insertion found_;
};

} // namespace

core::Insertion insert(core::PushedBody &body, const core::NeedleLine &line, const core::Needle &needle) {
    Driving driving(body, line, needle);
    const int steps = std::max(1, static_cast<int>(std::ceil(needle.depth() / needle.step - rounding)));
    const auto depth_after = [&](int step) { return needle.depth() * step / steps; };
    bool goes_on = true;
    for (int step = 1; step <= steps; ++step) {
        goes_on = goes_on && driving.go_to(depth_after(step));
        if (!goes_on)
            driving.skip(depth_after(step));
    }
    driving.plan_is_reached();
    // Tissue that sticks to the shaft may come along outwards, no further than it went in.
    for (int step = steps - 1; goes_on && step >= -steps && !driving.is_out(); --step)
        goes_on = driving.go_to(depth_after(step));
    return std::move(driving).take();
}

core::Insertion insert(const MatrixXd &compliance, const core::NeedleLine &line, const core::Needle &needle) {
    core::LinearPushedBody body(compliance);
    return insert(body, line, needle);
}

} // namespace livermark::studies
