// Highway compiles this file once for each vector unit, and the machine's best one is taken when the program runs.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "interactive/kernels/descent_steps.cpp"
#include <algorithm>
#include <hwy/foreach_target.h> // has to come before highway.h
#include <utility>

#include "core/support/vector_dispatch.hpp"
#include "interactive/elements/energies.hpp"
#include "interactive/kernels/method_steps.hpp"
#include "interactive/kernels/orders.hpp"
#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// A neighbour as seen from the node that moves.
struct Neighbour {
    Vec3 rest, moved; ///< where it is at rest, and its displacement from there
};

HWY_INLINE Neighbour chosen(hn::Mask<D> is_first, const Neighbour &first, const Neighbour &second) {
    return {chosen(is_first, first.rest, second.rest), chosen(is_first, first.moved, second.moved)};
}

/// Adds the gradient and the second derivatives of springs beside the tetrahedra by the nodes of a batch. What is
/// across a spring that is pressed is left out.
HWY_INLINE void add_springs(const DescentRows &rows, std::size_t batch, std::size_t lane, const Vec3 &here,
                            Vec3 &gradient, Symmetric &hessian) {
    const std::size_t first = rows.spring_start[batch], last = rows.spring_start[batch + 1];
    const std::int32_t *other = rows.spring_other.data() + first * others_in_line * slice_size + lane;
    const float *numbers = rows.spring_numbers.data() + first * numbers_of_spring_line * slice_size + lane;
    for (std::size_t k = first; k < last;
         ++k, other += others_in_line * slice_size, numbers += numbers_of_spring_line * slice_size) {
        const auto entry = [&](std::size_t n) HWY_ATTR { return hn::Load(d, numbers + n * slice_size); };
        Vec3 moved{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t b = 0; b < others_in_line; ++b)
            moved = plus_scaled(moved, entry(b), fetch(rows.displacement.data(), other + b * slice_size).v - here);
        const auto weight = entry(3), stiffness = entry(8);
        const StretchedSpring spring(load3(numbers + 4 * slice_size), moved, entry(7));
        const auto tension = hn::Div(hn::Mul(stiffness, spring.change), spring.length);
        gradient = plus_scaled(gradient, hn::Mul(weight, tension), spring.now);
        const auto square = hn::Mul(weight, weight), pulled = hn::Max(tension, hn::Zero(d));
        const auto across = hn::Mul(square, pulled);
        hessian.xx = hn::Add(hessian.xx, across);
        hessian.yy = hn::Add(hessian.yy, across);
        hessian.zz = hn::Add(hessian.zz, across);
        const auto along = hn::Div(hn::Sub(stiffness, pulled), hn::Mul(spring.length, spring.length));
        add_outer(hessian, hn::Mul(square, along), spring.now);
    }
}

