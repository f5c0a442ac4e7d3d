#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <utility>
#include <vector>

#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/kernels/step_workspace.hpp"

namespace livermark::msm {

/// Selective mass scaling of steps of symplectic Euler on vector units. The kernels take a step with the
/// masses as they are, v + h a and x + h (v + h a). This puts a scaled acceleration in the place of a: that of
/// scale_acceleration(), in the precision of the forces.
template <class T> class ScaledMassSteps {
  public:
    ScaledMassSteps() = default;

    /// @param at  between steps; its scheme is symplectic Euler
    ScaledMassSteps(const MassScaling &scaling, const StepWorkspace<T> &at) {
        std::vector<std::vector<std::size_t>> copies(static_cast<std::size_t>(at.body.first_copy));
        for (std::size_t c = 0; c < at.body.copied_row.size(); ++c)
            copies[static_cast<std::size_t>(at.body.copied_row[c])].push_back(
                static_cast<std::size_t>(at.body.first_copy) + c);
        place_of_row_.resize(scaling.parts.empty() ? 0 : copies.size(), {nowhere, 0});
        for (const auto &scaled : scaling.parts) {
            std::vector<std::pair<std::size_t, Eigen::Index>> order; // as rows are in memory
            for (std::size_t i = 0; i < scaled.nodes.size(); ++i)
                order.emplace_back(static_cast<std::size_t>(at.body.row_of_node[scaled.nodes[i]]),
                                   static_cast<Eigen::Index>(i));
            std::ranges::sort(order);
            for (std::size_t i = 0; i < order.size(); ++i)
                place_of_row_[order[i].first] = {parts_.size(), i};
            parts_.push_back(make_part(scaled, order, copies));
        }
    }

    bool empty() const { return parts_.empty(); }

    /// Gives a node another mass from now on; nothing happens where it belongs to no part.
    void set_mass(std::size_t row, double mass) {
        if (row >= place_of_row_.size() || place_of_row_[row].first == nowhere)
            return;
        const auto [number, i] = place_of_row_[row];
        auto &part = parts_[number];
        if (part.mass[i] == mass)
            return;
        part.mass[i] = mass;
        part.arrays.mass[i] = static_cast<T>(mass);
        part.is_weighed = false;
    }

    /// Scales the part of a node no more.
    /// @return rows of its nodes, none if the node belongs to no part
    std::vector<std::size_t> leave(std::size_t row) {
        if (row >= place_of_row_.size() || place_of_row_[row].first == nowhere)
            return {};
        const auto number = place_of_row_[row].first;
        auto rows = std::move(parts_[number].row);
        parts_.erase(parts_.begin() + static_cast<std::ptrdiff_t>(number));
        for (auto &place : place_of_row_)
            if (place.first == number)
                place = {nowhere, 0};
            else if (place.first != nowhere && place.first > number)
                --place.first;
        return rows;
    }

    /// Moves copies of rows to where they are now.
    void move_copies(const RowMap &map) {
        for (auto &part : parts_)
            for (auto &[i, copy] : part.copies)
                copy = static_cast<std::size_t>(map.of(static_cast<int>(copy)));
    }

    /// Before a step.
    void remember(const StepWorkspace<T> &at) {
        for (auto &part : parts_)
            for (std::size_t i = 0; i < part.row.size(); ++i) {
                const auto &slice = at.nodes[part.row[i] / slice_size];
                const std::size_t lane = part.row[i] % slice_size;
                for (std::size_t c = 0; c < 3; ++c)
                    part.before[c][i] = slice.velocity.get(c, lane);
            }
    }

    /// After it.
    void correct(StepWorkspace<T> &at) {
        for (auto &part : parts_) {
            if (!part.is_weighed)
                weigh(part);
            gather(at, part);
            scale(at, part);
        }
    }

  private:
    struct Part {
        ScaledMassArrays<T> arrays;
        double factor = 1.0;
        std::vector<std::size_t> row;                            ///< (n) of each node
        std::vector<std::pair<std::size_t, std::size_t>> copies; ///< number in the part, and another row of the node
        std::array<std::vector<double>, 3> before;               ///< (n) velocities when a step began [m/s]
        std::vector<double> mass, own_mass;                      ///< (n) now, and that of the tissue alone [kg]
        double total_mass = 0.0;                                 ///< [kg]
        core::Vector3 rest_centre = core::Vector3::Zero();       ///< of masses [m]
        bool is_weighed = false;                                 ///< whether what follows is that of the masses now
        bool is_loaded = false;                                  ///< whether a mass differs from that of the tissue
        Eigen::LLT<Eigen::MatrixXd> gram;                        ///< of slow deformations in the masses now
        std::vector<double> weights;                             ///< (m)
    };

    static constexpr std::size_t nowhere = -1;

    static Part make_part(const ScaledRegion &scaled, const std::vector<std::pair<std::size_t, Eigen::Index>> &order,
                          const std::vector<std::vector<std::size_t>> &copies) {
        Part part;
        part.factor = scaled.factor;
        auto &arrays = part.arrays;
        arrays.size = static_cast<std::size_t>(padded(static_cast<int>(order.size())));
        arrays.num_slow = static_cast<std::size_t>(scaled.slow.cols());
        arrays.mass.assign(arrays.size, T(0));
        for (auto *field : {&arrays.rest, &arrays.x, &arrays.v, &arrays.a, &arrays.stray})
            field->assign(3 * arrays.size, T(0));
        arrays.slow.assign(3 * arrays.size * arrays.num_slow, T(0));
        part.weights.assign(arrays.num_slow, 0.0);
        for (auto &component : part.before)
            component.assign(order.size(), 0.0);
        for (std::size_t i = 0; i < order.size(); ++i) {
            const auto [row, node] = order[i];
            part.row.push_back(row);
            for (const std::size_t copy : copies[row])
                part.copies.emplace_back(i, copy);
            part.own_mass.push_back(scaled.mass[node]);
            arrays.mass[i] = static_cast<T>(scaled.mass[node]);
            for (std::size_t c = 0; c < 3; ++c) {
                const auto component = static_cast<Eigen::Index>(c);
                arrays.rest[c * arrays.size + i] = static_cast<T>(scaled.rest(component, node));
                for (std::size_t k = 0; k < arrays.num_slow; ++k)
                    arrays.slow[(3 * k + c) * arrays.size + i] =
                        static_cast<T>(scaled.slow(3 * node + component, static_cast<Eigen::Index>(k)));
            }
        }
        part.mass = part.own_mass;
        return part;
    }

    /// Finds sums of the masses.
    static void weigh(Part &part) {
        const auto &arrays = part.arrays;
        part.total_mass = 0.0;
        core::Vector3 sum = core::Vector3::Zero();
        for (std::size_t i = 0; i < part.mass.size(); ++i) {
            part.total_mass += part.mass[i];
            for (std::size_t c = 0; c < 3; ++c)
                sum[static_cast<Eigen::Index>(c)] += part.mass[i] * double{arrays.rest[c * arrays.size + i]};
        }
        part.rest_centre = sum / part.total_mass;
        const auto num_slow = static_cast<Eigen::Index>(arrays.num_slow);
        Eigen::MatrixXd gram = Eigen::MatrixXd::Identity(num_slow, num_slow);
        Eigen::VectorXd node_slow(num_slow);
        part.is_loaded = false;
        for (std::size_t i = 0; i < part.mass.size(); ++i) {
            const double added = part.mass[i] - part.own_mass[i];
            if (added == 0.0)
                continue;
            part.is_loaded = true;
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t k = 0; k < arrays.num_slow; ++k)
                    node_slow[static_cast<Eigen::Index>(k)] = double{arrays.slow[(3 * k + c) * arrays.size + i]};
                gram += added * node_slow * node_slow.transpose();
            }
        }
        if (part.is_loaded)
            part.gram.compute(gram);
        part.is_weighed = true;
    }

    /// Gathers where the step started, and what it made of velocities but for damping by mass, which is in proportion
    /// to the mass that is scaled.
    static void gather(const StepWorkspace<T> &at, Part &part) {
        auto &arrays = part.arrays;
        const auto place = [&](std::size_t i, std::size_t c) -> double {
            const auto &slice = at.nodes[part.row[i] / slice_size];
            const std::size_t lane = part.row[i] % slice_size;
            return slice.position.get(c, lane) - at.time_step * slice.velocity.get(c, lane);
        };
        const double per_step = 1.0 / at.time_step;
        for (std::size_t c = 0; c < 3; ++c) {
            const double origin = place(0, c);
            T *x = arrays.x.data() + c * arrays.size, *v = arrays.v.data() + c * arrays.size,
              *a = arrays.a.data() + c * arrays.size;
            for (std::size_t i = 0; i < part.row.size(); ++i) {
                const auto &slice = at.nodes[part.row[i] / slice_size];
                const double velocity = slice.velocity.get(c, part.row[i] % slice_size);
                x[i] = static_cast<T>(place(i, c) - origin);
                v[i] = static_cast<T>(part.before[c][i]);
                a[i] = static_cast<T>((velocity - part.before[c][i]) * per_step + at.alpha * part.before[c][i]);
            }
            // What fills the part up has no mass, but moves to the centre with the others: what is no number would
            // stay.
            std::fill(x + part.row.size(), x + arrays.size, T(0));
            std::fill(a + part.row.size(), a + arrays.size, T(0));
        }
    }

    /// The accelerations of the scaled masses, in place of those of the step.
    static void scale(StepWorkspace<T> &at, Part &part) {
        auto &arrays = part.arrays;
        const auto functions = scaled_mass_functions<T>();
        const auto sums = functions.sums(arrays);
        ScaledMassMotion motion;
        motion.centre = sums.sum_x / part.total_mass;
        motion.velocity = sums.sum_v / part.total_mass;
        motion.acceleration = sums.sum_a / part.total_mass;
        const Eigen::Matrix3d second = sums.x_and_x - part.total_mass * motion.centre * motion.centre.transpose();
        const Eigen::Matrix3d inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
        const Eigen::Matrix3d inverse_inertia = inertia.inverse();
        const Eigen::Matrix3d x_and_v = sums.x_and_v - motion.centre * sums.sum_v.transpose();
        motion.rotation = inverse_inertia * core::Vector3(x_and_v(1, 2) - x_and_v(2, 1), x_and_v(2, 0) - x_and_v(0, 2),
                                                          x_and_v(0, 1) - x_and_v(1, 0));
        // The moment of x and w = 2 (v - v_c) - omega x x gives the torque of turning, sum of m x x (omega x w); its
        // force is zero.
        Eigen::Matrix3d crossed;
        for (int c = 0; c < 3; ++c)
            crossed.col(c) = motion.rotation.cross(Eigen::Vector3d::Unit(c));
        const Eigen::Matrix3d turning = 2.0 * x_and_v - second * crossed.transpose();
        const core::Vector3 torque = sums.x_cross_a - motion.centre.cross(sums.sum_a) -
                                     (turning.trace() * motion.rotation - turning.transpose() * motion.rotation);
        motion.spin_up = inverse_inertia * torque;
        motion.turn.setIdentity();
        if (arrays.num_slow > 0)
            motion.turn =
                nearest_rotation(sums.x_and_rest - part.total_mass * motion.centre * part.rest_centre.transpose());
        functions.find_strays(arrays, motion, part.weights);
        core::Vector3 velocity = core::Vector3::Zero(), rotation = velocity;
        if (arrays.num_slow > 0) {
            if (part.is_loaded) {
                auto weights = Eigen::VectorXd::Map(part.weights.data(), static_cast<Eigen::Index>(arrays.num_slow));
                part.gram.solveInPlace(weights);
            }
            // Where the part is not as at rest its slow deformations have rigid motion too.
            const auto slow = functions.subtract_slow(arrays, motion.turn, part.weights);
            velocity = slow.linear / part.total_mass;
            rotation = inverse_inertia * slow.angular;
        }
        add_changes(at, part, velocity, rotation);
    }

    /// @param velocity, rotation  rigid motion that strays are still without [m/s^2, rad/s^2]
    static void add_changes(StepWorkspace<T> &at, const Part &part, const core::Vector3 &velocity,
                            const core::Vector3 &rotation) {
        const auto &arrays = part.arrays;
        const double gain = (1.0 / part.factor - 1.0) * at.time_step;
        auto &positions = at.rows[at.now], &velocities = at.velocity_rows[at.now];
        for (std::size_t i = 0; i < part.row.size(); ++i) {
            const auto of = [&](const Aligned<T> &field) {
                return core::Vector3(field[i], field[arrays.size + i], field[2 * arrays.size + i]);
            };
            const core::Vector3 change = gain * (of(arrays.stray) + velocity + rotation.cross(of(arrays.x)));
            const std::size_t row = part.row[i], lane = row % slice_size;
            auto &slice = at.nodes[row / slice_size];
            for (std::size_t c = 0; c < 3; ++c) {
                const double by = change[static_cast<Eigen::Index>(c)];
                slice.velocity.set(c, lane, slice.velocity.get(c, lane) + by);
                slice.position.set(c, lane, slice.position.get(c, lane) + at.time_step * by);
                positions[4 * row + c] = slice.position.high[c][lane];
                if (!velocities.empty())
                    velocities[4 * row + c] = slice.velocity.high[c][lane];
            }
        }
        for (const auto &[i, copy] : part.copies) {
            std::copy_n(positions.begin() + 4 * static_cast<std::ptrdiff_t>(part.row[i]), 3,
                        positions.begin() + 4 * static_cast<std::ptrdiff_t>(copy));
            if (!velocities.empty())
                std::copy_n(velocities.begin() + 4 * static_cast<std::ptrdiff_t>(part.row[i]), 3,
                            velocities.begin() + 4 * static_cast<std::ptrdiff_t>(copy));
        }
    }

    std::vector<Part> parts_;
    std::vector<std::pair<std::size_t, std::size_t>> place_of_row_; ///< part, and number in it
};

} // namespace livermark::msm
