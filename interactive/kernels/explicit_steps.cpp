// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/explicit_steps.cpp"
#include <hwy/foreach_target.h> // has to come before highway.h

#include <algorithm>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/vector_dispatch.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/elements/explicit_tetrahedra.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/kernels/point_springs-inl.hpp"
#include "interactive/kernels/tetrahedra-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Something at each corner or quadrature point of a tetrahedron: start and end of the axis, both nodes of the rim.
struct AtPoints {
    Matrix at[4];
};

/// factor a - b
HWY_INLINE Vec3 times_less(V factor, const Vec3 &a, const Vec3 &b) {
    return {hn::MulSub(factor, a.x, b.x), hn::MulSub(factor, a.y, b.y), hn::MulSub(factor, a.z, b.z)};
}

/// Corners to points or back: the matrix of barycentric coordinates at the points is symmetric.
HWY_INLINE void mix(AtPoints &of) {
    const auto far = number(0.138196601125010515F), near_less_far = number(0.447213595499957939F);
    const auto column = [&](Vec3 &a, Vec3 &b, Vec3 &r, Vec3 &s) HWY_ATTR {
        const auto shared = scaled(far, (a + b) + (r + s));
        a = plus_scaled(shared, near_less_far, a);
        b = plus_scaled(shared, near_less_far, b);
        r = plus_scaled(shared, near_less_far, r);
        s = plus_scaled(shared, near_less_far, s);
    };
    auto &[a, b, r, s] = of.at;
    column(a.x, b.x, r.x, s.x);
    column(a.y, b.y, r.y, s.y);
    column(a.z, b.z, r.z, s.z);
}

/// A node of the rim, and the middles between it and both ends of the axis.
struct RimNodes {
    Vec3 node, to_start, to_end;
};

HWY_INLINE RimNodes operator-(const RimNodes &a, const RimNodes &b) {
    return {a.node - b.node, a.to_start - b.to_start, a.to_end - b.to_end};
}

/// Nine of the ten nodes, from the start of the axis on.
struct TenNodes {
    Vec3 end, middle; ///< of the axis
    RimNodes from, to;
    Vec3 between; ///< both nodes of the rim

    /// The gradient of displacements at the corners before it is multiplied by those of the linear shape functions, by
    /// columns: those of end, from and to less that of start.
    HWY_INLINE AtPoints edges() const {
        const auto three = number(3.0F), four = number(4.0F);
        const auto at_start = [&](const Vec3 &to_middle) HWY_ATTR { return scaled(four, to_middle); };
        const auto start_middle = at_start(middle), from_middle = at_start(from.to_start),
                   to_middle = at_start(to.to_start);
        const auto end_from = scaled(four, from.to_end), end_to = scaled(four, to.to_end),
                   from_to = scaled(four, between);
        AtPoints e;
        e.at[0] = {start_middle - end, from_middle - from.node, to_middle - to.node};
        e.at[1] = {times_less(three, end, start_middle), (end_from - from.node) - start_middle,
                   (end_to - to.node) - start_middle};
        e.at[2] = {(end_from - end) - from_middle, times_less(three, from.node, from_middle),
                   (from_to - to.node) - from_middle};
        e.at[3] = {(end_to - end) - to_middle, (from_to - from.node) - to_middle,
                   times_less(three, to.node, to_middle)};
        return e;
    }
};

/// Forces that pull ten nodes inwards.
struct TenPulls {
    Vec3 start, end, middle;
    RimNodes from, to;
    Vec3 between;

    /// @param at  dW / d edges()
    explicit HWY_INLINE TenPulls(const AtPoints &at) {
        const auto three = number(3.0F), four = number(4.0F);
        const auto &[a, b, r, s] = at.at;
        const auto sum = [](const Matrix &m) HWY_ATTR { return m.x + (m.y + m.z); };
        const auto sum_a = sum(a), sum_b = sum(b), sum_r = sum(r), sum_s = sum(s); // of start, negative
        middle = scaled(four, a.x - sum_b);
        from.to_start = scaled(four, a.y - sum_r);
        to.to_start = scaled(four, a.z - sum_s);
        from.to_end = scaled(four, b.y + r.x);
        to.to_end = scaled(four, b.z + s.x);
        between = scaled(four, r.z + s.y);
        start = times_less(three, minus(sum_a), minus(sum_b + (sum_r + sum_s)));
        end = times_less(three, b.x, a.x + (r.x + s.x));
        from.node = times_less(three, r.y, a.y + (b.y + s.y));
        to.node = times_less(three, s.z, a.z + (b.z + r.z));
    }
};

