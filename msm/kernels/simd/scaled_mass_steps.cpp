// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "msm/kernels/simd/scaled_mass_steps.cpp"
#include <Eigen/Dense>
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/support/vector_dispatch.hpp"
#include "msm/dynamics/time_step.hpp"
#include "msm/kernels/layout/slicing.hpp"
#include "msm/kernels/simd/vectors-inl.hpp"
#include "msm/kernels/step_workspace.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

template <class D, class T> HWY_INLINE Vec3<D> load(D d, const T *field, std::size_t size, std::size_t i) {
    return {hn::Load(d, field + i), hn::Load(d, field + size + i), hn::Load(d, field + 2 * size + i)};
}

template <class D, class T> HWY_INLINE void store(D d, const Vec3<D> &v, T *field, std::size_t size, std::size_t i) {
    hn::Store(v.x, d, field + i);
    hn::Store(v.y, d, field + size + i);
    hn::Store(v.z, d, field + 2 * size + i);
}

template <class D> HWY_INLINE Vec3<D> everywhere(D d, const core::Vector3 &v) {
    using T = hn::TFromD<D>;
    return {hn::Set(d, static_cast<T>(v.x())), hn::Set(d, static_cast<T>(v.y())), hn::Set(d, static_cast<T>(v.z()))};
}

/// Sum of the lanes, in one order on every machine with as many of them.
template <class D> HWY_INLINE double lane_sum(D d, hn::Vec<D> v) {
    HWY_ALIGN hn::TFromD<D> lanes[64 / sizeof(hn::TFromD<D>)];
    hn::Store(v, d, lanes);
    double sum = 0.0;
    for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane)
        sum += double{lanes[lane]};
    return sum;
}

template <class D> HWY_INLINE core::Vector3 lane_sums(D d, const Vec3<D> &v) {
    return {lane_sum(d, v.x), lane_sum(d, v.y), lane_sum(d, v.z)};
}

/// Rows of a sum of p q^T.
template <class D> struct Moment { Vec3<D> x, y, z; };

template <class D> HWY_INLINE void add_product(Moment<D> &moment, const Vec3<D> &p, const Vec3<D> &q) {
    moment.x = plus_scaled<D>(moment.x, p.x, q);
    moment.y = plus_scaled<D>(moment.y, p.y, q);
    moment.z = plus_scaled<D>(moment.z, p.z, q);
}

template <class D> HWY_INLINE Eigen::Matrix3d lane_sums(D d, const Moment<D> &moment) {
    Eigen::Matrix3d sums;
    sums.row(0) = lane_sums(d, moment.x);
    sums.row(1) = lane_sums(d, moment.y);
    sums.row(2) = lane_sums(d, moment.z);
    return sums;
}

/// A matrix times vectors.
template <class D> struct Turn {
    Vec3<D> x, y, z; ///< columns

    Turn(D d, const Eigen::Matrix3d &matrix)
        : x(everywhere(d, matrix.col(0))), y(everywhere(d, matrix.col(1))), z(everywhere(d, matrix.col(2))) {}
    HWY_INLINE Vec3<D> times(const Vec3<D> &v) const {
        return plus_scaled<D>(plus_scaled<D>(scaled<D>(v.x, x), v.y, y), v.z, z);
    }
};

template <class T> ScaledMassSums sums_of(const ScaledMassArrays<T> &part) {
    using D = Lanes<T>;
    constexpr D d;
    const auto none = everywhere(d, core::Vector3::Zero());
    auto sum_x = none, sum_v = none, sum_a = none, x_cross_a = none;
    Moment<D> x_and_x{none, none, none}, x_and_rest = x_and_x, x_and_v = x_and_x;
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        const auto m = hn::Load(d, part.mass.data() + i);
        const auto x = load(d, part.x.data(), part.size, i), v = load(d, part.v.data(), part.size, i),
                   a = load(d, part.a.data(), part.size, i);
        const auto weighted = scaled<D>(m, x);
        sum_x = plus<D>(sum_x, weighted);
        sum_v = plus_scaled<D>(sum_v, m, v);
        sum_a = plus_scaled<D>(sum_a, m, a);
        x_cross_a = plus<D>(x_cross_a, cross<D>(weighted, a));
        add_product<D>(x_and_x, weighted, x);
        add_product<D>(x_and_rest, weighted, load(d, part.rest.data(), part.size, i));
        add_product<D>(x_and_v, weighted, v);
    }
    return {.sum_x = lane_sums(d, sum_x),
            .sum_v = lane_sums(d, sum_v),
            .sum_a = lane_sums(d, sum_a),
            .x_and_x = lane_sums(d, x_and_x),
            .x_and_rest = lane_sums(d, x_and_rest),
            .x_and_v = lane_sums(d, x_and_v),
            .x_cross_a = lane_sums(d, x_cross_a)};
}

