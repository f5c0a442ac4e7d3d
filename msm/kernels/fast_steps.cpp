#include "msm/kernels/fast_steps.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <variant>

#include "msm/kernels/layout/slicing.hpp"
#include "msm/kernels/relaxation.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/thread_pool.hpp"

namespace livermark::msm {

namespace {

/// Positions less their mean: rows of single precision are finest near the origin.
std::vector<core::Vector3> centred(std::vector<core::Vector3> positions) {
    core::Vector3 origin = core::Vector3::Zero();
    for (const auto &x : positions)
        origin += x / static_cast<double>(positions.size());
    for (auto &x : positions)
        x -= origin;
    return positions;
}

std::optional<StepScheme> find_scheme(const std::string &integrator, int num_stages) {
    using Kind = StepScheme::Kind;
    static const std::map<std::string, StepScheme, std::less<>> schemes{
        {"explicit_euler", {.kind = Kind::runge_kutta, .weight = {1.0}}},
        {"heun", {.kind = Kind::runge_kutta, .weight = {0.5, 0.5}, .next = {1.0}}},
        {"runge_kutta_4",
         {.kind = Kind::runge_kutta, .weight = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0}, .next = {0.5, 0.5, 1.0}}},
        {"symplectic_euler", {.kind = Kind::symplectic_euler}},
        {"velocity_verlet", {.kind = Kind::velocity_verlet}}};
    if (integrator == "runge_kutta_chebyshev")
        return StepScheme{.kind = Kind::runge_kutta_chebyshev, .chebyshev = chebyshev_stages(num_stages)};
    const auto found = schemes.find(integrator);
    return found == schemes.end() ? std::nullopt : std::optional(found->second);
}

} // namespace