/// A step of Newton's method for the nodes of a batch. With p, q, r the corners of a facet opposite the node, from
/// there on, 6 V J is n . p with n = (q - p) x (r - p), and minus its gradient is n. What n and n . p are at rest is
/// taken away before it is lost in the rounding; the rest of the energy is a Laplacian, whose entries are constant.
HWY_INLINE void descend(DescentRows &rows, std::size_t batch, std::size_t lane, V inertia) {
    const std::size_t row = batch * slice_size + lane;
    const auto here = load_rows(rows.displacement, row);
    const auto stiffness = hn::Mul(inertia, hn::Load(d, rows.mass.data() + row));
    auto gradient = scaled(stiffness, here - load_rows(rows.predicted, row));
    const auto zero = hn::Zero(d), diagonal = hn::Add(stiffness, hn::Load(d, rows.laplacian.data() + row));
    Symmetric hessian{diagonal, zero, zero, diagonal, zero, diagonal};
    const Vec3 none{zero, zero, zero};
    Neighbour p{none, none}, q{none, none}, r{none, none};
    const std::int32_t *index = rows.neighbour.data() + rows.line_start[batch] * slice_size + lane;
    const float *numbers = rows.numbers.data() + rows.line_start[batch] * numbers_of_line * slice_size + lane;
    const std::size_t num_lines = rows.line_start[batch + 1] - rows.line_start[batch];
    for (std::size_t k = 0; k < num_lines; ++k, index += slice_size, numbers += numbers_of_line * slice_size) {
        const auto signed_modulus = hn::Load(d, numbers + 4 * slice_size);
        p = chosen(hn::Lt(signed_modulus, zero), p, q);
        q = r;
        r = {load3(numbers), fetch(rows.displacement.data(), index).v - here};
        const auto modulus = hn::Abs(signed_modulus);
        const auto rest1 = q.rest - p.rest, rest2 = r.rest - p.rest;
        const auto moved1 = q.moved - p.moved, moved2 = r.moved - p.moved;
        const auto at_rest = cross(rest1, rest2);
        const auto change = cross(rest1, moved2) + cross(moved1, rest2 + moved2);
        const auto growth = hn::Add(dot(at_rest, p.moved), dot(change, p.rest + p.moved));
        const auto normal = at_rest + change;
        gradient = plus_scaled(gradient, hn::Load(d, numbers + 3 * slice_size), r.moved);
        gradient = plus_scaled(gradient, hn::Load(d, numbers + 5 * slice_size), change);
        gradient = plus_scaled(gradient, hn::Neg(hn::Mul(modulus, growth)), normal);
        add_outer(hessian, modulus, normal);
    }
    add_springs(rows, batch, lane, here, gradient, hessian);
    // By the diagonal, so that nothing overflows.
    const auto scale = hn::Div(number(1.0F), diagonal);
    const auto [adjugate, determinant] = adjugate_of(scaled(scale, hessian));
    store_rows(plus_scaled(here, hn::Neg(hn::Div(scale, determinant)), product(adjugate, gradient)), rows.displacement,
               row);
}

HWY_NOINLINE void sweep(DescentRows &rows, float inertia) {
    for (std::size_t batch = 0; batch < rows.num_batches(); ++batch)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d))
            descend(rows, batch, lane, number(inertia));
}

/// As Inertia says, and where iterations begin.
HWY_NOINLINE void begin(DescentRows &rows, float step, float damping) {
    const auto h = number(step), h_squared = number(step * step), inverse_damping = number(1.0F / damping);
    const std::size_t num_free = slice_size * rows.num_batches();
    for (std::size_t row = 0; row < num_free; row += hn::Lanes(d)) {
        const auto inverse_mass = hn::Div(number(1.0F), hn::Load(d, rows.mass.data() + row));
        const auto was = load_rows(rows.displacement, row), velocity = load_rows(rows.velocity, row);
        const auto force = load_rows(rows.external, row);
        const auto push = scaled(inverse_mass, force);
        const auto last = velocity - load_rows(rows.last_velocity, row); // times h
        const auto squared = hn::Max(dot(push, push), number(1e-30F));
        const auto followed = hn::Div(dot(last, push), hn::Mul(h, squared));
        const auto part = hn::Min(hn::Max(followed, hn::Zero(d)), number(1.0F));
        const auto whole = plus_scaled(scaled(h, velocity), h_squared, push);
        store_rows(was, rows.before, row);
        store_rows(plus_scaled(was, inverse_damping, whole), rows.predicted, row);
        store_rows(plus_scaled(plus_scaled(was, h, velocity), hn::Mul(h_squared, part), push), rows.displacement, row);
    }
    const auto first = static_cast<std::ptrdiff_t>(4 * num_free);
    std::copy(rows.displacement.begin() + first, rows.displacement.end(), rows.before.begin() + first);
    std::copy(rows.predicted.begin() + first, rows.predicted.end(), rows.displacement.begin() + first);
}

