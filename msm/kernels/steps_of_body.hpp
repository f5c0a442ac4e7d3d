#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/make_workspace.hpp"
#include "msm/kernels/relaxation.hpp"
#include "msm/kernels/scaled_mass_steps.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/threads/thread_pool.hpp"

namespace livermark::msm {

/// What FastSteps says, for one precision or the other.
class FastSteps::Implementation {
  public:
    virtual ~Implementation() = default;
    virtual void set_state(const State &state) = 0;
    virtual State state() const = 0;
    virtual core::Vector3 displacement(int node) const = 0;
    virtual core::Vector3 velocity(int node) const = 0;
    virtual void push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity) = 0;
    virtual void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const = 0;
    virtual void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) = 0;
    virtual void set_displacement(int node, const core::Vector3 &displacement) = 0;
    virtual void set_load(int node, const core::Vector3 &force) = 0;
    virtual void set_time_step(double time_step) = 0;
    virtual void set_mass(int node, double mass) = 0;
    virtual bool cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes) = 0;
    virtual bool part(const StepParts &parts, const std::vector<double> &node_mass, const PartingChanges &changes) = 0;
    virtual bool set_scaling(const MassScaling &scaling) = 0;
    virtual bool is_pressed() const = 0;
    virtual void take(int num_steps) = 0;
    virtual void relax(double time) = 0;
    virtual int steps_between_relaxations() const = 0;
    virtual std::size_t working_set() const = 0;
};

/// Positions less their mean: rows of single precision are finest near the origin.
inline std::vector<core::Vector3> centred(std::vector<core::Vector3> positions) {
    core::Vector3 origin = core::Vector3::Zero();
    for (const auto &x : positions)
        origin += x / static_cast<double>(positions.size());
    for (auto &x : positions)
        x -= origin;
    return positions;
}