/// Arrays of a body in vector units, which make_workspace() lays out, and when they move.
/// @tparam T  of everything that forces are made from
template <class T> struct StepsOfBody {
    StepsOfBody(const StepParts &parts, const ElasticBody &body, const std::vector<core::Vector3> &positions,
                const NodalConditions &conditions, const core::RayleighDamping &damping, const StepScheme &scheme,
                double time_step, const FastStepOptions &options)
        : pool(options.num_threads) {
        const auto at_rest = centred(positions);
        if (!options.relaxation.is_elastic())
            clock = RelaxationClock(options.relaxation, options.relaxation_error, time_step,
                                    scheme.kind == StepScheme::Kind::symplectic_euler);
        at = make_workspace<T>(parts, at_rest, scheme, damping, time_step, options, clock.num_branches(), pool.size(),
                               plan);
        if (!options.may_be_cut)
            plan = {};
        scaled_mass = ScaledMassSteps<T>(options.scaling, at);
        rest.resize(at.body.num_slices);
        for (std::size_t i = 0; i < at_rest.size(); ++i) {
            const auto [slice, lane] = slot(i);
            for (std::size_t c = 0; c < 3; ++c) {
                const bool is_free = std::isnan(conditions.displacement[i][static_cast<Eigen::Index>(c)]);
                at.nodes[slice].free_per_mass[c][lane] = is_free ? per_mass(body.node_mass[i]) : T(0);
                rest[slice].set(c, lane, at_rest[i][static_cast<Eigen::Index>(c)]);
            }
        }
    }

    core::Vector3 displacement(int node) const {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        const auto &now = at.nodes[slice].position, &before = rest[slice];
        return {now.less(before, 0, lane), now.less(before, 1, lane), now.less(before, 2, lane)};
    }

    core::Vector3 velocity(int node) const {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        const auto &now = at.nodes[slice].velocity;
        return {now.get(0, lane), now.get(1, lane), now.get(2, lane)};
    }

    void set_mass(int node, double mass) {
        const auto [slice, lane] = slot(static_cast<std::size_t>(node));
        for (auto &component : at.nodes[slice].free_per_mass)
            if (component[lane] != 0.0)
                component[lane] = per_mass(mass);
        scaled_mass.set_mass(static_cast<std::size_t>(at.body.row_of_node[node]), mass);
    }

    static T per_mass(double mass) { return mass > 0.0 ? static_cast<T>(1.0 / mass) : T(0); }

    /// @return false if scaled parts are left behind without their scaling
    bool change_masses(const std::vector<int> &nodes, const std::vector<double> &node_mass) {
        std::vector<std::size_t> left_parts; // rows of these
        for (const int node : nodes) {
            const auto rows = scaled_mass.leave(static_cast<std::size_t>(at.body.row_of_node[node]));
            left_parts.insert(left_parts.end(), rows.begin(), rows.end());
            set_mass(node, node_mass[node]);
            if (node_mass[node] == 0.0)
                stop(static_cast<std::size_t>(node));
        }
        return std::ranges::all_of(left_parts, [&](std::size_t row) {
            const auto &per_mass = at.nodes[row / slice_size].free_per_mass;
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
        auto &to = at.nodes[slice];
        const auto &parent_nodes = at.nodes[from_slice];
        copy_fine(parent_nodes.position, to.position);
        copy_fine(parent_nodes.velocity, to.velocity);
        copy(parent_nodes.free_per_mass, to.free_per_mass);
        copy_fine(rest[from_slice], rest[slice]);
        if (!at.loads.empty())
            copy(at.loads[from_slice], at.loads[slice]);
        for (auto *rows : {&at.rows[at.now], &at.velocity_rows[at.now]})
            if (!rows->empty())
                std::copy_n(rows->begin() + 4 * std::ptrdiff_t{at.body.row_of_node[parent]}, 4,
                            rows->begin() + 4 * std::ptrdiff_t{at.body.row_of_node[node]});
    }

    /// The load of a node is that of it and of what was parted from it, in proportion to their masses.
    void share_loads(const std::vector<int> &parent_node, const std::vector<double> &node_mass) {
        if (at.loads.empty())
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
                for (auto &component : at.loads[slice])
                    component[lane] = static_cast<T>(double{component[lane]} * node_mass[node] / mass);
            }
        }
    }

    /// A node without mass stays where it is.
    void stop(std::size_t node) {
        const auto [slice, lane] = slot(node);
        for (std::size_t c = 0; c < 3; ++c)
            at.nodes[slice].velocity.set(c, lane, 0.0);
        if (auto &rows = at.velocity_rows[at.now]; !rows.empty())
            std::fill_n(rows.begin() + 4 * static_cast<std::ptrdiff_t>(at.body.row_of_node[node]), 3, T(0));
    }

    bool is_finite() const {
        return std::ranges::all_of(at.nodes, [](const NodeSlice<T> &slice) {
            T sum = 0;
            for (const auto *field : {&slice.position.high, &slice.velocity.high})
                for (const auto &component : *field)
                    for (const T value : component)
                        sum += T(0) * value;
            return sum == T(0);
        });
    }

    void forget_stresses() {
        forget(at.relaxation, at.body);
        clock.stay(0.0);
    }

    void move_branches(const RelaxationShares &shares) {
        at.relaxation.shares = shares;
        pool.run([this](int thread, Barrier &barrier) { relax_stresses(at, thread, barrier); });
    }

    /// Steps in which branches do not move.
    void take_elastic(int num_steps) {
        if (scaled_mass.empty())
            return take_unscaled(num_steps);
        for (int s = 0; s < num_steps; ++s) {
            scaled_mass.remember(at);
            take_unscaled(1);
            scaled_mass.correct(at);
        }
    }

    void take_unscaled(int num_steps) {
        pool.run([&](int thread, Barrier &barrier) { take_steps(at, thread, num_steps, barrier); });
        at.now = (at.now + num_steps % 2 * at.scheme.num_stages()) % 2;
    }

    std::size_t num_nodes() const { return at.body.row_of_node.size(); }

    struct Slot {
        std::size_t slice, lane;
    };
    Slot slot(std::size_t node) const {
        const auto row = static_cast<std::size_t>(at.body.row_of_node[node]);
        return {row / slice_size, row % slice_size};
    }

    /// To all rows of a node.
    void write_component(int node, std::size_t component, T value, Aligned<T> &rows) {
        const auto row = static_cast<std::size_t>(at.body.row_of_node[node]);
        rows[4 * row + component] = value;
        for (const std::size_t copy : copies_of(row))
            rows[4 * copy + component] = value;
    }

    /// Other rows that have the same node.
    const std::vector<std::size_t> &copies_of(std::size_t row) {
        if (copies.empty()) {
            copies.resize(static_cast<std::size_t>(at.body.first_copy));
            for (std::size_t c = 0; c < at.body.copied_row.size(); ++c)
                copies[static_cast<std::size_t>(at.body.copied_row[c])].push_back(
                    static_cast<std::size_t>(at.body.first_copy) + c);
        }
        return copies[row];
    }

    void write_rows(FineField<T> NodeSlice<T>::*field, Aligned<T> &rows) const {
        for (int row = 0; row < at.body.first_copy; ++row)
            for (std::size_t c = 0; c < 3; ++c)
                rows[4 * static_cast<std::size_t>(row) + c] =
                    (at.nodes[row / slice_size].*field).high[c][row % slice_size];
        for (std::size_t c = 0; c < at.body.copied_row.size(); ++c)
            std::copy_n(rows.begin() + 4 * static_cast<std::ptrdiff_t>(at.body.copied_row[c]), 4,
                        rows.begin() + 4 * (at.body.first_copy + static_cast<std::ptrdiff_t>(c)));
    }

    /// (slices) positions at rest less the origin [m], to the digits in which positions are kept, so that a state is
    /// what it was when it is set again
    std::vector<FineField<T>> rest;
    SlicedPlan plan; ///< empty unless the body may be cut
    StepWorkspace<T> at;
    RelaxationClock clock;
    ScaledMassSteps<T> scaled_mass;
    std::vector<std::vector<std::size_t>> copies; ///< of each row; empty until somebody asks
    ThreadPool pool;
};