/// sum of m slow_k . field of each; four at a time, so that the field is read less often.
template <class T> void weigh(const ScaledMassArrays<T> &part, const T *field, std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const std::size_t length = 3 * part.size;
    std::size_t k = 0;
    for (; k + 4 <= part.num_slow; k += 4) {
        const T *slow = part.slow.data() + k * length;
        auto first = hn::Zero(d), second = first, third = first, fourth = first;
        for (std::size_t i = 0; i < length; i += hn::Lanes(d)) {
            const auto value = hn::Load(d, field + i);
            first = hn::MulAdd(hn::Load(d, slow + i), value, first);
            second = hn::MulAdd(hn::Load(d, slow + length + i), value, second);
            third = hn::MulAdd(hn::Load(d, slow + 2 * length + i), value, third);
            fourth = hn::MulAdd(hn::Load(d, slow + 3 * length + i), value, fourth);
        }
        weights[k] = lane_sum(d, first);
        weights[k + 1] = lane_sum(d, second);
        weights[k + 2] = lane_sum(d, third);
        weights[k + 3] = lane_sum(d, fourth);
    }
    for (; k < part.num_slow; ++k) {
        auto sum = hn::Zero(d);
        for (std::size_t i = 0; i < length; i += hn::Lanes(d))
            sum = hn::MulAdd(hn::Load(d, part.slow.data() + k * length + i), hn::Load(d, field + i), sum);
        weights[k] = lane_sum(d, sum);
    }
}

template <class T>
void strays_of(ScaledMassArrays<T> &part, const ScaledMassMotion &motion, std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const auto centre = everywhere(d, motion.centre), velocity = everywhere(d, motion.velocity),
               rotation = everywhere(d, motion.rotation), acceleration = everywhere(d, motion.acceleration),
               spin_up = everywhere(d, motion.spin_up);
    const auto two = hn::Set(d, T(2));
    const Turn<D> back(d, motion.turn.transpose());
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        const auto x = minus<D>(load(d, part.x.data(), part.size, i), centre);
        const auto relative = scaled<D>(two, minus<D>(load(d, part.v.data(), part.size, i), velocity));
        const auto turning = cross<D>(rotation, minus<D>(relative, cross<D>(rotation, x)));
        const auto rigid = plus<D>(acceleration, cross<D>(spin_up, x));
        const auto stray = minus<D>(load(d, part.a.data(), part.size, i), plus<D>(turning, rigid));
        store(d, x, part.x.data(), part.size, i);
        store(d, stray, part.stray.data(), part.size, i);
        // a is not looked at any more: its place is that of m turn^T stray.
        const auto m = hn::Load(d, part.mass.data() + i);
        if (part.num_slow > 0)
            store(d, scaled<D>(m, back.times(stray)), part.a.data(), part.size, i);
    }
    weigh(part, part.a.data(), weights);
}

template <class T>
SlowMomenta less_slow(ScaledMassArrays<T> &part, const Eigen::Matrix3d &turned_by, const std::vector<double> &weights) {
    using D = Lanes<T>;
    constexpr D d;
    const Turn<D> turn(d, turned_by);
    auto linear = everywhere(d, core::Vector3::Zero()), angular = linear;
    for (std::size_t i = 0; i < part.size; i += hn::Lanes(d)) {
        auto sum = everywhere(d, core::Vector3::Zero());
        const T *slow = part.slow.data();
        for (std::size_t k = 0; k < part.num_slow; ++k, slow += 3 * part.size)
            sum = plus_scaled<D>(sum, hn::Set(d, static_cast<T>(weights[k])), load(d, slow, part.size, i));
        const auto deforming = turn.times(sum);
        const auto weighted = scaled<D>(hn::Load(d, part.mass.data() + i), deforming);
        linear = plus<D>(linear, weighted);
        angular = plus<D>(angular, cross<D>(load(d, part.x.data(), part.size, i), weighted));
        store(d, minus<D>(load(d, part.stray.data(), part.size, i), deforming), part.stray.data(), part.size, i);
    }
    return {lane_sums(d, linear), lane_sums(d, angular)};
}