/// Steps of a body in vector units: what stands in the arrays that make_workspace() lays out, and when they move.
/// @tparam T  of everything that forces are made from
template <class T> class StepsOfBody : public FastSteps::Implementation {
  public:
    StepsOfBody(const StepParts &parts, const ElasticBody &body, const std::vector<core::Vector3> &positions,
                const NodalConditions &conditions, const core::RayleighDamping &damping, const StepScheme &scheme,
                double time_step, const FastStepOptions &options)
        : pool_(options.num_threads) {
        const auto at_rest = centred(positions);
        if (!options.relaxation.is_elastic())
            clock_ = RelaxationClock(options.relaxation, options.relaxation_error, time_step,
                                     scheme.kind == StepScheme::Kind::symplectic_euler);
        at_ = make_workspace<T>(parts, at_rest, scheme, damping, time_step, options, clock_.num_branches(),
                                pool_.size(), plan_);
        if (!options.may_be_cut)
            plan_ = {};
        scaled_mass_ = ScaledMassSteps<T>(options.scaling, at_);
        rest_.resize(at_.body.num_slices);
        for (std::size_t i = 0; i < at_rest.size(); ++i) {
            const auto [slice, lane] = slot(i);
            for (std::size_t c = 0; c < 3; ++c) {
                const bool is_free = std::isnan(conditions.displacement[i][static_cast<Eigen::Index>(c)]);
                at_.nodes[slice].free_per_mass[c][lane] = is_free ? per_mass(body.node_mass[i]) : T(0);
                rest_[slice].set(c, lane, at_rest[i][static_cast<Eigen::Index>(c)]);
            }
        }
        set_loads(conditions.force);
        const auto size = static_cast<Eigen::Index>(3 * positions.size());
        StepsOfBody::set_state({Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)});
    }

    void set_state(const State &state) override {
        if (!at_.relaxation.empty() && !is_finite())
            forget_stresses();
        // What fills up slices is put back too. Nothing moves it but forces that are no numbers: it would keep these,
        // and give them to the node of its lane through a spring without stiffness.
        for (auto &slice : at_.nodes) {
            slice.position = {};
            slice.velocity = {};
        }
        for (std::size_t i = 0; i < num_nodes(); ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const auto unknown = static_cast<Eigen::Index>(3 * i + c);
                const auto [slice, lane] = slot(i);
                auto &node = at_.nodes[slice];
                const bool is_free = node.free_per_mass[c][lane] != 0.0;
                node.position.set(c, lane, rest_[slice].get(c, lane) + state.displacement[unknown]);
                node.velocity.set(c, lane, is_free ? state.velocity[unknown] : 0.0);
            }
        write_rows(&NodeSlice<T>::position, at_.rows[at_.now]);
        if (!at_.velocity_rows[at_.now].empty())
            write_rows(&NodeSlice<T>::velocity, at_.velocity_rows[at_.now]);
    }

    State state() const override {
        const auto size = static_cast<Eigen::Index>(3 * num_nodes());
        State state{Eigen::VectorXd(size), Eigen::VectorXd(size)};
        for (std::size_t i = 0; i < num_nodes(); ++i) {
            const auto first = static_cast<Eigen::Index>(3 * i);
            state.displacement.segment<3>(first) = displacement(static_cast<int>(i));
            state.velocity.segment<3>(first) = velocity(static_cast<int>(i));
        }
        return state;
    }

    core::Vector3 displacement(int node) const override {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        const auto &now = at_.nodes[slice].position, &rest = rest_[slice];
        return {now.less(rest, 0, lane), now.less(rest, 1, lane), now.less(rest, 2, lane)};
    }

    core::Vector3 velocity(int node) const override {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        const auto &now = at_.nodes[slice].velocity;
        return {now.get(0, lane), now.get(1, lane), now.get(2, lane)};
    }

    void push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity) override {
        const auto place = slot(static_cast<std::size_t>(node));
        const std::size_t slice = place.slice, lane = place.lane;
        auto &of_slice = at_.nodes[slice];
        for (std::size_t c = 0; c < 3; ++c) {
            if (of_slice.free_per_mass[c][lane] == 0.0)
                continue;
            const auto add = [&](FineField<T> &field, double change, Aligned<T> &rows) {
                field.set(c, lane, field.get(c, lane) + change);
                if (!rows.empty())
                    write_component(node, c, field.high[c][lane], rows);
            };
            add(of_slice.position, displacement[static_cast<Eigen::Index>(c)], at_.rows[at_.now]);
            add(of_slice.velocity, velocity[static_cast<Eigen::Index>(c)], at_.velocity_rows[at_.now]);
        }
    }

    void displacements(std::span<const int> nodes, std::span<core::Vector3> found) const override {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = StepsOfBody::displacement(nodes[i]);
    }

    void kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) override {
        auto &rows = at_.rows[at_.now], &velocity_rows = at_.velocity_rows[at_.now];
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto row = static_cast<std::size_t>(at_.body.row_of_node[nodes[i]]);
            const std::size_t lane = row % slice_size;
            auto &of_slice = at_.nodes[row / slice_size];
            for (std::size_t c = 0; c < 3; ++c) {
                if (of_slice.free_per_mass[c][lane] == 0.0)
                    continue;
                const double change = velocity[i][static_cast<Eigen::Index>(c)];
                of_slice.velocity.set(c, lane, of_slice.velocity.get(c, lane) + change);
                of_slice.position.set(c, lane, of_slice.position.get(c, lane) + time_step * change);
                rows[4 * row + c] = of_slice.position.high[c][lane];
                if (!velocity_rows.empty())
                    velocity_rows[4 * row + c] = of_slice.velocity.high[c][lane];
            }
            for (const std::size_t copy : copies_of(row)) {
                std::copy_n(rows.data() + 4 * row, 3, rows.data() + 4 * copy);
                if (!velocity_rows.empty())
                    std::copy_n(velocity_rows.data() + 4 * row, 3, velocity_rows.data() + 4 * copy);
            }
        }
    }

    void set_displacement(int node, const core::Vector3 &displacement) override {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        for (std::size_t c = 0; c < 3; ++c) {
            if (at_.nodes[slice].free_per_mass[c][lane] != 0.0)
                continue;
            auto &position = at_.nodes[slice].position;
            position.set(c, lane, rest_[slice].get(c, lane) + displacement[static_cast<Eigen::Index>(c)]);
            write_component(node, c, position.high[c][lane], at_.rows[at_.now]);
        }
    }

    void set_load(int node, const core::Vector3 &force) override {
        if (at_.loads.empty())
            at_.loads.assign(at_.body.num_slices, {});
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        for (std::size_t c = 0; c < 3; ++c)
            at_.loads[slice][c][lane] = static_cast<T>(force[c]);
    }

    void set_time_step(double time_step) override {
        at_.time_step = time_step;
        clock_.set_time_step(time_step);
    }

    void set_mass(int node, double mass) override {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        for (auto &component : at_.nodes[slice].free_per_mass)
            if (component[lane] != 0.0)
                component[lane] = per_mass(mass);
        scaled_mass_.set_mass(static_cast<std::size_t>(at_.body.row_of_node[node]), mass);
    }

    bool cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes) override {
        update_sliced_body(parts, changes, plan_, at_.body);
        if (at_.body.is_around_edges())
            make_room_for_stars(at_, pool_.size());
        return change_masses(changes.nodes, node_mass);
    }

    bool part(const StepParts &parts, const std::vector<double> &node_mass, const PartingChanges &changes) override {
        const auto map = part_sliced_body(parts, changes, plan_, at_.body);
        make_room_after_parting(map, pool_.size(), at_);
        rest_.resize(at_.nodes.size());
        copies_.clear();
        scaled_mass_.move_copies(map);
        const std::size_t first_new = num_nodes() - changes.parent_node.size();
        for (std::size_t k = 0; k < changes.parent_node.size(); ++k)
            put_beside(static_cast<std::size_t>(changes.parent_node[k]), first_new + k);
        for (std::size_t c = 0; c < at_.body.copied_row.size(); ++c)
            for (auto *rows : {&at_.rows[at_.now], &at_.velocity_rows[at_.now]})
                if (!rows->empty())
                    std::copy_n(rows->begin() + 4 * std::ptrdiff_t{at_.body.copied_row[c]}, 4,
                                rows->begin() + 4 * (at_.body.first_copy + static_cast<std::ptrdiff_t>(c)));
        share_loads(changes.parent_node, node_mass);
        return change_masses(changes.nodes, node_mass);
    }

    bool set_scaling(const MassScaling &scaling) override {
        const bool can = at_.scheme.kind == StepScheme::Kind::symplectic_euler;
        if (can)
            scaled_mass_ = ScaledMassSteps<T>(scaling, at_);
        return can;
    }

    bool is_pressed() const override {
        return std::ranges::any_of(at_.deficit, [](T deficit) { return deficit > T(0); });
    }

    void take(int num_steps) override {
        if (at_.relaxation.empty())
            return take_elastic(num_steps);
        while (num_steps > 0) {
            if (clock_.steps_left() == 0)
                move_branches(clock_.turn());
            const int now = std::min(num_steps, clock_.steps_left());
            take_elastic(now);
            clock_.count(now);
            num_steps -= now;
        }
    }

    void relax(double time) override {
        if (!at_.relaxation.empty())
            move_branches(clock_.stay(time));
    }

    int steps_between_relaxations() const override { return at_.relaxation.empty() ? 1 : clock_.num_steps(); }
    std::size_t working_set() const override { return msm::working_set(at_); }

  private:
    static T per_mass(double mass) { return mass > 0.0 ? static_cast<T>(1.0 / mass) : T(0); }

    /// @return false if scaled parts are left behind without their scaling
    bool change_masses(const std::vector<int> &nodes, const std::vector<double> &node_mass) {
        std::vector<std::size_t> left_parts; // rows of these
        for (const int node : nodes) {
            const auto rows = scaled_mass_.leave(static_cast<std::size_t>(at_.body.row_of_node[node]));
            left_parts.insert(left_parts.end(), rows.begin(), rows.end());
            set_mass(node, node_mass[node]);
            if (node_mass[node] == 0.0)
                stop(static_cast<std::size_t>(node));
        }
        return std::ranges::all_of(left_parts, [&](std::size_t row) {
            const auto &per_mass = at_.nodes[row / slice_size].free_per_mass;
            return per_mass[0][row % slice_size] == T(0); // gone
        });
    }

    /// A new node, as free as the one from which it is parted, in its place and as fast.
    void put_beside(std::size_t parent, std::size_t node) {
        const auto [from_slice, from] = slot(parent);
        const auto [slice, lane] = slot(node);
        const auto copy = [&, from = from, lane = lane](const auto &field, auto &to) {
            for (std::size_t c = 0; c < 3; ++c)
                to[c][lane] = field[c][from];
        };
        const auto copy_fine = [&](const FineField<T> &field, FineField<T> &to) {
            copy(field.high, to.high);
            if constexpr (requires { field.low; })
                copy(field.low, to.low);
        };
        auto &to = at_.nodes[slice];
        const auto &of_parent = at_.nodes[from_slice];
        copy_fine(of_parent.position, to.position);
        copy_fine(of_parent.velocity, to.velocity);
        copy(of_parent.free_per_mass, to.free_per_mass);
        copy_fine(rest_[from_slice], rest_[slice]);
        if (!at_.loads.empty())
            copy(at_.loads[from_slice], at_.loads[slice]);
        for (auto *rows : {&at_.rows[at_.now], &at_.velocity_rows[at_.now]})
            if (!rows->empty())
                std::copy_n(rows->begin() + 4 * std::ptrdiff_t{at_.body.row_of_node[parent]}, 4,
                            rows->begin() + 4 * std::ptrdiff_t{at_.body.row_of_node[node]});
    }

    /// The load of a node is that of it and of what was parted from it, in proportion to their masses.
    void share_loads(const std::vector<int> &parent_node, const std::vector<double> &node_mass) {
        if (at_.loads.empty())
            return;
        std::map<int, std::vector<std::size_t>> nodes; // by parent
        const std::size_t first_new = num_nodes() - parent_node.size();
        for (std::size_t k = 0; k < parent_node.size(); ++k)
            nodes[parent_node[k]].push_back(first_new + k);
        for (auto &[parent, parts] : nodes) {
            parts.push_back(static_cast<std::size_t>(parent));
            double mass = 0.0;
            for (const std::size_t node : parts)
                mass += node_mass[node];
            for (const std::size_t node : parts) {
                const auto [slice, lane] = slot(node);
                for (auto &component : at_.loads[slice])
                    component[lane] = static_cast<T>(double{component[lane]} * node_mass[node] / mass);
            }
        }
    }

    /// What has no mass stays where it is.
    void stop(std::size_t node) {
        const auto [slice, lane] = slot(node);
        for (std::size_t c = 0; c < 3; ++c)
            at_.nodes[slice].velocity.set(c, lane, 0.0);
        if (auto &rows = at_.velocity_rows[at_.now]; !rows.empty())
            std::fill_n(rows.begin() + 4 * static_cast<std::ptrdiff_t>(at_.body.row_of_node[node]), 3, T(0));
    }

    bool is_finite() const {
        return std::ranges::all_of(at_.nodes, [](const NodeSlice<T> &slice) {
            T sum = 0;
            for (const auto *field : {&slice.position.high, &slice.velocity.high})
                for (const auto &component : *field)
                    for (const T value : component)
                        sum += T(0) * value;
            return sum == T(0);
        });
    }

    void forget_stresses() {
        forget(at_.relaxation, at_.body);
        clock_.stay(0.0);
    }

    void move_branches(const RelaxationShares &shares) {
        at_.relaxation.shares = shares;
        pool_.run([this](int thread, Barrier &barrier) { relax_stresses(at_, thread, barrier); });
    }

    /// Steps in which branches do not move.
    void take_elastic(int num_steps) {
        if (scaled_mass_.empty())
            return take_unscaled(num_steps);
        for (int s = 0; s < num_steps; ++s) {
            scaled_mass_.remember(at_);
            take_unscaled(1);
            scaled_mass_.correct(at_);
        }
    }

    void take_unscaled(int num_steps) {
        pool_.run([&](int thread, Barrier &barrier) { take_steps(at_, thread, num_steps, barrier); });
        at_.now = (at_.now + num_steps % 2 * at_.scheme.num_stages()) % 2;
    }

    void set_loads(const std::vector<core::Vector3> &force) {
        if (std::ranges::all_of(force, [](const auto &f) { return f.isZero(0.0); }))
            return;
        for (std::size_t i = 0; i < force.size(); ++i)
            set_load(static_cast<int>(i), force[i]);
    }

    std::size_t num_nodes() const { return at_.body.row_of_node.size(); }

    struct Slot {
        std::size_t slice, lane;
    };
    Slot slot(std::size_t node) const {
        const auto row = static_cast<std::size_t>(at_.body.row_of_node[node]);
        return {row / slice_size, row % slice_size};
    }

    /// To all rows of a node.
    void write_component(int node, std::size_t component, T value, Aligned<T> &rows) {
        const auto row = static_cast<std::size_t>(at_.body.row_of_node[node]);
        rows[4 * row + component] = value;
        for (const std::size_t copy : copies_of(row))
            rows[4 * copy + component] = value;
    }

    /// Other rows that have the same node.
    const std::vector<std::size_t> &copies_of(std::size_t row) {
        if (copies_.empty()) {
            copies_.resize(static_cast<std::size_t>(at_.body.first_copy));
            for (std::size_t c = 0; c < at_.body.copied_row.size(); ++c)
                copies_[static_cast<std::size_t>(at_.body.copied_row[c])].push_back(
                    static_cast<std::size_t>(at_.body.first_copy) + c);
        }
        return copies_[row];
    }

    void write_rows(FineField<T> NodeSlice<T>::*field, Aligned<T> &rows) const {
        for (int row = 0; row < at_.body.first_copy; ++row)
            for (std::size_t c = 0; c < 3; ++c)
                rows[4 * static_cast<std::size_t>(row) + c] =
                    (at_.nodes[row / slice_size].*field).high[c][row % slice_size];
        for (std::size_t c = 0; c < at_.body.copied_row.size(); ++c)
            std::copy_n(rows.begin() + 4 * static_cast<std::ptrdiff_t>(at_.body.copied_row[c]), 4,
                        rows.begin() + 4 * (at_.body.first_copy + static_cast<std::ptrdiff_t>(c)));
    }

    /// (slices) positions at rest less the origin [m], to the digits in which positions are kept, so that a state is
    /// what it was when it is set again
    std::vector<FineField<T>> rest_;
    SlicedPlan plan_; ///< empty unless the body may be cut
    StepWorkspace<T> at_;
    RelaxationClock clock_;
    ScaledMassSteps<T> scaled_mass_;
    std::vector<std::vector<std::size_t>> copies_; ///< of each row; empty until somebody asks
    ThreadPool pool_;
};

} // namespace livermark::msm