/// Stresses from edges(): the derivative of the energy by it.
HWY_INLINE void find_stresses(AtPoints &at, const ShapeGradients &g, V shear, V bulk) {
    mix(at);
    for (auto &point : at.at) {
        const auto h = displacement_gradient(g, point.x, point.y, point.z);
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto jacobian = hn::Add(growth, number(1.0F));
        const auto inverse = hn::Div(number(1.0F), jacobian);
        const auto pressure = hn::Mul(hn::Mul(bulk, inverse), log_of(jacobian, growth));
        const auto p = stress_of(h, cofactors, growth, inverse, shear, pressure);
        point = {pull_of(p, g.b), pull_of(p, g.r), pull_of(p, g.s)};
    }
    mix(at);
}

/// Forces of tetrahedra into slots, summed at the nodes of fans.
inline HWY_NOINLINE void find_forces_of_quadratic_fans(ExplicitRows &rows) {
    constexpr std::size_t next = quadratic_lines.per_tetrahedron * slice_size;
    const Vec3 zero{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    const float *const nodes = rows.displacement.data();
    float *const forces = rows.force.data();
    const auto store_rim = [forces](const RimNodes &f, const std::int32_t *slot) HWY_ATTR {
        store(f.node, forces, slot);
        store(f.to_start, forces, slot + slice_size);
        store(f.to_end, forces, slot + 2 * slice_size);
    };
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            const std::size_t first = rows.first_corner(slice) + lane;
            const std::int32_t *corner = rows.corner.data() + first, *const slot = rows.slot.data() + first,
                               *rim = slot + 3 * slice_size;
            const auto start = fetch(nodes, corner).v;
            const auto from_start = [nodes, start](const std::int32_t *at)
                                        HWY_ATTR { return fetch(nodes, at).v - start; };
            const auto rim_from_start = [&](const std::int32_t *at) HWY_ATTR {
                return RimNodes{from_start(at), from_start(at + slice_size), from_start(at + 2 * slice_size)};
            };
            TenNodes x;
            x.end = from_start(corner + slice_size);
            x.middle = from_start(corner + 2 * slice_size);
            corner += 3 * slice_size;
            x.from = rim_from_start(corner);
            corner += 3 * slice_size;
            auto at_start = zero, at_end = zero, at_middle = zero;
            RimNodes before{zero, zero, zero};
            for (std::size_t line = rows.line_start[slice]; line < rows.line_start[slice + 1]; ++line) {
                const float *numbers = rows.tetrahedra.data() + line * numbers_of_tetrahedron * slice_size + lane;
                x.to = rim_from_start(corner);
                x.between = from_start(corner + 3 * slice_size);
                auto points = x.edges();
                find_stresses(points, ShapeGradients(numbers), hn::Load(d, numbers + 9 * slice_size),
                              hn::Load(d, numbers + 10 * slice_size));
                const TenPulls pull(points);
                store_rim(before - pull.from, rim);
                rim += line == rows.line_start[slice] ? 3 * slice_size : next;
                store(minus(pull.between), forces, rim + 3 * slice_size);
                before = RimNodes{zero, zero, zero} - pull.to;
                at_start = at_start - pull.start;
                at_end = at_end - pull.end;
                at_middle = at_middle - pull.middle;
                x.from = x.to;
                corner += next;
            }
            store_rim(before, rim);
            store(at_start, forces, slot);
            store(at_end, forces, slot + slice_size);
            store(at_middle, forces, slot + 2 * slice_size);
        }
}

