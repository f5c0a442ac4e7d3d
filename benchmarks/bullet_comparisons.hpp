#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "interactive/scene.hpp"

namespace livermark::benchmarks {

/// What an interactive method and Bullet both move: a body that is constrained at its back, stretched by 1 % along x
/// and let go from rest.
struct MovingScene {
    interactive::Scene scene;
    interactive::Field start;   ///< shape (3, N) [m]
    interactive::Field targets; ///< shape (3, C) of the constrained nodes, where they start [m]
};

MovingScene make_moving_scene(const std::shared_ptr<const core::Body> &body);

/// One that does the same work again and again.
struct Side {
    std::function<void()> reset; ///< back to the start
    std::function<void()> work;  ///< one step, or one evaluation of forces
    /// Positions after a step [m], less those at the start, or forces [N]. shape (3, N)
    std::function<interactive::Field()> result;
};

struct Sides {
    Side ours, bullet;
};

/// The same work by a method of ours and by Bullet.
struct Comparison {
    std::string name;
    int iterations = 1; ///< in what is timed
    /// @param is_check  with as many iterations as make both come to one result
    std::function<Sides(const MovingScene &, bool is_check)> make;
    double tolerance = 0.0; ///< of the difference between these results, relative to ours
};

std::vector<Comparison> bullet_comparisons();

/// How far the result of Bullet is from ours after the work is done once, relative to ours.
double difference(const Sides &sides);

} // namespace livermark::benchmarks
