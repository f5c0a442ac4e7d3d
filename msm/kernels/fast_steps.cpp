#include "msm/kernels/fast_steps.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "msm/kernels/relaxation/relaxation_arrays.hpp"
#include "msm/kernels/scaled_mass_steps.hpp"
#include "msm/kernels/step_workspace.hpp"
#include "msm/kernels/threads/partition.hpp"
#include "msm/kernels/threads/thread_pool.hpp"

namespace livermark::msm {

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
    virtual bool set_scaling(const MassScaling &scaling) = 0;
    virtual bool is_pressed() const = 0;
    virtual void take(int num_steps) = 0;
    virtual void relax(double time) = 0;
    virtual int steps_between_relaxations() const = 0;
    virtual std::size_t working_set() const = 0;
};

namespace {

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

/// Positions less their mean: rows of single precision are finest near the origin.
std::vector<core::Vector3> centred(std::vector<core::Vector3> positions) {
    core::Vector3 origin = core::Vector3::Zero();
    for (const auto &x : positions)
        origin += x / static_cast<double>(positions.size());
    for (auto &x : positions)
        x -= origin;
    return positions;
}

template <class V> std::size_t bytes(const V &values) {
    return values.size() * sizeof(typename V::value_type);
}

/// Where springs end that only fill up a slice: so far from any body that they have a length [m].
constexpr float far = 1e4F;

template <class T> class Steps : public FastSteps::Implementation {
  public:
    Steps(const StepParts &parts, const ElasticBody &body, const std::vector<core::Vector3> &positions,
          const NodalConditions &conditions, const core::RayleighDamping &damping, const StepScheme &scheme,
          double time_step, const FastStepOptions &options)
        : pool_(options.num_threads) {
        const auto at_rest = centred(positions);
        const bool relaxes = !options.relaxation.is_elastic();
        at_.body = sliced_body<T>(parts, at_rest, options.may_be_cut || relaxes ? &plan_ : nullptr);
        if (relaxes) {
            clock_ = RelaxationClock(options.relaxation, options.relaxation_error, time_step);
            at_.relaxation = relaxation_arrays(parts, plan_, at_.body, clock_.num_branches());
        }
        if (!options.may_be_cut)
            plan_ = {};
        at_.scheme = scheme;
        at_.time_step = time_step;
        at_.alpha = damping.alpha;
        at_.beta = damping.beta;
        at_.least_stretch = options.least_stretch;
        at_.scheme.largest_speed = options.largest_speed;
        if (!at_.body.watched_volume.empty())
            at_.deficit.assign(at_.body.fan_start.size() - 1 + at_.body.volume_row.size() / slice_size +
                                   at_.body.star_modulus.size() / slice_size,
                               T(0));
        at_.nodes.resize(at_.body.num_slices);
        if (scheme.kind == StepScheme::Kind::runge_kutta_chebyshev)
            at_.chebyshev_stages.resize(at_.body.num_slices);
        else if (scheme.kind != StepScheme::Kind::symplectic_euler)
            at_.stages.resize(at_.body.num_slices);
        for (auto &rows : at_.rows)
            rows.assign(4 * static_cast<std::size_t>(at_.body.num_rows + 1), T(0));
        if (damping.beta != 0.0)
            at_.velocity_rows = at_.rows;
        for (auto &rows : at_.rows)
            std::fill(rows.end() - 4, rows.end(), static_cast<T>(far));
        make_room_for_means(damping.beta != 0.0);
        partition_work(at_, pool_.size());
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
        Steps::set_state({Eigen::VectorXd::Zero(size), Eigen::VectorXd::Zero(size)});
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
            found[i] = Steps::displacement(nodes[i]);
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
        std::vector<std::size_t> left_parts; // rows of these
        for (const int node : changes.nodes) {
            const auto rows = scaled_mass_.leave(static_cast<std::size_t>(at_.body.row_of_node[node]));
            left_parts.insert(left_parts.end(), rows.begin(), rows.end());
            set_mass(node, node_mass[node]);
            if (node_mass[node] == 0.0)
                stop(static_cast<std::size_t>(node));
        }
        if (at_.body.is_around_edges())
            make_room_for_stars();
        return std::ranges::all_of(left_parts, [&](std::size_t row) {
            const auto &per_mass = at_.nodes[row / slice_size].free_per_mass;
            return per_mass[0][row % slice_size] == T(0); // gone
        });
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
    std::size_t working_set() const override {
        const auto &body = at_.body;
        return bytes(body.neighbour) + bytes(body.spring) + bytes(body.spring_lines) + bytes(body.corner) +
               bytes(body.force_slot) + bytes(body.sum) + bytes(body.rest_volume) + bytes(body.volume_share) +
               bytes(body.tetrahedron_stiffness) + bytes(body.least_volume) + bytes(body.guard_stiffness) +
               bytes(body.member) + bytes(body.volume_stiffness) + bytes(at_.nodes) + bytes(at_.loads) +
               bytes(at_.stages) + bytes(at_.chebyshev_stages) + 2 * bytes(at_.rows[0]) +
               2 * bytes(at_.velocity_rows[0]) + bytes(at_.gain) + bytes(at_.corner_force) + bytes(body.rest_gradient) +
               bytes(body.rest_length) + bytes(body.inner_modulus) + bytes(body.coupled_modulus) + bytes(at_.strain) +
               2 * bytes(at_.stress[0]) + bytes(body.inverse_volume) + 2 * bytes(at_.corner_strain[0]) +
               2 * bytes(at_.corner_rate[0]) + bytes(at_.gain_rate) + bytes(at_.push) + bytes(body.volume_modulus) +
               bytes(body.mean_node) + bytes(body.mean_gradient) + bytes(body.star_corner) + bytes(body.star_slot) +
               (body.has_gradient_stars ? 0 : bytes(body.star_tetrahedron)) + 3 * bytes(body.star_modulus) +
               bytes(body.rest_rows) + bytes(body.mean_volume) + bytes(body.mean_weight) + bytes(at_.change) +
               bytes(at_.change_rate) + bytes(at_.mean_push) + bytes(at_.relaxation.means.faded) +
               bytes(at_.relaxation.tetrahedra.faded);
    }

  private:
    static T per_mass(double mass) { return mass > 0.0 ? static_cast<T>(1.0 / mass) : T(0); }

    /// What has no mass stays where it is.
    void stop(std::size_t node) {
        const auto [slice, lane] = slot(node);
        for (std::size_t c = 0; c < 3; ++c)
            at_.nodes[slice].velocity.set(c, lane, 0.0);
        if (auto &rows = at_.velocity_rows[at_.now]; !rows.empty())
            std::fill_n(rows.begin() + 4 * static_cast<std::ptrdiff_t>(at_.body.row_of_node[node]), 3, T(0));
    }

    void make_room_for_stars() {
        at_.star_scratch.resize(static_cast<std::size_t>(pool_.size()));
        for (auto &scratch : at_.star_scratch)
            scratch.resize(numbers_of_star_corner * slice_size * (at_.body.longest_star + 2), T(0));
    }

    /// For what volumes and strains are around nodes, and for the forces of tetrahedra.
    void make_room_for_means(bool is_damped) {
        const auto &body = at_.body;
        const bool has_gradients = !body.mean_gradient.empty(), has_volumes_in_fans = body.has_volumes_in_fans();
        if (body.coupled_modulus.empty() || has_gradients)
            at_.gain.assign(body.corner.size() + slice_size, T(0));
        else if (body.inverse_volume.empty())
            at_.strain.assign(8 * (body.rest_volume.size() + 1), T(0));
        else
            for (auto &values : at_.corner_strain)
                values.assign(4 * (body.corner.size() + slice_size), T(0));
        // Dashpots inside tetrahedra alone would read these, and branches there.
        if (has_volumes_in_fans && !is_damped && at_.relaxation.empty()) {
            at_.body.rest_gradient = {};
            at_.body.inner_modulus = {};
        }
        if (!body.inverse_volume.empty())
            at_.push.assign(body.rest_volume.size(), T(0));
        if (is_damped && has_volumes_in_fans)
            at_.gain_rate = at_.gain;
        if (body.is_around_edges()) {
            at_.change.assign(body.volume_row.size(), T(0));
            at_.change_rate.assign(is_damped ? body.volume_row.size() : 0, T(0));
            at_.mean_push = at_.change;
            make_room_for_stars();
        }
        if (is_damped && !body.inverse_volume.empty())
            at_.corner_rate = at_.corner_strain;
        if (!body.coupled_modulus.empty() && !has_gradients)
            for (auto &rows : at_.stress)
                rows.assign(4 * static_cast<std::size_t>(body.num_rows + 1), T(0));
        const auto num_places = has_gradients ? body.first_pull + body.mean_node.size() + body.volume_row.size()
                                              : static_cast<std::size_t>(body.chunk_start.back()) + 1;
        at_.corner_force.assign(4 * num_places, T(0));
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

} // namespace

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
    if (!parts || !scheme || ((is_scaled || relaxes) && scheme->kind != StepScheme::Kind::symplectic_euler))
        return std::nullopt;
    if (relaxes && (options.may_be_cut || !can_relax(*parts)))
        return std::nullopt;
    const auto make = [&]<class T>(T /*precision*/) {
        return FastSteps(
            std::make_shared<Steps<T>>(*parts, body, positions, conditions, damping, *scheme, time_step, options));
    };
    return options.precision == ForcePrecision::single_precision ? make(float()) : make(double());
}

void FastSteps::set_state(const State &state) {
    implementation_->set_state(state);
}
State FastSteps::state() const {
    return implementation_->state();
}
core::Vector3 FastSteps::displacement(int node) const {
    return implementation_->displacement(node);
}
core::Vector3 FastSteps::velocity(int node) const {
    return implementation_->velocity(node);
}
void FastSteps::push(int node, const core::Vector3 &displacement, const core::Vector3 &velocity) {
    implementation_->push(node, displacement, velocity);
}
void FastSteps::displacements(std::span<const int> nodes, std::span<core::Vector3> found) const {
    implementation_->displacements(nodes, found);
}
void FastSteps::kick(std::span<const int> nodes, std::span<const core::Vector3> velocity, double time_step) {
    implementation_->kick(nodes, velocity, time_step);
}
void FastSteps::set_displacement(int node, const core::Vector3 &displacement) {
    implementation_->set_displacement(node, displacement);
}
void FastSteps::set_load(int node, const core::Vector3 &force) {
    implementation_->set_load(node, force);
}
void FastSteps::set_time_step(double time_step) {
    implementation_->set_time_step(time_step);
}
void FastSteps::set_mass(int node, double mass) {
    implementation_->set_mass(node, mass);
}
bool FastSteps::cut(const StepParts &parts, const std::vector<double> &node_mass, const CutChanges &changes) {
    return implementation_->cut(parts, node_mass, changes);
}
bool FastSteps::set_scaling(const MassScaling &scaling) {
    return implementation_->set_scaling(scaling);
}
bool FastSteps::is_pressed() const {
    return implementation_->is_pressed();
}
void FastSteps::take(int num_steps) {
    implementation_->take(num_steps);
}
void FastSteps::relax(double time) {
    implementation_->relax(time);
}
int FastSteps::steps_between_relaxations() const {
    return implementation_->steps_between_relaxations();
}
std::size_t FastSteps::working_set() const {
    return implementation_->working_set();
}

} // namespace livermark::msm
