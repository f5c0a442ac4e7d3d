#include "msm/needle/moving_needle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace livermark::msm {

namespace {

using Eigen::Index;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
/// Places before the tip whose displacement is known as well, so that a tip that moves on finds it.
constexpr int places_ahead = 3;
/// Of lengths, over the spacing.
constexpr double needle_rounding = 1e-9;
/// Parts of the spacing that the tip moves on at most in a step, and to which tissue before it is compressed at most:
/// nothing that moves slowly comes near them.
constexpr double farthest_in_step = 0.5, least_length = 0.2;

/// Two directions across an axis, and the axis itself, as rows.
Eigen::Matrix3d needle_frame(const core::Vector3 &axis) {
    Eigen::Matrix3d frame;
    frame.row(0) = axis;
    frame.row(1) = axis.unitOrthogonal();
    frame.row(2) = axis.cross(frame.row(1).transpose());
    return frame;
}

} // namespace

MovingNeedle::MovingNeedle(const core::Needle &needle, const core::TetraMesh &mesh,
                           const std::vector<double> &node_mass, const NodalConditions &conditions)
    : needle_(needle), line_(core::needle_line(needle)), frame_(needle_frame(needle.direction())) {
    const auto weights = core::nodal_weights(line_.places, mesh);
    const auto places = static_cast<int>(weights.rows());
    std::map<int, int> number;
    row_start_ = num_nodes_ = {0};
    for (int k = 0; k < places; ++k) {
        for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator entry(weights, k); entry; ++entry) {
            const auto node = static_cast<int>(entry.col());
            const auto [found, is_new] = number.try_emplace(node, static_cast<int>(nodes_.size()));
            if (is_new) {
                const bool is_constrained = !conditions.displacement[node].array().isNaN().any();
                nodes_.push_back(node);
                per_mass_.push_back(is_constrained ? 0.0 : 1.0 / node_mass[node]);
            }
            column_.push_back(found->second);
            weight_.push_back(entry.value());
        }
        row_start_.push_back(static_cast<int>(column_.size()));
        num_nodes_.push_back(static_cast<int>(nodes_.size()));
    }
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(places, static_cast<Index>(nodes_.size()));
    for (int k = 0; k < places; ++k)
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            dense(k, column_[e]) = weight_[e];
    per_mass_places_ =
        dense * Eigen::Map<const Eigen::VectorXd>(per_mass_.data(), dense.cols()).asDiagonal() * dense.transpose();
    for (int k = 0; k < places; ++k) {
        int first = 0;
        while (first < k && per_mass_places_(k, first) == 0.0)
            ++first;
        band_.push_back(first);
    }
    of_nodes_.resize(nodes_.size());
    for (auto *field : {&u_, &before_, &impulses_, &change_})
        field->setZero(places, 3);
    for (auto *field : {&right_, &low_, &high_, &impulse_})
        field->setZero(places + 1);
    stuck_at_.setConstant(places, no_number);
    hold_.setZero(places, 2);
}

void MovingNeedle::begin(const FastSteps &steps) {
    depth_ = tip_ = deepest_ = force_ = tip_force_ = 0.0;
    is_punctured_ = false;
    num_held_ = num_read_ = 0;
    stuck_at_.setConstant(no_number);
    within_limits_.forget();
    work_ = {};
    read(steps, num_active());
    before_ = u_;
    num_read_ = num_active();
    depth_ = u_(0, 0);
}

int MovingNeedle::num_active() const {
    return std::min(static_cast<int>(u_.rows()), static_cast<int>(tip_ / line_.spacing) + 1 + places_ahead);
}

/// The displacements of the first places.
void MovingNeedle::read(const FastSteps &steps, int active) {
    const auto count = static_cast<std::size_t>(num_nodes_[active]);
    steps.displacements(std::span(nodes_).first(count), std::span(of_nodes_).first(count));
    for (int k = 0; k < active; ++k) {
        core::Vector3 mean = core::Vector3::Zero();
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            mean += weight_[e] * of_nodes_[column_[e]];
        u_.row(k) = frame_ * mean;
    }
}

/// What depends on the length of steps alone.
void MovingNeedle::prepare(double time_step) {
    if (time_step == time_step_)
        return;
    time_step_ = time_step;
    softness_ = 1.0 / (time_step * core::needle_stiffness * (time_step + needle_damping_time));
    Eigen::MatrixXd matrix = per_mass_places_;
    matrix.diagonal().array() += softness_;
    across_factor_.compute(matrix);
    along_.resize(matrix.rows() + 1, matrix.rows() + 1);
    along_.bottomRightCorner(matrix.rows(), matrix.rows()) = matrix;
}