ScaledMassFunctions<float> functions_of_float() {
    return {sums_of<float>, strays_of<float>, less_slow<float>};
}
ScaledMassFunctions<double> functions_of_double() {
#if HWY_HAVE_FLOAT64
    return {sums_of<double>, strays_of<double>, less_slow<double>};
#else
    throw std::logic_error("masses in double precision need vectors of float64, which are not there");
#endif
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::msm {

LIVERMARK_DISPATCH(template <> ScaledMassFunctions<float> scaled_mass_functions, functions_of_float, (), ())
LIVERMARK_DISPATCH(template <> ScaledMassFunctions<double> scaled_mass_functions, functions_of_double, (), ())

namespace {

constexpr std::size_t nowhere = -1; ///< of a node in no part

template <class T>
ScaledMassPart<T> make_scaled_part(const ScaledRegion &scaled,
                                   const std::vector<std::pair<std::size_t, Eigen::Index>> &order,
                                   const std::vector<std::vector<std::size_t>> &copies) {
    ScaledMassPart<T> part;
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
template <class T> void weigh(ScaledMassPart<T> &part) {
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
template <class T> void gather(const StepWorkspace<T> &at, ScaledMassPart<T> &part) {
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
        // Lanes that fill the part up have no mass, but move to the centre with the others: in them what is no
        // number would stay.
        std::fill(x + part.row.size(), x + arrays.size, T(0));
        std::fill(a + part.row.size(), a + arrays.size, T(0));
    }
}

/// Adds the changes of the accelerations to where the step has come.
/// @param velocity, rotation  rigid motion that strays are still without [m/s^2, rad/s^2]
template <class T>
void add_changes(StepWorkspace<T> &at, const ScaledMassPart<T> &part, const core::Vector3 &velocity,
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

/// The accelerations of the scaled masses, in place of those of the step.
template <class T> void scale(StepWorkspace<T> &at, ScaledMassPart<T> &part) {
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
        // Slow deformations of a part that is not as at rest have rigid motion, too.
        const auto slow = functions.subtract_slow(arrays, motion.turn, part.weights);
        velocity = slow.linear / part.total_mass;
        rotation = inverse_inertia * slow.angular;
    }
    add_changes(at, part, velocity, rotation);
}

} // namespace

template <class T> ScaledMassSteps<T>::ScaledMassSteps(const MassScaling &scaling, const StepWorkspace<T> &at) {
    std::vector<std::vector<std::size_t>> copies(static_cast<std::size_t>(at.body.first_copy));
    for (std::size_t c = 0; c < at.body.copied_row.size(); ++c)
        copies[static_cast<std::size_t>(at.body.copied_row[c])].push_back(static_cast<std::size_t>(at.body.first_copy) +
                                                                          c);
    place_of_row_.resize(scaling.parts.empty() ? 0 : copies.size(), {nowhere, 0});
    for (const auto &scaled : scaling.parts) {
        std::vector<std::pair<std::size_t, Eigen::Index>> order; // as rows are in memory
        for (std::size_t i = 0; i < scaled.nodes.size(); ++i)
            order.emplace_back(static_cast<std::size_t>(at.body.row_of_node[scaled.nodes[i]]),
                               static_cast<Eigen::Index>(i));
        std::ranges::sort(order);
        for (std::size_t i = 0; i < order.size(); ++i)
            place_of_row_[order[i].first] = {parts_.size(), i};
        parts_.push_back(make_scaled_part<T>(scaled, order, copies));
    }
}

template <class T> void ScaledMassSteps<T>::set_mass(std::size_t row, double mass) {
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

template <class T> std::vector<std::size_t> ScaledMassSteps<T>::leave(std::size_t row) {
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

template <class T> void ScaledMassSteps<T>::move_copies(const RowMap &map) {
    for (auto &part : parts_)
        for (auto &[i, copy] : part.copies)
            copy = static_cast<std::size_t>(map.of(static_cast<int>(copy)));
}

template <class T> void ScaledMassSteps<T>::remember(const StepWorkspace<T> &at) {
    for (auto &part : parts_)
        for (std::size_t i = 0; i < part.row.size(); ++i) {
            const auto &slice = at.nodes[part.row[i] / slice_size];
            const std::size_t lane = part.row[i] % slice_size;
            for (std::size_t c = 0; c < 3; ++c)
                part.before[c][i] = slice.velocity.get(c, lane);
        }
}

template <class T> void ScaledMassSteps<T>::correct(StepWorkspace<T> &at) {
    for (auto &part : parts_) {
        if (!part.is_weighed)
            weigh(part);
        gather(at, part);
        scale(at, part);
    }
}

template class ScaledMassSteps<float>;
template class ScaledMassSteps<double>;

} // namespace livermark::msm
#endif