/// The arrays of one precision or the other.
struct FastSteps::Implementation {
    template <class T, class... Arguments>
    explicit Implementation(std::in_place_type_t<T> precision, const Arguments &...arguments)
        : steps(precision, arguments...) {}

    template <class Act> auto visit(const Act &act) { return std::visit(act, steps); }

    std::variant<StepsOfBody<float>, StepsOfBody<double>> steps;
};

std::optional<FastSteps> FastSteps::prepare(const ElasticBody &body, const std::vector<core::Vector3> &positions,
                                            const NodalConditions &conditions, const core::RayleighDamping &damping,
                                            const std::string &integrator, double time_step,
                                            const FastStepOptions &options) {
    auto parts = step_parts(body);
    if (parts && !parts->guard_stiffness.empty())
        parts->watched_volume = options.watched_volume;
    const auto scheme = find_scheme(integrator, options.num_stages);
    const bool is_scaled = !options.scaling.parts.empty();
    const bool relaxes = !options.relaxation.is_elastic();
    if (!parts || !scheme || (is_scaled && scheme->kind != StepScheme::Kind::symplectic_euler))
        return std::nullopt;
    if (relaxes && options.may_be_cut)
        return std::nullopt;
    const auto make = [&]<class T>(T /*precision*/) {
        return FastSteps(std::make_shared<Implementation>(std::in_place_type<StepsOfBody<T>>, *parts, body, positions,
                                                          conditions, damping, *scheme, time_step, options));
    };
    auto steps = options.precision == ForcePrecision::single_precision ? make(float()) : make(double());
    if (std::ranges::any_of(conditions.force, [](const auto &f) { return !f.isZero(0.0); }))
        for (std::size_t i = 0; i < conditions.force.size(); ++i)
            steps.set_load(static_cast<int>(i), conditions.force[i]);
    const auto size = static_cast<Eigen::Index>(3 * positions.size());
    steps.set_state({Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)});
    return steps;
}

void FastSteps::set_state(const State &state) {
    implementation_->visit([&]<class T>(StepsOfBody<T> &own) {
        if (!own.at.relaxation.empty() && !own.is_finite())
            own.forget_stresses();
        // What fills up slices is put back too. Nothing moves it but forces that are no numbers: it would keep these,
        // and give them to the node of its lane through a spring without stiffness.
        for (auto &slice : own.at.nodes) {
            slice.position = {};
            slice.velocity = {};
        }
        for (std::size_t i = 0; i < own.num_nodes(); ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const auto unknown = static_cast<Eigen::Index>(3 * i + c);
                const auto [slice, lane] = own.slot(i);
                auto &node = own.at.nodes[slice];
                const bool is_free = node.free_per_mass[c][lane] != 0.0;
                node.position.set(c, lane, own.rest[slice].get(c, lane) + state.displacement[unknown]);
                node.velocity.set(c, lane, is_free ? state.velocity[unknown] : 0.0);
            }
        own.write_rows(&NodeSlice<T>::position, own.at.rows[own.at.now]);
        if (!own.at.velocity_rows[own.at.now].empty())
            own.write_rows(&NodeSlice<T>::velocity, own.at.velocity_rows[own.at.now]);
    });
}

