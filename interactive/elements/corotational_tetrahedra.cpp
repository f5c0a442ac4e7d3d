#include "interactive/elements/corotational_tetrahedra.hpp"

#include <utility>

#include "interactive/elements/energies.hpp"
#include "interactive/kernels/corotational_steps.hpp"

namespace livermark::interactive {

core::Vector3 ImplicitContact::linearise_at(Point &point, const core::Vector3 &x) const {
    point.stiffness.setZero();
    point.force.setZero();
    const core::Vector3 from_centre = x - step_.to;
    const auto gap = core::gap_to(step_.shape, from_centre);
    const double depth = -gap.size;
    if (depth <= 0.0 || gap.distance == 0.0)
        return core::Vector3::Zero();
    const core::Vector3 &normal = gap.normal;
    const double size = depth / point.compliance;
    point.stiffness = normal * normal.transpose() / point.compliance;
    point.force = normal * ((depth + normal.dot(x - point.start)) / point.compliance);
    if (step_.friction == 0.0)
        return size * normal;
    const auto across = [&](const core::Vector3 &v) { return core::Vector3(v - normal.dot(v) * normal); };
    const core::Vector3 ball_way = step_.to - step_.from;
    const core::Vector3 sticking = across(point.before) - across(x - point.start - ball_way) / point.compliance;
    const double length = sticking.norm(), limit = step_.friction * size;
    const double share = length > limit ? limit / length : 1.0;
    point.stiffness += share / point.compliance * (Matrix3::Identity() - normal * normal.transpose());
    point.force += share * (across(point.before) + across(ball_way) / point.compliance);
    return size * normal + share * sticking;
}

CorotationalTetrahedra::CorotationalTetrahedra(Scene given)
    : SimulationInRows(std::move(given)), energy_(tetrahedra_at_rest(*scene().body)),
      rows_(kernels::corotational_rows(scene())) {}

bool CorotationalTetrahedra::touch(const std::shared_ptr<core::BallContact> &ball) {
    rows_.touched.clear();
    return SimulationInRows::touch(ball);
}

/// Solves until what touches and slips is what was solved for.
void CorotationalTetrahedra::step_touched(double time_step, int iterations) {
    constexpr int most_solutions = 5;
    const auto displacement = rows_.body.displacement, velocity = rows_.body.velocity;
    bool is_solved = false;
    // Nodes are where their velocities lead, and once solved, where they are.
    const auto now = [&](int node) -> core::Vector3 {
        const core::Vector3 there = row_position(node);
        return is_solved ? there : core::Vector3(there + time_step * in_row(velocity, row_of(node)).cast<double>());
    };
    contact_.begin(*ball_, [&](int node) { return positions().col(node); });
    contact_.linearise(now);
    for (int s = 0; s < most_solutions; ++s) {
        rows_.body.displacement = displacement;
        rows_.body.velocity = velocity;
        put_touched_into_rows();
        kernels::take_corotational_step(rows_, time_step, scene().mass_damping, iterations);
        is_solved = true;
        if (!contact_.linearise(now))
            break;
    }
    contact_.finish(*ball_, now);
    ball_->end_step(time_step);
}

void CorotationalTetrahedra::put_touched_into_rows() {
    rows_.touched.clear();
    for (const auto &point : contact_.points()) {
        if (point.stiffness.isZero(0.0))
            continue;
        auto &kept = rows_.touched.emplace_back();
        for (std::size_t k = 0; k < 3; ++k) {
            kept.rows[k] = rows_.body.row_of_node[point.nodes[k]];
            kept.shape[k] = static_cast<float>(point.shape[k]);
            kept.force[k] = static_cast<float>(point.force[static_cast<Eigen::Index>(k)]);
        }
        std::size_t entry = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = i; j < 3; ++j)
                kept.stiffness[entry++] = static_cast<float>(point.stiffness(i, j));
    }
}

void CorotationalTetrahedra::step(double time_step, int iterations) {
    rows_.body.aim_constrained(scene(), rest_, positions(), targets(), time_step);
    if (ball_)
        step_touched(time_step, iterations);
    else
        kernels::take_corotational_step(rows_, time_step, scene().mass_damping, iterations);
    take_state_from_rows();
}

} // namespace livermark::interactive
