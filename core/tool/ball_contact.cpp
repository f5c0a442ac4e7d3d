#include "core/tool/ball_contact.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/tool/tool_motion.hpp"

namespace livermark::core {

namespace {

/// Of the radius: nodes within it beyond the ball may be touched, whatever they did before.
constexpr double reach_of_ball = 0.25;
/// Of what nodes around the ball have moved by before.
constexpr double ahead_of_nodes = 2.0;
/// Of the radius: what counts as around the ball.
constexpr double around_ball = 3.0;

/// Away from the ball; where the point is at its centre, to where it was before.
Vector3 outwards(const BallStep &ball, const Vector3 &start, const Vector3 &now) {
    for (const Vector3 &way : {Vector3(now - ball.to), Vector3(start - ball.from), Vector3(ball.from - ball.to)})
        if (const double length = way.norm(); length > 0.0)
            return way / length;
    return Vector3::UnitZ();
}

double distance_to_way(const Vector3 &from, const Vector3 &to, const Vector3 &point) {
    const Vector3 way = to - from;
    const double squared = way.squaredNorm();
    const double part = squared > 0.0 ? std::clamp((point - from).dot(way) / squared, 0.0, 1.0) : 0.0;
    return (point - from - part * way).norm();
}

} // namespace

Vector3 ball_push(const BallStep &ball, const Vector3 &start, const Vector3 &now, const Vector3 &pushed) {
    const double depth = ball.radius - (now - ball.to).norm();
    if (depth <= 0.0 && pushed.isZero(0.0))
        return Vector3::Zero();
    const Vector3 normal = outwards(ball, start, now);
    const double size = pushed.dot(normal) + depth;
    if (size <= 0.0)
        return Vector3::Zero();
    Vector3 along = pushed - ((now - start) - (ball.to - ball.from));
    along -= along.dot(normal) * normal;
    const double length = along.norm(), largest = ball.friction * size;
    if (length > largest)
        along *= largest / length;
    return size * normal + along;
}

NodeUnderBall rest_under_ball(const BallStep &ball, const Vector3 &start, const Vector3 &now, const Vector3 &minimum,
                              const Eigen::Matrix3d &stiffness) {
    if ((minimum - ball.to).norm() >= ball.radius)
        return {minimum, Vector3::Zero()};
    const Vector3 normal = outwards(ball, start, now);
    const auto to_plane = [&](const Vector3 &point) { return ball.radius - normal.dot(point - ball.to); };
    const auto along = [&](const Vector3 &force) { return Vector3(force - normal.dot(force) * normal); };
    const Eigen::Matrix3d compliance = stiffness.inverse();
    Vector3 direction = normal; // of the force
    if (ball.friction > 0.0) {
        const Vector3 stuck = start + (ball.to - ball.from);
        const Vector3 held = stuck + to_plane(stuck) * normal;
        const Vector3 force = stiffness * (held - minimum), friction = along(force);
        const double largest = ball.friction * std::max(0.0, normal.dot(force));
        if (friction.norm() <= largest)
            return {held, force};
        direction += ball.friction * friction.normalized();
    }
    const double yields = normal.dot(compliance * direction), way = to_plane(minimum);
    if (!(yields > 0.0) || !(way > 0.0)) // the plane of another iteration
        return {minimum + std::max(0.0, way) * normal, Vector3::Zero()};
    const Vector3 force = way / yields * direction;
    return {minimum + compliance * force, force};
}

Vector3 ball_centre(const TouchingTool &ball, const ToolMotion &motion, double time) {
    const auto position = tool_position(motion, time);
    return ball.start + position.pressed * ball.press + position.slid * motion.slide;
}

BallContact::BallContact(std::vector<int> nodes, double radius, double friction)
    : nodes_(std::move(nodes)), radius_(radius), friction_(friction) {}

void BallContact::set_way(const Vector3 &from, const Vector3 &to) {
    from_ = from;
    to_ = to;
}

BallStep BallContact::part(int step, int num_steps) const {
    const Vector3 way = (to_ - from_) / num_steps;
    return {from_ + step * way, step + 1 == num_steps ? to_ : Vector3(from_ + (step + 1) * way), radius_, friction_};
}

Vector3 BallContact::take_impulse() {
    return std::exchange(impulse_, Vector3::Zero());
}

void BallContact::choose_near(std::vector<Vector3> now) {
    std::vector<double> distance;
    distance.reserve(now.size());
    for (const auto &point : now)
        distance.push_back(distance_to_way(from_, to_, point));
    double moved = 0.0;
    for (std::size_t i = 0; i < before_.size(); ++i)
        if (distance[i] < around_ball * radius_)
            moved = std::max(moved, (now[i] - before_[i]).norm());
    near_.clear();
    for (std::size_t i = 0; i < now.size(); ++i)
        if (distance[i] < (1.0 + reach_of_ball) * radius_ + ahead_of_nodes * moved)
            near_.push_back(nodes_[i]);
    before_ = std::move(now);
}

std::vector<int> touchable_nodes(const TetraMesh &mesh, const LoadCase &load_case) {
    enum : std::uint8_t { inside, touchable, held };
    std::vector<std::uint8_t> kind(mesh.points.size(), inside);
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        for (const int node : mesh.boundary_triangles[f])
            kind[node] = std::max<std::uint8_t>(kind[node], load_case.may_touch(f) ? touchable : held);
    std::vector<int> nodes;
    for (std::size_t node = 0; node < kind.size(); ++node)
        if (kind[node] == touchable)
            nodes.push_back(static_cast<int>(node));
    return nodes;
}

} // namespace livermark::core