State FastSteps::state() const {
    return implementation_->visit([&](const auto &own) {
        const auto size = static_cast<Eigen::Index>(3 * own.num_nodes());
        State state{Eigen::VectorXd(size), Eigen::VectorXd(size)};
        for (std::size_t i = 0; i < own.num_nodes(); ++i) {
            const auto first = static_cast<Eigen::Index>(3 * i);
            state.displacement.segment<3>(first) = own.displacement(static_cast<int>(i));
            state.velocity.segment<3>(first) = own.velocity(static_cast<int>(i));
        }
        return state;
    });
}

core::Vector3 FastSteps::displacement(int node) const {
    return implementation_->visit([&](const auto &own) { return own.displacement(node); });
}

core::Vector3 FastSteps::velocity(int node) const {
    return implementation_->visit([&](const auto &own) { return own.velocity(node); });
}

void FastSteps::push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity) {
    implementation_->visit([&]<class T>(StepsOfBody<T> &own) {
        const auto place = own.slot(static_cast<std::size_t>(node));
        const std::size_t slice = place.slice, lane = place.lane;
        auto &nodes_of_slice = own.at.nodes[slice];
        for (std::size_t c = 0; c < 3; ++c) {
            if (nodes_of_slice.free_per_mass[c][lane] == 0.0)
                continue;
            const auto add = [&](FineField<T> &field, double change, Aligned<T> &rows) {
                field.set(c, lane, field.get(c, lane) + change);
                if (!rows.empty())
                    own.write_component(node, c, field.high[c][lane], rows);
            };
            add(nodes_of_slice.position, displacement[static_cast<Eigen::Index>(c)], own.at.rows[own.at.now]);
            add(nodes_of_slice.velocity, velocity[static_cast<Eigen::Index>(c)], own.at.velocity_rows[own.at.now]);
        }
    });
}

void FastSteps::displacements(std::span<const int> nodes, std::span<core::Vector3> found) const {
    implementation_->visit([&](const auto &own) {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            found[i] = own.displacement(nodes[i]);
    });
}

void FastSteps::kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) {
    implementation_->visit([&](auto &own) {
        auto &rows = own.at.rows[own.at.now], &velocity_rows = own.at.velocity_rows[own.at.now];
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const auto row = static_cast<std::size_t>(own.at.body.row_of_node[nodes[i]]);
            const std::size_t lane = row % slice_size;
            auto &nodes_of_slice = own.at.nodes[row / slice_size];
            for (std::size_t c = 0; c < 3; ++c) {
                if (nodes_of_slice.free_per_mass[c][lane] == 0.0)
                    continue;
                const double change = velocity[i][static_cast<Eigen::Index>(c)];
                nodes_of_slice.velocity.set(c, lane, nodes_of_slice.velocity.get(c, lane) + change);
                nodes_of_slice.position.set(c, lane, nodes_of_slice.position.get(c, lane) + time_step * change);
                rows[4 * row + c] = nodes_of_slice.position.high[c][lane];
                if (!velocity_rows.empty())
                    velocity_rows[4 * row + c] = nodes_of_slice.velocity.high[c][lane];
            }
            for (const std::size_t copy : own.copies_of(row)) {
                std::copy_n(rows.data() + 4 * row, 3, rows.data() + 4 * copy);
                if (!velocity_rows.empty())
                    std::copy_n(velocity_rows.data() + 4 * row, 3, velocity_rows.data() + 4 * copy);
            }
        }
    });
}