/// V (J - 1) / 4 of tetrahedra, summed at the corners of fans.
HWY_NOINLINE void find_growth(ExplicitRows &rows) {
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            float *growth = rows.growth.data() + rows.first_corner(slice) + lane;
            float *rim = growth + 2 * slice_size;
            auto sum = hn::Zero(d), before = hn::Zero(d);
            Fans fans(rows, rows.displacement, rows.tetrahedra, slice, lane);
            const auto axis = fans.axis();
            for (; !fans.is_at_end(); fans.go_on(), rim += slice_size) {
                const auto h = displacement_gradient(fans.gradients(), axis, fans.from().v, fans.to().v);
                const auto here = hn::Mul(fans.number_of_tetrahedron(10), growth_of(h, cofactors_of(h)));
                hn::Store(hn::Add(before, here), d, rim);
                sum = hn::Add(sum, here);
                before = here;
            }
            hn::Store(before, d, rim);
            hn::Store(sum, d, growth);
            hn::Store(sum, d, growth + slice_size);
        }
}

/// p = lambda ln J / J of nodes, into the last place of their rows.
HWY_NOINLINE void find_pressures(ExplicitRows &rows) {
    const hn::RebindToSigned<D> whole;
    HWY_ALIGN float pressures[hn::MaxLanes(D())];
    for (std::size_t slice = 0; slice + 1 < rows.growth_start.size(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            auto sum = hn::Zero(d);
            for (std::size_t k = rows.growth_start[slice]; k < rows.growth_start[slice + 1]; ++k)
                sum = hn::Add(sum, hn::GatherIndex(d, rows.growth.data(),
                                                   hn::Load(whole, rows.growth_at.data() + k * slice_size + lane)));
            const std::size_t row = slice * slice_size + lane;
            const auto growth = hn::Mul(sum, hn::Load(d, rows.inverse_volume.data() + row));
            const auto jacobian = hn::Add(growth, number(1.0F));
            const auto pressure =
                hn::Div(hn::Mul(hn::Load(d, rows.lambda.data() + row), log_of(jacobian, growth)), jacobian);
            hn::Store(pressure, d, pressures);
            for (std::size_t i = 0; i < hn::Lanes(d); ++i)
                rows.displacement[4 * (row + i) + 3] = pressures[i];
        }
}

/// V P of neo-Hookean tetrahedra.
template <Pressure pressure_of> struct NeoHookeanStress {
    HWY_INLINE Matrix operator()(const Fans &fans, const Matrix &h) const {
        const auto cofactors = cofactors_of(h);
        const auto growth = growth_of(h, cofactors);
        const auto jacobian = hn::Add(growth, number(1.0F));
        const auto inverse = hn::Div(number(1.0F), jacobian);
        const auto shear = fans.number_of_tetrahedron(9), last = fans.number_of_tetrahedron(10);
        V pressure;
        if constexpr (pressure_of == Pressure::of_tetrahedra)
            pressure = hn::Mul(hn::Mul(last, inverse), log_of(jacobian, growth));
        else
            pressure = hn::Mul(last, fans.pressures());
        return stress_of(h, cofactors, growth, inverse, shear, pressure);
    }
};

template <Pressure pressure_of> HWY_NOINLINE void find_forces(ExplicitRows &rows) {
    find_forces_of_fans(rows, NeoHookeanStress<pressure_of>());
}

struct StepFactors {
    float keep, gain, step; ///< of velocities, of accelerations, h
};

/// Sums forces, and moves nodes.
HWY_NOINLINE void move_nodes(ExplicitRows &rows, const StepFactors &factors) {
    constexpr std::size_t width = 4 * nodes_at_once;
    const auto keep = number(factors.keep), gain = number(factors.gain), step = number(factors.step);
    for (std::size_t four = 0; four + 1 < rows.slot_start.size(); ++four)
        for (std::size_t lane = 0; lane < width; lane += hn::Lanes(d)) {
            const std::size_t at = four * width + lane;
            const auto elements = summed_slots(rows, rows.force, four, lane, hn::Load(d, rows.external.data() + at));
            const auto force = summed_slots(rows.springs, rows.springs.force, four, lane, elements);
            const auto inverse_mass = hn::Load(d, rows.inverse_mass.data() + at);
            const auto was = hn::Load(d, rows.velocity.data() + at);
            const auto moved = hn::MulAdd(hn::Mul(inverse_mass, gain), force, hn::Mul(keep, was));
            const auto velocity = hn::IfThenElse(hn::Gt(inverse_mass, hn::Zero(d)), moved, was);
            hn::Store(velocity, d, rows.velocity.data() + at);
            hn::Store(hn::MulAdd(step, velocity, hn::Load(d, rows.displacement.data() + at)), d,
                      rows.displacement.data() + at);
        }
}

void take(ExplicitRows &rows, double step, double mass_damping, int num_steps) {
    const double half = 0.5 * mass_damping * step;
    const StepFactors factors{static_cast<float>((1.0 - half) / (1.0 + half)), static_cast<float>(step / (1.0 + half)),
                              static_cast<float>(step)};
    for (int s = 0; s < num_steps; ++s) {
        if (rows.is_quadratic) {
            find_forces_of_quadratic_fans(rows);
        } else if (rows.pressure == Pressure::around_nodes) {
            find_growth(rows);
            find_pressures(rows);
            find_forces<Pressure::around_nodes>(rows);
        } else {
            find_forces<Pressure::of_tetrahedra>(rows);
        }
        find_forces_of_springs(rows.springs, rows.displacement);
        move_nodes(rows, factors);
    }
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

namespace {

/// Fans: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t fan_window = 512;

/// The corners of fans at each row, in the order of fans, one row behind the other.
class CornersOfRows {
  public:
    /// @param num_corners  (rows)
    explicit CornersOfRows(const std::vector<int> &num_corners) : start_(num_corners.size() + 1, 0) {
        std::partial_sum(num_corners.begin(), num_corners.end(), start_.begin() + 1);
        corners_.resize(start_.back());
        end_.assign(start_.begin(), start_.end() - 1);
    }

    void add(std::size_t row, std::size_t corner) { corners_[end_[row]++] = corner; }
    std::size_t size() const { return end_.size(); }
    std::span<const std::size_t> operator[](std::size_t row) const {
        return std::span(corners_).subspan(start_[row], start_[row + 1] - start_[row]);
    }

  private:
    std::vector<std::size_t> start_, end_, corners_;
};

class Builder {
  public:
    Builder(const Scene &scene, Pressure pressure, std::span<const PointSpring> springs)
        : scene_(&scene), springs_(springs), tetrahedra_(tetrahedra_at_rest(*scene.body)),
          has_orders_(scene.orders && scene.orders->fans.size() > 0) {
        if (has_orders_)
            rows_.fans = scene.orders->fans;
        else
            found_ = cut_into_fans(scene.body->mesh.tetrahedra);
        rows_.pressure = pressure;
        rows_.is_quadratic = !scene.own_nodes.empty();
        rows_.num_corners = scene.body->mesh.num_nodes();
        if (!rows_.is_quadratic)
            return;
        edges_ = core::edge_table(scene.body->mesh.tetrahedra).edges;
        first_edge_.assign(scene.body->mesh.points.size() + 1, 0);
        for (const auto &[low, high] : edges_)
            ++first_edge_[low + 1];
        std::partial_sum(first_edge_.begin(), first_edge_.end(), first_edge_.begin());
    }

    ExplicitRows build() {
        place_nodes();
        place_fans();
        place_slots();
        if (rows_.pressure == Pressure::around_nodes)
            place_pressures();
        rows_.springs = point_spring_rows(*scene_, springs_, rows_);
        return std::move(rows_);
    }

  private:
    /// Node in the middle of an edge, by its ends.
    int middle(int a, int b) const {
        const auto [low, high] = std::minmax(a, b);
        const auto edge = std::lower_bound(edges_.begin() + first_edge_[low], edges_.begin() + first_edge_[low + 1],
                                           std::array{low, high});
        return scene_->body->mesh.num_nodes() + static_cast<int>(edge - edges_.begin());
    }

    /// As FanLines says.
    const std::vector<int> &nodes_of_lines(std::size_t fan) {
        const auto [start, end] = rows_.fans.axis(fan);
        const auto rim = rows_.fans.rim(fan);
        auto &nodes = nodes_of_lines_;
        nodes = {start, end};
        if (rows_.is_quadratic)
            nodes.push_back(middle(start, end));
        for (std::size_t k = 0; k < rim.size(); ++k) {
            nodes.push_back(rim[k]);
            if (!rows_.is_quadratic)
                continue;
            nodes.push_back(middle(start, rim[k]));
            nodes.push_back(middle(end, rim[k]));
            if (k > 0)
                nodes.push_back(middle(rim[k - 1], rim[k]));
        }
        return nodes;
    }

    void place_nodes() {
        if (!has_orders_)
            list_fans();
        std::vector<int> num_slots(scene_->node_mass.size(), 0);
        for (std::size_t f = 0; f < rows_.fans.size(); ++f)
            for (const int node : nodes_of_lines(f))
                ++num_slots[node];
        const auto known = has_orders_ ? scene_->orders->rows : std::vector<int>();
        rows_.place(*scene_, known.size() == num_slots.size()
                                 ? known
                                 : order_of_nodes(scene_->body->mesh.tetrahedra, edges_, num_slots, known));
        std::vector<int> num_corners(rows_.num_rows, 0);
        for (std::size_t i = 0; i < num_slots.size(); ++i)
            num_corners[rows_.row_of_node[i]] = num_slots[i];
        corners_.emplace(num_corners);
    }

    void list_fans() {
        rows_.fans = {};
        rows_.fans.reserve(found_.size(), tetrahedra_.size());
        for (const auto &fan : found_)
            rows_.fans.add(fan.axis, fan.rim, fan.tetrahedra);
    }

    void sort_fans() {
        std::ranges::stable_sort(found_, {}, [&](const Fan &fan) {
            return std::minmax({rows_.row_of_node[fan.axis[0]], rows_.row_of_node[fan.axis[1]]});
        });
        sort_in_windows_of(fan_window, found_,
                           [](const Fan &a, const Fan &b) { return a.tetrahedra.size() > b.tetrahedra.size(); });
        list_fans();
    }

    void place_fans() {
        if (!has_orders_)
            sort_fans();
        const auto &fans = rows_.fans;
        rows_.line_start.assign(1, 0);
        for (std::size_t first = 0; first < fans.size(); first += slice_size) {
            const std::size_t last = std::min(first + slice_size, fans.size());
            std::size_t length = 0;
            for (std::size_t f = first; f < last; ++f)
                length = std::max(length, fans.tetrahedra(f).size());
            const std::size_t line = rows_.line_start.back(), corner = rows_.corner.size();
            rows_.line_start.push_back(line + length);
            const auto lines = rows_.lines();
            rows_.corner.resize(corner + (lines.per_tetrahedron * length + lines.per_fan) * slice_size, 0);
            rows_.tetrahedra.resize((line + length) * numbers_of_tetrahedron * slice_size, 0.0F);
            for (std::size_t f = first; f < last; ++f)
                place_fan(f, corner + f - first, length, line, f - first);
        }
    }

    void place_fan(std::size_t fan, std::size_t corner, std::size_t length, std::size_t line, std::size_t lane) {
        const auto &nodes = nodes_of_lines(fan);
        const std::size_t num_lines = rows_.lines().per_tetrahedron * length + rows_.lines().per_fan;
        for (std::size_t k = 0; k < num_lines; ++k, corner += slice_size) {
            const int row = rows_.row_of_node[nodes[std::min(k, nodes.size() - 1)]];
            rows_.corner[corner] = 4 * row;
            if (k < nodes.size())
                corners_->add(row, corner);
        }
        const auto rim = rows_.fans.rim(fan), numbers = rows_.fans.tetrahedra(fan);
        for (std::size_t k = 0; k < numbers.size(); ++k)
            place_tetrahedron(tetrahedra_[numbers[k]], {rows_.fans.axis(fan)[1], rim[k], rim[k + 1]},
                              rows_.tetrahedra.data() + (line + k) * numbers_of_tetrahedron * slice_size + lane);
    }

    void place_tetrahedron(const Tetrahedron &t, const std::array<int, 3> &nodes, float *at) const {
        const auto put = [&](double value) {
            *at = static_cast<float>(value);
            at += slice_size;
        };
        const auto gradients = t.shape_gradients();
        for (const int node : nodes)
            for (int j = 0; j < 3; ++j)
                put(gradients(std::ranges::find(t.nodes, node) - t.nodes.begin(), j));
        const double volume = rows_.is_quadratic ? t.volume / QuadraticTetrahedron::num_points : t.volume;
        put(volume * t.mu);
        put(rows_.pressure == Pressure::around_nodes ? 0.25 * volume : volume * t.lambda);
    }

    void place_slots() {
        rows_.slot_start.assign(1, 0);
        const auto &corners = *corners_;
        for (std::size_t first = 0; first < corners.size(); first += nodes_at_once) {
            std::size_t most = 0;
            for (std::size_t n = 0; n < nodes_at_once; ++n)
                most = std::max(most, corners[first + n].size());
            rows_.slot_start.push_back(rows_.slot_start.back() + most);
        }
        const std::size_t num_slots = nodes_at_once * rows_.slot_start.back();
        rows_.force.assign(4 * (num_slots + 1), 0.0F);
        rows_.slot.assign(rows_.corner.size(), static_cast<std::int32_t>(4 * num_slots));
        for (std::size_t row = 0; row < corners.size(); ++row)
            for (std::size_t k = 0; k < corners[row].size(); ++k) {
                const std::size_t four = rows_.slot_start[row / nodes_at_once] + k;
                rows_.slot[corners[row][k]] =
                    static_cast<std::int32_t>(4 * (nodes_at_once * four + row % nodes_at_once));
            }
    }

    void place_pressures() {
        const auto &corners = *corners_;
        rows_.growth.assign(rows_.corner.size() + 1, 0.0F);
        rows_.growth_start.assign(1, 0);
        for (std::size_t first = 0; first < rows_.num_rows; first += slice_size) {
            std::size_t most = 0;
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                most = std::max(most, corners[first + lane].size());
            const std::size_t at = slice_size * rows_.growth_start.back();
            rows_.growth_start.push_back(rows_.growth_start.back() + most);
            rows_.growth_at.resize(at + most * slice_size, static_cast<std::int32_t>(rows_.corner.size()));
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                for (std::size_t k = 0; k < corners[first + lane].size(); ++k)
                    rows_.growth_at[at + k * slice_size + lane] = static_cast<std::int32_t>(corners[first + lane][k]);
        }
        std::vector<double> volume(rows_.num_rows, 0.0), lambda = volume;
        for (const auto &t : tetrahedra_)
            for (const int node : t.nodes) {
                volume[rows_.row_of_node[node]] += 0.25 * t.volume;
                lambda[rows_.row_of_node[node]] += 0.25 * t.volume * t.lambda;
            }
        rows_.inverse_volume.assign(rows_.num_rows, 0.0F);
        rows_.lambda = rows_.inverse_volume;
        for (std::size_t row = 0; row < rows_.row_of_node.size(); ++row) {
            rows_.inverse_volume[row] = static_cast<float>(1.0 / volume[row]);
            rows_.lambda[row] = static_cast<float>(lambda[row] / volume[row]);
        }
    }

    const Scene *scene_;
    std::span<const PointSpring> springs_;
    std::vector<std::array<int, 2>> edges_; ///< with a node in the middle
    std::vector<int> first_edge_;           ///< (N + 1) whose lower node each is
    std::vector<Tetrahedron> tetrahedra_;
    bool has_orders_;
    std::vector<Fan> found_;          ///< where the scene has no orders
    std::vector<int> nodes_of_lines_; ///< of the fan that was asked for last
    std::optional<CornersOfRows> corners_;
    ExplicitRows rows_;
};

} // namespace

std::size_t ExplicitRows::bytes() const {
    return NodeRows::bytes() +
           bytes_of(line_start, corner, slot, tetrahedra, slot_start, force, growth, growth_start, growth_at,
                    inverse_volume, lambda) +
           springs.bytes();
}

Orders ExplicitRows::orders() const {
    Orders orders;
    orders.rows = order();
    if (is_quadratic)
        std::erase_if(orders.rows, [&](int node) { return node >= num_corners; });
    orders.fans = fans;
    return orders;
}

ExplicitRows explicit_rows(const Scene &scene, Pressure pressure, std::span<const PointSpring> springs) {
    return Builder(scene, pressure, springs).build();
}

LIVERMARK_DISPATCH(void take_explicit_steps, take,
                   (ExplicitRows & rows, double step, double mass_damping, int num_steps),
                   (rows, step, mass_damping, num_steps))

} // namespace livermark::interactive::kernels
#endif