/// What the tip exerts before it moves on [N].
double MovingNeedle::largest_tip_force() const {
    if (tip_ < deepest_)
        return 0.0; // in its own hole
    return is_punctured_ ? needle_.tip_force() : needle_.puncture_force;
}

/// Where the tip is, of a field along the axis.
double MovingNeedle::along_tip(const Row &field) const {
    const auto [below, part] = core::point_of_line(line_, tip_);
    return part * field(below, 0) + (1.0 - part) * field(below + 1, 0);
}

/// The impulses along the axis, of the tip and of the first places of the shaft.
void MovingNeedle::find_along(int touched, double depth, double time_step) {
    const auto [below, part] = core::point_of_line(line_, tip_);
    const Index count = touched + 1;
    along_.row(0).segment(1, touched) =
        part * per_mass_places_.row(below).head(touched) + (1.0 - part) * per_mass_places_.row(below + 1).head(touched);
    along_.col(0).segment(1, touched) = along_.row(0).segment(1, touched).transpose();
    along_(0, 0) = softness_ + part * part * per_mass_places_(below, below) +
                   2.0 * part * (1.0 - part) * per_mass_places_(below, below + 1) +
                   (1.0 - part) * (1.0 - part) * per_mass_places_(below + 1, below + 1);
    // -b (h k e + h k tau v) with v = (change of e) / h, since h k + k tau = 1 / (b h).
    const double of_place = softness_ * core::needle_stiffness;
    const double lead = depth - depth_;
    const auto wanted = [&](double gap, double change) {
        return -of_place * (time_step * gap + needle_damping_time * change);
    };
    right_[0] = wanted(tip_ + along_tip(u_) - depth, along_tip(u_) - along_tip(before_) - lead);
    low_[0] = 0.0;
    high_[0] = time_step * largest_tip_force();
    for (int k = 0; k < touched; ++k) {
        if (std::isnan(stuck_at_[k]))
            stuck_at_[k] = before_(k, 0) - depth_;
        right_[k + 1] = wanted(u_(k, 0) - depth - stuck_at_[k], u_(k, 0) - before_(k, 0) - lead);
        high_[k + 1] = time_step * needle_.friction * core::shaft_length(line_, k, tip_);
        low_[k + 1] = -high_[k + 1];
    }
    impulse_.head(count) = within_limits_.solve(along_.topLeftCorner(count, count), right_.head(count),
                                                low_.head(count), high_.head(count));
    impulses_.col(0).setZero();
    impulses_.col(0).head(touched) = impulse_.segment(1, touched);
    impulses_(below, 0) += part * impulse_[0];
    impulses_(below + 1, 0) += (1.0 - part) * impulse_[0];
}

/// Those across it.
void MovingNeedle::find_across(int held, double time_step) {
    impulses_.rightCols<2>().setZero();
    if (held == 0)
        return;
    auto right = impulses_.topRightCorner(held, 2);
    right = -softness_ * core::needle_stiffness *
            (time_step * (u_.topRightCorner(held, 2) - hold_.topRows(held)) +
             needle_damping_time * (u_.topRightCorner(held, 2) - before_.topRightCorner(held, 2)));
    // The factor of the first places is the first part of that of all.
    const auto &factor = across_factor_.matrixLLT();
    for (int column = 1; column < 3; ++column) {
        for (int i = 0; i < held; ++i) {
            double sum = impulses_(i, column);
            for (int j = band_[i]; j < i; ++j)
                sum -= factor(i, j) * impulses_(j, column);
            impulses_(i, column) = sum / factor(i, i);
        }
        for (int i = held - 1; i >= 0; --i) {
            impulses_(i, column) /= factor(i, i);
            for (int j = band_[i]; j < i; ++j)
                impulses_(j, column) -= factor(i, j) * impulses_(i, column);
        }
    }
}

/// Gives the nodes what the impulses are, and the places what that makes of them.
void MovingNeedle::kick(FastSteps &steps, int active, double time_step) {
    const auto count = static_cast<std::size_t>(num_nodes_[active]);
    std::fill_n(of_nodes_.begin(), count, core::Vector3::Zero());
    for (int k = 0; k < active; ++k) {
        const core::Vector3 impulse = frame_.transpose() * impulses_.row(k).transpose();
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            of_nodes_[column_[e]] += weight_[e] * impulse;
    }
    for (std::size_t i = 0; i < count; ++i)
        of_nodes_[i] *= per_mass_[i];
    steps.kick(std::span(nodes_).first(count), std::span(of_nodes_).first(count), time_step);
    change_.topRows(active).setZero();
    for (int k = 0; k < active; ++k)
        for (int j = band_[k]; j <= k; ++j) {
            const double each = per_mass_places_(k, j);
            change_.row(k) += each * impulses_.row(j);
            if (j < k)
                change_.row(j) += each * impulses_.row(k);
        }
    u_.topRows(active) += time_step * change_.topRows(active);
}