void FastSteps::set_displacement(int node, const core::Vector3 &displacement) {
    implementation_->visit([&](auto &own) {
        const auto [slice, lane] = own.slot(static_cast<std::size_t>(node));
        for (std::size_t c = 0; c < 3; ++c) {
            if (own.at.nodes[slice].free_per_mass[c][lane] != 0.0)
                continue;
            auto &position = own.at.nodes[slice].position;
            position.set(c, lane, own.rest[slice].get(c, lane) + displacement[static_cast<Eigen::Index>(c)]);
            own.write_component(node, c, position.high[c][lane], own.at.rows[own.at.now]);
        }
    });
}

void FastSteps::set_load(int node, const core::Vector3 &force) {
    implementation_->visit([&]<class T>(StepsOfBody<T> &own) {
        if (own.at.loads.empty())
            own.at.loads.assign(own.at.body.num_slices, {});
        const auto [slice, lane] = own.slot(static_cast<std::size_t>(node));
        for (std::size_t c = 0; c < 3; ++c)
            own.at.loads[slice][c][lane] = static_cast<T>(force[c]);
    });
}

void FastSteps::set_time_step(double time_step) {
    implementation_->visit([&](auto &own) {
        own.at.time_step = time_step;
        own.clock.set_time_step(time_step);
    });
}

void FastSteps::set_mass(int node, double mass) {
    implementation_->visit([&](auto &own) { own.set_mass(node, mass); });
}

bool FastSteps::cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes) {
    return implementation_->visit([&](auto &own) {
        update_sliced_body(parts, changes, own.plan, own.at.body);
        return own.change_masses(changes.nodes, node_mass);
    });
}

bool FastSteps::part(const StepParts &parts, const std::vector<double> &node_mass, const PartingChanges &changes) {
    return implementation_->visit([&](auto &own) {
        const auto map = part_sliced_body(parts, changes, own.plan, own.at.body);
        make_room_after_parting(map, own.pool.size(), own.at);
        own.rest.resize(own.at.nodes.size());
        own.copies.clear();
        own.scaled_mass.move_copies(map);
        const std::size_t first_new = own.num_nodes() - changes.parent_node.size();
        for (std::size_t k = 0; k < changes.parent_node.size(); ++k)
            own.put_beside(static_cast<std::size_t>(changes.parent_node[k]), first_new + k);
        for (std::size_t c = 0; c < own.at.body.copied_row.size(); ++c)
            for (auto *rows : {&own.at.rows[own.at.now], &own.at.velocity_rows[own.at.now]})
                if (!rows->empty())
                    std::copy_n(rows->begin() + 4 * std::ptrdiff_t{own.at.body.copied_row[c]}, 4,
                                rows->begin() + 4 * (own.at.body.first_copy + static_cast<std::ptrdiff_t>(c)));
        own.share_loads(changes.parent_node, node_mass);
        return own.change_masses(changes.nodes, node_mass);
    });
}

bool FastSteps::set_scaling(const MassScaling &scaling) {
    return implementation_->visit([&]<class T>(StepsOfBody<T> &own) {
        const bool can = own.at.scheme.kind == StepScheme::Kind::symplectic_euler;
        if (can)
            own.scaled_mass = ScaledMassSteps<T>(scaling, own.at);
        return can;
    });
}

bool FastSteps::is_pressed() const {
    return implementation_->visit([&]<class T>(const StepsOfBody<T> &own) {
        return std::ranges::any_of(own.at.deficit, [](T deficit) { return deficit > T(0); });
    });
}

void FastSteps::take(int num_steps) {
    implementation_->visit([&](auto &own) {
        if (own.at.relaxation.empty())
            return own.take_elastic(num_steps);
        while (num_steps > 0) {
            if (own.clock.steps_left() == 0)
                own.move_branches(own.clock.turn());
            const int now = std::min(num_steps, own.clock.steps_left());
            own.take_elastic(now);
            own.clock.count(now);
            num_steps -= now;
        }
    });
}

void FastSteps::relax(double time) {
    implementation_->visit([&](auto &own) {
        if (!own.at.relaxation.empty())
            own.move_branches(own.clock.stay(time));
    });
}

int FastSteps::steps_between_relaxations() const {
    return implementation_->visit(
        [&](const auto &own) { return own.at.relaxation.empty() ? 1 : own.clock.num_steps(); });
}

std::size_t FastSteps::working_set() const {
    return implementation_->visit([&](const auto &own) { return msm::working_set(own.at); });
}

} // namespace livermark::msm
