#include "core/tool/needle/moving_needle.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "core/tool/needle/needle.hpp"

namespace livermark::core {

namespace {

constexpr double spacing_over_radius = 1.0 / 3.0;
/// Beyond the target, so that the tissue before the tip is there; the tip itself never gets there.
constexpr int places_beyond = 2;

} // namespace

NeedleLine needle_line(const Needle &needle) {
    NeedleLine line;
    line.target = std::max(2, static_cast<int>(std::ceil(needle.depth() / (spacing_over_radius * needle.spread))));
    line.spacing = needle.depth() / line.target;
    for (int k = 0; k <= line.target + places_beyond; ++k)
        line.places.push_back({needle.entry + k * line.spacing * needle.direction(), needle.spread});
    return line;
}

double smallest_spread(const Needle &needle, const TetraMesh &mesh) {
    Eigen::AlignedBox3d way(needle.entry);
    way.extend(needle.target);
    way.min().array() -= needle.spread;
    way.max().array() += needle.spread;
    double longest = 0.0;
    for (const auto &nodes : mesh.tetrahedra) {
        Eigen::AlignedBox3d box;
        for (const int node : nodes)
            box.extend(mesh.points[node]);
        if (box.intersects(way))
            for (const auto &[i, j] : tetrahedron_edges)
                longest = std::max(longest, (mesh.points[nodes[i]] - mesh.points[nodes[j]]).norm());
    }
    // A third of the radius is inside, a point of a part is within three quarters of its edge of the centroid, and the
    // parts in the middle of a tetrahedron have edges of up to the root of two times the others.
    return 3.0 * 0.75 * std::sqrt(2.0) * longest / 64.0;
}

double shaft_length(const NeedleLine &line, int place, double tip) {
    const double position = tip / line.spacing - place; // of the tip, from the place on
    const double before = std::clamp(position + 1.0, 0.0, 1.0), behind = std::clamp(position, 0.0, 1.0);
    const bool is_first = place == 0, is_last = place + 1 == static_cast<int>(line.places.size());
    return line.spacing * ((is_first ? 0.0 : 0.5 * before * before) + (is_last ? 0.0 : behind - 0.5 * behind * behind));
}

PointOfLine point_of_line(const NeedleLine &line, double point) {
    const int last = static_cast<int>(line.places.size()) - 1;
    const double position = std::clamp(point / line.spacing, 0.0, static_cast<double>(last));
    const int below = std::min(static_cast<int>(position), last - 1);
    return {below, 1.0 - (position - below)};
}

namespace {

using Eigen::Index;

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
/// Places before the tip whose displacement is known as well, so that a tip that moves on finds it.
constexpr int places_ahead = 3;
/// Rounding of lengths over the spacing.
constexpr double needle_rounding = 1e-9;
/// Parts of the spacing that the tip moves on at most in a step, and to which tissue before it is compressed at most:
/// nothing that moves slowly comes near them.
constexpr double farthest_in_step = 0.5, least_length = 0.2;

/// Two directions across an axis, and the axis itself, as rows.
Eigen::Matrix3d needle_frame(const Vector3 &axis) {
    Eigen::Matrix3d frame;
    frame.row(0) = axis;
    frame.row(1) = axis.unitOrthogonal();
    frame.row(2) = axis.cross(frame.row(1).transpose());
    return frame;
}

} // namespace

PlaceWeights place_weights(const Needle &needle, const TetraMesh &mesh) {
    return nodal_weights(needle_line(needle).places, mesh);
}

MovingNeedle::MovingNeedle(const Needle &needle, const PlaceWeights &weights)
    : needle_(needle), line_(needle_line(needle)), frame_(needle_frame(needle.direction())) {
    const auto places = static_cast<int>(weights.rows());
    std::map<int, int> number;
    row_start_ = num_nodes_ = {0};
    for (int k = 0; k < places; ++k) {
        for (PlaceWeights::InnerIterator entry(weights, k); entry; ++entry) {
            const auto node = static_cast<int>(entry.col());
            const auto [found, is_new] = number.try_emplace(node, static_cast<int>(nodes_.size()));
            if (is_new)
                nodes_.push_back(node);
            column_.push_back(found->second);
            weight_.push_back(entry.value());
        }
        row_start_.push_back(static_cast<int>(column_.size()));
        num_nodes_.push_back(static_cast<int>(nodes_.size()));
    }
    node_values_.resize(nodes_.size());
    for (auto *field : {&u_, &before_, &impulses_, &last_, &change_})
        field->setZero(places, 3);
    for (auto *field : {&right_, &low_, &high_, &impulse_})
        field->setZero(places + 1);
    stuck_at_.setConstant(places, no_number);
    hold_.setZero(places, 2);
}

MovingNeedle::MovingNeedle(const Needle &needle, const TetraMesh &mesh, const std::vector<double> &per_mass)
    : MovingNeedle(needle, place_weights(needle, mesh)) {
    for (const int node : nodes_)
        per_mass_.push_back(per_mass[static_cast<std::size_t>(node)]);
    const Index places = u_.rows();
    Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(places, static_cast<Index>(nodes_.size()));
    for (Index k = 0; k < places; ++k)
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            dense(k, column_[e]) = weight_[e];
    places_[0] =
        dense * Eigen::Map<const Eigen::VectorXd>(per_mass_.data(), dense.cols()).asDiagonal() * dense.transpose();
    for (Index k = 0; k < places; ++k) {
        int first = 0;
        while (first < k && places_[0](k, first) == 0.0)
            ++first;
        band_.push_back(first);
    }
}

MovingNeedle::MovingNeedle(const Needle &needle, const PlaceWeights &weights, Eigen::MatrixXf columns)
    : MovingNeedle(needle, weights) {
    band_.assign(static_cast<std::size_t>(u_.rows()), 0);
    all_nodes_.resize(static_cast<std::size_t>(columns.rows() / 3));
    std::iota(all_nodes_.begin(), all_nodes_.end(), 0);
    velocities_.resize(all_nodes_.size());
    nodal_forces_.assign(nodes_.size(), Vector3::Zero());
    respond_by(std::move(columns));
}

void MovingNeedle::respond_by(Eigen::MatrixXf columns) {
    columns_ = std::move(columns);
    time_step_ = 0.0; // factors are of what was before
    const Index places = u_.rows();
    for (auto &matrix : places_)
        matrix.resize(places, places);
    for (Index k = 0; k < places; ++k)
        for (Index j = 0; j < places; ++j) {
            Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
            for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
                block += weight_[e] * columns_.block<3, 3>(3 * nodes_[column_[e]], 3 * j).cast<double>();
            const Eigen::Matrix3d turned = frame_ * block * frame_.transpose();
            for (int c = 0; c < 3; ++c)
                places_[static_cast<std::size_t>(c)](k, j) = turned(c, c);
        }
    for (auto &matrix : places_) // solvers leave a rounding
        matrix = (0.5 * (matrix + matrix.transpose())).eval();
}

void MovingNeedle::begin(const MovingNodes &body) {
    depth_ = tip_ = deepest_ = force_ = tip_force_ = 0.0;
    is_punctured_ = false;
    num_held_ = num_read_ = num_lasting_ = 0;
    stuck_at_.setConstant(no_number);
    last_.setZero();
    nodal_forces_.assign(nodal_forces_.size(), Vector3::Zero());
    within_limits_.forget();
    work_ = {};
    read(body, num_active());
    before_ = u_;
    num_read_ = num_active();
    depth_ = u_(0, 0);
}

int MovingNeedle::num_active() const {
    return std::min(static_cast<int>(u_.rows()), static_cast<int>(tip_ / line_.spacing) + 1 + places_ahead);
}

/// @param node_values  of nodes_, as many as the place has
Vector3 MovingNeedle::mean_over(int place, const std::vector<Vector3> &node_values) const {
    Vector3 mean = Vector3::Zero();
    for (int e = row_start_[place]; e < row_start_[place + 1]; ++e)
        mean += weight_[e] * node_values[column_[e]];
    return mean;
}

/// The displacements of the first places.
void MovingNeedle::read(const MovingNodes &body, int active) {
    const auto count = static_cast<std::size_t>(num_nodes_[active]);
    body.displacements(std::span(nodes_).first(count), std::span(node_values_).first(count));
    for (int k = 0; k < active; ++k)
        u_.row(k) = frame_ * mean_over(k, node_values_);
}

/// Forces that lasted over the step, so that what is left is where the body would be without them.
void MovingNeedle::take_back(int active, double time_step) {
    for (int c = 0; c < 3; ++c)
        u_.col(c).head(active) -= time_step * (places(c).topRows(active) * last_.col(c));
}

/// Sets all that depends on the length of steps alone.
void MovingNeedle::prepare(double time_step) {
    if (time_step == time_step_)
        return;
    time_step_ = time_step;
    softness_ = 1.0 / (time_step * needle_stiffness * (time_step + needle_damping_time));
    const auto softened = [&](int direction, double softness) {
        Eigen::MatrixXd matrix = places(direction);
        matrix.diagonal().array() += softness;
        return matrix;
    };
    // Softer springs have the same damping time, so only b differs across the axis and no right-hand side.
    const double side_softness = softness_ * (1.0 + needle_stiffness * needle_.side_softness(line_.spacing));
    for (int c = 0; c < (is_lasting() ? 2 : 1); ++c)
        across_factor_[static_cast<std::size_t>(c)].compute(softened(c + 1, side_softness));
    const Index count = u_.rows();
    along_.resize(count + 1, count + 1);
    along_.bottomRightCorner(count, count) = softened(0, softness_);
}

/// Most that the tip exerts before it moves on [N].
double MovingNeedle::largest_tip_force() const {
    if (tip_ < deepest_)
        return 0.0; // in its own hole
    return is_punctured_ ? needle_.tip_force() : needle_.puncture_force;
}

/// Value of a field along the axis at the tip.
double MovingNeedle::along_tip(const Row &field) const {
    const auto [below, part] = point_of_line(line_, tip_);
    return part * field(below, 0) + (1.0 - part) * field(below + 1, 0);
}

/// The impulses along the axis, of the tip and of the first places of the shaft.
void MovingNeedle::find_along(int touched, double depth, double time_step) {
    const auto [below, part] = point_of_line(line_, tip_);
    const auto &axis_places = places(0);
    const Index count = touched + 1;
    along_.row(0).segment(1, touched) =
        part * axis_places.row(below).head(touched) + (1.0 - part) * axis_places.row(below + 1).head(touched);
    along_.col(0).segment(1, touched) = along_.row(0).segment(1, touched).transpose();
    along_(0, 0) = softness_ + part * part * axis_places(below, below) +
                   2.0 * part * (1.0 - part) * axis_places(below, below + 1) +
                   (1.0 - part) * (1.0 - part) * axis_places(below + 1, below + 1);
    // -b (h k e + h k tau v) with v = (change of e) / h, since h k + k tau = 1 / (b h).
    const double place_weight = softness_ * needle_stiffness;
    const double lead = depth - depth_;
    const auto wanted = [&](double gap, double change) {
        return -place_weight * (time_step * gap + needle_damping_time * change);
    };
    right_[0] = wanted(tip_ + along_tip(u_) - depth, along_tip(u_) - along_tip(before_) - lead);
    low_[0] = 0.0;
    high_[0] = time_step * largest_tip_force();
    for (int k = 0; k < touched; ++k) {
        if (std::isnan(stuck_at_[k]))
            stuck_at_[k] = before_(k, 0) - depth_;
        right_[k + 1] = wanted(u_(k, 0) - depth - stuck_at_[k], u_(k, 0) - before_(k, 0) - lead);
        high_[k + 1] = time_step * needle_.friction * shaft_length(line_, k, tip_);
        low_[k + 1] = -high_[k + 1];
    }
    impulse_.head(count) = within_limits_.solve(along_.topLeftCorner(count, count), right_.head(count),
                                                low_.head(count), high_.head(count));
    impulses_.col(0).setZero();
    impulses_.col(0).head(touched) = impulse_.segment(1, touched);
    impulses_(below, 0) += part * impulse_[0];
    impulses_(below + 1, 0) += (1.0 - part) * impulse_[0];
}

/// The impulses across the axis.
void MovingNeedle::find_across(int held, double time_step) {
    impulses_.rightCols<2>().setZero();
    if (held == 0)
        return;
    auto right = impulses_.topRightCorner(held, 2);
    right = -softness_ * needle_stiffness *
            (time_step * (u_.topRightCorner(held, 2) - hold_.topRows(held)) +
             needle_damping_time * (u_.topRightCorner(held, 2) - before_.topRightCorner(held, 2)));
    // The factor of the first places is the first part of that of all.
    for (int column = 1; column < 3; ++column) {
        const auto &factor = across_factor_[is_lasting() && column == 2 ? 1 : 0].matrixLLT();
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
void MovingNeedle::kick(MovingNodes &body, int active, double time_step) {
    const auto count = static_cast<std::size_t>(num_nodes_[active]);
    std::fill_n(node_values_.begin(), count, Vector3::Zero());
    for (int k = 0; k < active; ++k) {
        const Vector3 impulse = frame_.transpose() * impulses_.row(k).transpose();
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            node_values_[column_[e]] += weight_[e] * impulse;
    }
    for (std::size_t i = 0; i < count; ++i)
        node_values_[i] *= per_mass_[i];
    body.kick(std::span(nodes_).first(count), std::span(node_values_).first(count), time_step);
    change_.topRows(active).setZero();
    for (int k = 0; k < active; ++k)
        for (int j = band_[k]; j <= k; ++j) {
            const double each = places_[0](k, j);
            change_.row(k) += each * impulses_.row(j);
            if (j < k)
                change_.row(j) += each * impulses_.row(k);
        }
    u_.topRows(active) += time_step * change_.topRows(active);
}

/// The same where forces last: all nodes move by what is more than in the step before.
void MovingNeedle::kick_all(MovingNodes &body, int active, double time_step) {
    const Index last = 3 * std::max<Index>(active, num_lasting_);
    const Row in_space = impulses_ * frame_;
    const Row more = in_space - last_ * frame_;
    Eigen::Map<Eigen::VectorXd>(velocities_.front().data(), columns_.rows()) =
        (columns_.leftCols(last) * Eigen::Map<const Eigen::VectorXd>(more.data(), last).cast<float>()).cast<double>();
    body.kick(all_nodes_, velocities_, time_step);
    for (int c = 0; c < 3; ++c)
        u_.col(c).head(active) += time_step * (places(c).topRows(active) * impulses_.col(c));
    last_ = impulses_;
    num_lasting_ = active;
    nodal_forces_.assign(nodal_forces_.size(), Vector3::Zero());
    for (int k = 0; k < active; ++k)
        for (int e = row_start_[k]; e < row_start_[k + 1]; ++e)
            nodal_forces_[column_[e]] += weight_[e] / time_step * in_space.row(k).transpose();
}

/// The tip moves on as far as it tears the tissue, and both ways in its own hole.
void MovingNeedle::move_tip(double time_step, bool tears) {
    const auto [below, part] = point_of_line(line_, tip_);
    const double overlap = depth_ - tip_ - along_tip(u_);
    const double length = std::max(least_length, 1.0 + (u_(below + 1, 0) - u_(below, 0)) / line_.spacing);
    const double most = farthest_in_step * line_.spacing;
    if (tears) {
        const double left = impulse_[0] / time_step / needle_stiffness;
        tip_ += std::clamp((overlap - left) / length, 0.0, most);
    } else if (tip_ < deepest_ || (overlap < 0.0 && impulse_[0] <= 0.0)) {
        tip_ = std::clamp(tip_ + std::clamp(overlap / length, -most, most), 0.0, deepest_);
    }
    tip_ = std::min(tip_, line_.spacing * static_cast<double>(line_.places.size() - 1));
    deepest_ = std::max(deepest_, tip_);
}

/// Keeps what sticks where from this step on.
void MovingNeedle::move_on(int touched, int active, double time_step) {
    const bool tears = tip_ >= deepest_ && impulse_[0] > 0.0 && impulse_[0] >= high_[0];
    if (tears)
        is_punctured_ = true;
    for (int k = 0; k < touched; ++k)
        if (std::abs(impulse_[k + 1]) >= high_[k + 1]) // it slides
            stuck_at_[k] = u_(k, 0) - depth_ + impulse_[k + 1] / time_step / needle_stiffness;
    move_tip(time_step, tears);
    for (int k = 0; k < static_cast<int>(stuck_at_.size()) && k < active + 1; ++k)
        if (shaft_length(line_, k, tip_) <= 0.0)
            stuck_at_[k] = no_number;
    const bool touches = tip_ > 0.0 || impulse_[0] > 0.0;
    const int held = touches ? static_cast<int>(tip_ / line_.spacing + needle_rounding) + 1 : 0;
    for (int k = num_held_; k < held; ++k)
        hold_.row(k) = u_.row(k).tail<2>();
    num_held_ = held;
}

void MovingNeedle::act(MovingNodes &body, double depth, double time_step) {
    prepare(time_step);
    const int active = num_active();
    read(body, active);
    for (int k = num_read_; k < active; ++k)
        before_.row(k) = u_.row(k);
    if (is_lasting())
        take_back(active, time_step);
    int touched = 0;
    while (touched < active && shaft_length(line_, touched, tip_) > 0.0)
        ++touched;
    find_along(touched, depth, time_step);
    find_across(num_held_, time_step);
    if (is_lasting())
        kick_all(body, active, time_step);
    else
        kick(body, active, time_step);
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

std::vector<Vector3> MovingNeedle::place_displacements(const MovingNodes &body) const {
    std::vector<Vector3> node_values(nodes_.size()), result;
    body.displacements(nodes_, node_values);
    for (int k = 0; k < static_cast<int>(u_.rows()); ++k)
        result.push_back(mean_over(k, node_values));
    return result;
}

void MovingNeedle::add_impulses(std::span<Vector3> sum) const {
    for (std::size_t k = 0; k < sum.size(); ++k)
        sum[k] += frame_.transpose() * impulses_.row(static_cast<Eigen::Index>(k)).transpose();
}

Vector3 MovingNeedle::target_displacement(const MovingNodes &body) const {
    return place_displacements(body)[static_cast<std::size_t>(line_.target)];
}

} // namespace livermark::core