/// The tip moves on as far as it tears the tissue, and both ways in its own hole.
void MovingNeedle::move_tip(double time_step, bool tears) {
    const auto [below, part] = core::point_of_line(line_, tip_);
    const double overlap = depth_ - tip_ - along_tip(u_);
    const double length = std::max(least_length, 1.0 + (u_(below + 1, 0) - u_(below, 0)) / line_.spacing);
    const double most = farthest_in_step * line_.spacing;
    if (tears) {
        const double left = impulse_[0] / time_step / core::needle_stiffness;
        tip_ += std::clamp((overlap - left) / length, 0.0, most);
    } else if (tip_ < deepest_ || (overlap < 0.0 && impulse_[0] <= 0.0)) {
        tip_ = std::clamp(tip_ + std::clamp(overlap / length, -most, most), 0.0, deepest_);
    }
    tip_ = std::min(tip_, line_.spacing * static_cast<double>(line_.places.size() - 1));
    deepest_ = std::max(deepest_, tip_);
}

/// What sticks where, from now on.
void MovingNeedle::move_on(int touched, int active, double time_step) {
    const bool tears = tip_ >= deepest_ && impulse_[0] > 0.0 && impulse_[0] >= high_[0];
    if (tears)
        is_punctured_ = true;
    for (int k = 0; k < touched; ++k)
        if (std::abs(impulse_[k + 1]) >= high_[k + 1]) // it slides
            stuck_at_[k] = u_(k, 0) - depth_ + impulse_[k + 1] / time_step / core::needle_stiffness;
    move_tip(time_step, tears);
    for (int k = 0; k < static_cast<int>(stuck_at_.size()) && k < active + 1; ++k)
        if (core::shaft_length(line_, k, tip_) <= 0.0)
            stuck_at_[k] = no_number;
    const bool touches = tip_ > 0.0 || impulse_[0] > 0.0;
    const int held = touches ? static_cast<int>(tip_ / line_.spacing + needle_rounding) + 1 : 0;
    for (int k = num_held_; k < held; ++k)
        hold_.row(k) = u_.row(k).tail<2>();
    num_held_ = held;
}

void MovingNeedle::act(FastSteps &steps, double depth, double time_step) {
    prepare(time_step);
    const int active = num_active();
    read(steps, active);
    for (int k = num_read_; k < active; ++k)
        before_.row(k) = u_.row(k);
    int touched = 0;
    while (touched < active && core::shaft_length(line_, touched, tip_) > 0.0)
        ++touched;
    find_along(touched, depth, time_step);
    find_across(num_held_, time_step);
    kick(steps, active, time_step);
    if (!u_.topRows(active).allFinite()) { // the body has diverged
        force_ = tip_force_ = no_number;
        depth_ = depth;
        return;
    }

    // What the needle gives the tissue goes with the motion of the step.
    const double lead = depth - depth_;
    double along = 0.0, across = 0.0;
    for (int k = 0; k < active; ++k) {
        const auto moved = u_.row(k) - before_.row(k);
        along += impulses_(k, 0) * moved[0];
        across += impulses_(k, 1) * moved[1] + impulses_(k, 2) * moved[2];
    }
    const double total = impulses_.col(0).head(active).sum(), tip = impulse_[0] / time_step;
    const double torn = tip * (lead - (along_tip(u_) - along_tip(before_)));
    force_ = total / time_step;
    tip_force_ = tip;
    work_.hand += force_ * lead;
    work_.tearing += torn;
    work_.friction += force_ * lead - along / time_step - torn;
    work_.holding -= across / time_step;

    depth_ = depth;
    move_on(touched, active, time_step);
    before_.topRows(active) = u_.topRows(active);
    num_read_ = active;
}

void MovingNeedle::add_impulses(std::span<core::Vector3> sum) const {
    for (std::size_t k = 0; k < sum.size(); ++k)
        sum[k] += frame_.transpose() * impulses_.row(static_cast<Index>(k)).transpose();
}

core::Vector3 MovingNeedle::target_displacement(const FastSteps &steps) const {
    core::Vector3 mean = core::Vector3::Zero();
    for (int e = row_start_[line_.target]; e < row_start_[line_.target + 1]; ++e)
        mean += weight_[e] * steps.displacement(nodes_[column_[e]]);
    return mean;
}

} // namespace livermark::msm