/// x = omega (x - x'') + x''
HWY_NOINLINE void accelerate(DescentRows &rows, float weight) {
    const auto omega = number(weight);
    for (std::size_t at = 0; at < rows.displacement.size(); at += hn::Lanes(d)) {
        const auto older = hn::Load(d, rows.oldest.data() + at);
        const auto moved = hn::Sub(hn::Load(d, rows.displacement.data() + at), older);
        hn::Store(hn::MulAdd(omega, moved, older), d, rows.displacement.data() + at);
    }
}

void take_descent(DescentRows &rows, double time_step, double mass_damping, int iterations) {
    const double damping = 1.0 + mass_damping * time_step;
    begin(rows, static_cast<float>(time_step), static_cast<float>(damping));
    const auto inertia = static_cast<float>(damping / (time_step * time_step));
    const double rho = chebyshev_rho(iterations);
    double weight = 1.0;
    for (int i = 1; i <= iterations; ++i) {
        weight = chebyshev_weight(i, weight, rho);
        rows.oldest.swap(rows.older);
        if (i < iterations)
            std::ranges::copy(rows.displacement, rows.older.begin());
        sweep(rows, inertia);
        if (weight != 1.0)
            accelerate(rows, static_cast<float>(weight));
        if (rows.after_iteration)
            rows.after_iteration();
    }
    rows.last_velocity.swap(rows.velocity);
    find_velocities(rows, rows.before, static_cast<float>(1.0 / time_step));
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::interactive::kernels {

namespace {

/// Nodes of one colour: large enough to find some that are alike, small enough to stay near.
constexpr std::size_t window_of_colour = 256;

class DescentBuilder {
  public:
    DescentBuilder(const Scene &scene, std::span<const PointSpring> springs)
        : scene_(&scene), springs_(springs), springs_at_(springs_at_nodes(springs, scene.node_mass.size())),
          rest_(rest_positions(scene)), tetrahedra_(tetrahedra_at_rest(*scene.body)), is_free_(free_nodes(scene)),
          around_(scene.node_mass.size()), strips_(scene.node_mass.size()) {
        for (std::size_t t = 0; t < tetrahedra_.size(); ++t)
            for (const int node : tetrahedra_[t].nodes)
                around_[node].push_back(static_cast<int>(t));
        if (scene.orders && scene.orders->strips.size() == strips_.size())
            strips_ = scene.orders->strips;
        for (std::size_t i = 0; i < strips_.size(); ++i)
            if (is_free_[i] && strips_[i].empty())
                strips_[i] = strips_around(static_cast<int>(i));
        laplacian_.assign(strips_.size(), 0.0);
    }

    DescentRows build(const Colouring &colours) {
        place_nodes(colours);
        rows_.line_start.assign(1, 0);
        for (std::size_t first = 0; first < node_in_row_.size(); first += slice_size)
            place_batch(first);
        rows_.spring_start.assign(1, 0);
        for (std::size_t first = 0; first < node_in_row_.size(); first += slice_size)
            place_springs(first);
        for (auto *field : {&rows_.displacement, &rows_.before, &rows_.predicted, &rows_.velocity, &rows_.last_velocity,
                            &rows_.external, &rows_.older, &rows_.oldest})
            field->assign(4 * rows_.num_rows, 0.0F);
        rows_.strips = std::move(strips_);
        return std::move(rows_);
    }

  private:
    static constexpr int nobody = -1;

    /// The three nodes of a tetrahedron that are not this one.
    std::array<int, 3> opposite(int tetrahedron, int node) const {
        std::array<int, 3> facet{};
        std::size_t found = 0;
        for (const int other : tetrahedra_[tetrahedron].nodes)
            if (other != node)
                facet[found++] = other;
        return facet;
    }

    /// With numbers of tetrahedra as those of triangles.
    std::vector<StripNode> strips_around(int node) const {
        std::vector<std::array<int, 3>> facets;
        for (const int t : around_[node])
            facets.push_back(opposite(t, node));
        auto strips = cut_into_strips(facets);
        for (auto &entry : strips)
            if (entry.triangle >= 0)
                entry.triangle = around_[node][entry.triangle];
        return strips;
    }

    void place_nodes(const Colouring &colours) {
        for (int c = 0; c < colours.num_colours(); ++c) {
            std::vector<int> nodes;
            std::copy_if(colours.order.begin() + colours.offsets[c], colours.order.begin() + colours.offsets[c + 1],
                         std::back_inserter(nodes), [&](int node) { return is_free_[node]; });
            sort_in_windows_of(window_of_colour, nodes,
                               [&](int a, int b) { return strips_[a].size() > strips_[b].size(); });
            node_in_row_.insert(node_in_row_.end(), nodes.begin(), nodes.end());
            node_in_row_.resize(filled_up(node_in_row_.size()), nobody);
        }
        rows_.row_of_node.resize(is_free_.size());
        for (std::size_t row = 0; row < node_in_row_.size(); ++row)
            if (node_in_row_[row] != nobody)
                rows_.row_of_node[node_in_row_[row]] = static_cast<int>(row);
        rows_.num_rows = node_in_row_.size();
        for (std::size_t i = 0; i < is_free_.size(); ++i)
            if (!is_free_[i])
                rows_.row_of_node[i] = static_cast<int>(rows_.num_rows++);
        rows_.num_rows = filled_up(rows_.num_rows);
        rows_.mass.assign(node_in_row_.size(), 1.0F);
        rows_.laplacian.assign(node_in_row_.size(), 0.0F);
    }

    void place_batch(std::size_t first) {
        std::size_t length = 0;
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                length = std::max(length, strips_[node_in_row_[row]].size());
        const std::size_t line = rows_.line_start.back();
        rows_.line_start.push_back(line + length);
        rows_.numbers.resize((line + length) * numbers_of_line * slice_size, 0.0F);
        for (std::size_t k = 0; k < length; ++k)
            for (std::size_t lane = 0; lane < slice_size; ++lane)
                rows_.neighbour.push_back(static_cast<std::int32_t>(4 * (first + lane)));
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                place_node(row, line);
    }

    void place_node(std::size_t row, std::size_t line) {
        const int node = node_in_row_[row];
        rows_.mass[row] = static_cast<float>(scene_->node_mass[node]);
        find_laplacian(node);
        rows_.laplacian[row] = static_cast<float>(std::exchange(laplacian_[node], 0.0));
        const auto &points = scene_->body->mesh.points;
        std::array<int, 3> triangle{};
        for (const auto &[neighbour, tetrahedron, keeps_first] : strips_[node]) {
            rows_.neighbour[line * slice_size + row % slice_size] = 4 * rows_.row_of_node[neighbour];
            float *at = rows_.numbers.data() + line * numbers_of_line * slice_size + row % slice_size;
            const auto put = [&](double value) {
                *at = static_cast<float>(value);
                at += slice_size;
            };
            for (const double component : core::Vector3(points[neighbour] - points[node]))
                put(component);
            put(std::exchange(laplacian_[neighbour], 0.0));
            triangle = {keeps_first ? triangle[0] : triangle[1], triangle[2], neighbour};
            if (tetrahedron >= 0) {
                const auto &t = tetrahedra_[tetrahedron];
                put((keeps_first ? -1.0 : 1.0) * (t.lambda + t.mu) / (36.0 * t.volume));
                put(sign_of(node, triangle) * t.mu / 6.0);
            }
            ++line;
        }
    }

    void place_springs(std::size_t first) {
        std::size_t length = 0;
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                length = std::max(length, springs_at_[node_in_row_[row]].size());
        const std::size_t line = rows_.spring_start.back();
        rows_.spring_start.push_back(line + length);
        for (std::size_t k = 0; k < length; ++k) {
            for (std::size_t b = 0; b < others_in_line; ++b)
                for (std::size_t lane = 0; lane < slice_size; ++lane)
                    rows_.spring_other.push_back(static_cast<std::int32_t>(4 * (first + lane)));
            for (std::size_t n = 0; n < numbers_of_spring_line; ++n) // those that fill up are of some length
                rows_.spring_numbers.insert(rows_.spring_numbers.end(), slice_size, n == 4 || n == 7 ? 1.0F : 0.0F);
        }
        for (std::size_t row = first; row < first + slice_size; ++row)
            if (node_in_row_[row] != nobody)
                for (std::size_t k = 0; k < springs_at_[node_in_row_[row]].size(); ++k)
                    place_spring(springs_at_[node_in_row_[row]][k], line + k, row % slice_size);
    }

    void place_spring(const SpringEnd &end, std::size_t line, std::size_t lane) {
        const auto &spring = springs_[end.spring];
        const auto put = [&](std::size_t n, double value) {
            rows_.spring_numbers[(line * numbers_of_spring_line + n) * slice_size + lane] = static_cast<float>(value);
        };
        std::size_t b = 0;
        for (std::size_t a = 0; a < spring.nodes.size(); ++a) {
            if (a == end.place)
                continue;
            rows_.spring_other[(line * others_in_line + b) * slice_size + lane] =
                4 * rows_.row_of_node[spring.nodes[a]];
            put(b++, spring.weights[a]);
        }
        put(3, spring.weights[end.place]);
        const core::Vector3 at_rest = spring.span(rest_);
        for (std::size_t c = 0; c < 3; ++c)
            put(4 + c, at_rest[static_cast<Eigen::Index>(c)]);
        put(7, spring.rest_length);
        put(8, spring.stiffness);
    }

    double sign_of(int node, const std::array<int, 3> &triangle) const {
        const auto &points = scene_->body->mesh.points;
        Matrix3 edges;
        for (int c = 0; c < 3; ++c)
            edges.col(c) = points[triangle[c]] - points[node];
        return edges.determinant() > 0.0 ? 1.0 : -1.0;
    }

    /// Adds to nothing a node's row of the Laplacian: sum of V mu g . g with itself and its neighbours.
    void find_laplacian(int node) {
        for (const int number : around_[node]) {
            const auto &t = tetrahedra_[number];
            const auto gradients = t.shape_gradients();
            const auto own = gradients.row(std::ranges::find(t.nodes, node) - t.nodes.begin());
            for (int c = 0; c < 4; ++c)
                laplacian_[t.nodes[c]] += t.volume * t.mu * gradients.row(c).dot(own);
        }
    }

    const Scene *scene_;
    std::span<const PointSpring> springs_;
    std::vector<std::vector<SpringEnd>> springs_at_; ///< (N)
    Field rest_;
    std::vector<Tetrahedron> tetrahedra_;
    std::vector<bool> is_free_;
    std::vector<std::vector<int>> around_;       ///< (N) tetrahedra
    std::vector<std::vector<StripNode>> strips_; ///< (N) none where constrained
    std::vector<int> node_in_row_;               ///< of the batches
    std::vector<double> laplacian_;              ///< (N) row of the node that is being placed; zero between nodes
    DescentRows rows_;
};

} // namespace

std::size_t DescentRows::bytes() const {
    return bytes_of(line_start, neighbour, numbers, mass, laplacian, spring_start, spring_other, spring_numbers,
                    displacement, before, predicted, velocity, last_velocity, external, older, oldest);
}

DescentRows descent_rows(const Scene &scene, const Colouring &colours, std::span<const PointSpring> springs) {
    return DescentBuilder(scene, springs).build(colours);
}

LIVERMARK_DISPATCH(void take_descent_step, take_descent,
                   (DescentRows & rows, double time_step, double mass_damping, int iterations),
                   (rows, time_step, mass_damping, iterations))

} // namespace livermark::interactive::kernels
#endif
