#include "core/tool/ball_contact.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/tool/tool_motion.hpp"

namespace livermark::core {

namespace {

/// Part of its reach, the radius of a ball: nodes within it beyond the ball may be touched, whatever they did before.
constexpr double reach_of_ball = 0.25;
/// Multiple of what nodes around the ball have moved by before.
constexpr double ahead_of_nodes = 2.0;
/// Multiple of its reach: what counts as around the ball.
constexpr double around_ball = 3.0;

/// Away from the ball; where the point is at its centre, to where it was before.
Vector3 outwards(const BallStep &ball, const Vector3 &start, const Vector3 &now) {
    for (const Vector3 &way : {Vector3(now - ball.to), Vector3(start - ball.from), Vector3(ball.from - ball.to)})
        if (const double length = way.norm(); length > 0.0)
            return way / length;
    return Vector3::UnitZ();
}

/// 1 / (eps A) [m/N]
double compliance_of(const TouchedFacet &facet, double circle) {
    return 1.0 / (facet.penalty(circle) * facet.area);
}

double distance_to_way(const Vector3 &from, const Vector3 &to, const Vector3 &point) {
    const Vector3 way = to - from;
    const double squared = way.squaredNorm();
    const double part = squared > 0.0 ? std::clamp((point - from).dot(way) / squared, 0.0, 1.0) : 0.0;
    return (point - from - part * way).norm();
}

} // namespace

Vector3 ball_force(const BallStep &ball, const Vector3 &start, const Vector3 &now, const Vector3 &force,
                   const Eigen::Matrix3d &yields, double compliance) {
    const auto gap = gap_to(ball.shape, now - ball.to);
    const double depth = -gap.size;
    const Vector3 normal = ball.shape.is_plate() ? gap.normal : outwards(ball, start, now);
    const double before = force.dot(normal), gives_way = normal.dot(yields * normal) + compliance;
    if (!(gives_way > 0.0))
        return Vector3::Zero(); // held, and nothing can be done about it
    const double size = before + (depth - compliance * before) / gives_way;
    if (size <= 0.0)
        return Vector3::Zero();
    if (ball.friction == 0.0)
        return size * normal;
    // With what the new N displaces it by.
    Vector3 way = (now - start) - (ball.to - ball.from) + yields * ((size - before) * normal);
    way -= way.dot(normal) * normal;
    Vector3 along = force - before * normal;
    if (const double length = way.norm(); length > 0.0)
        if (const double unit_response = way.dot(yields * way) / (length * length); unit_response > 0.0)
            along -= way / unit_response;
    const double length = along.norm();
    if (length <= ball.friction * size)
        return size * normal + along;
    // It slips, so that the whole force is along this.
    const Vector3 direction = normal + ball.friction / length * along;
    const double slip_response = normal.dot(yields * direction) + compliance;
    if (!(slip_response > 0.0))
        return size * direction;
    return std::max(0.0, (depth + normal.dot(yields * force)) / slip_response) * direction;
}

Vector3 ball_centre(const TouchingTool &ball, const ToolMotion &motion, double time) {
    const auto position = tool_position(motion, time);
    return ball.start + position.pressed * ball.press + position.slid * motion.slide;
}

double circle_of_contact(const TouchingTool &ball, const ToolMotion &motion, double time) {
    return ball.shape.contact_radius(tool_position(motion, time).pressed * ball.press.norm());
}

BallContact::BallContact(const std::vector<TouchedFacet> &facets, int divisions, const ToolShape &shape,
                         double friction)
    : points_(facet_points(divisions)), force_(facets.size() * points_.size(), Vector3::Zero()), shape_(shape),
      friction_(friction) {
    for (const auto &facet : facets)
        nodes_.insert(nodes_.end(), facet.nodes.begin(), facet.nodes.end());
    std::ranges::sort(nodes_);
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    for (const auto &facet : facets) {
        auto &kept = facets_.emplace_back(Facet{.touched = facet, .compliance = compliance_of(facet, circle_)});
        for (std::size_t k = 0; k < 3; ++k)
            kept.places[k] = static_cast<int>(std::ranges::lower_bound(nodes_, facet.nodes[k]) - nodes_.begin());
    }
}

void BallContact::set_circle(double circle) {
    if (circle == circle_)
        return;
    circle_ = circle;
    for (auto &facet : facets_)
        facet.compliance = compliance_of(facet.touched, circle);
}

void BallContact::set_way(const Vector3 &from, const Vector3 &to) {
    from_ = from;
    to_ = to;
}

BallStep BallContact::part(int step, int num_steps) const {
    const Vector3 way = (to_ - from_) / num_steps;
    return {from_ + step * way, step + 1 == num_steps ? to_ : Vector3(from_ + (step + 1) * way), shape_, friction_};
}

Vector3 BallContact::force() const {
    Vector3 sum = Vector3::Zero();
    for (const int f : near_)
        for (std::size_t q = 0; facets_[f].is_pushed && q < points_.size(); ++q)
            sum += force_[number(f, q)];
    return sum;
}

Vector3 BallContact::take_impulse() {
    return std::exchange(impulse_, Vector3::Zero());
}

bool BallContact::is_beyond(const BallStep &step, const std::array<Vector3, 3> &corners) {
    const Vector3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
    double extent = 0.0;
    for (const auto &corner : corners)
        extent = std::max(extent, (corner - middle).squaredNorm());
    return is_outside(step.shape, middle - step.to, std::sqrt(extent));
}

void BallContact::choose_near(std::vector<Vector3> now) {
    double moved = 0.0;
    for (std::size_t i = 0; i < before_.size(); ++i)
        if (distance_to_way(from_, to_, now[i]) < around_ball * shape_.reach())
            moved = std::max(moved, (now[i] - before_[i]).norm());
    const double reach = (1.0 + reach_of_ball) * shape_.reach() + ahead_of_nodes * moved;
    near_.clear();
    near_nodes_.clear();
    for (std::size_t f = 0; f < facets_.size(); ++f) {
        auto &facet = facets_[f];
        Vector3 middle = Vector3::Zero();
        for (const int place : facet.places)
            middle += now[place] / 3.0;
        double extent = 0.0;
        for (const int place : facet.places)
            extent = std::max(extent, (now[place] - middle).norm());
        if (distance_to_way(from_, to_, middle) < reach + extent) {
            near_.push_back(static_cast<int>(f));
            near_nodes_.insert(near_nodes_.end(), facet.touched.nodes.begin(), facet.touched.nodes.end());
        } else if (facet.is_pushed) {
            std::fill_n(force_.begin() + static_cast<std::ptrdiff_t>(number(static_cast<int>(f), 0)), points_.size(),
                        Vector3::Zero());
            facet.is_pushed = false;
        }
    }
    std::ranges::sort(near_nodes_);
    near_nodes_.erase(std::unique(near_nodes_.begin(), near_nodes_.end()), near_nodes_.end());
    before_ = std::move(now);
}

} // namespace livermark::core
