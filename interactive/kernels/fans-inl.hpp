// Fans of tetrahedra, and what they sum at their corners. Written once for each vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_FANS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_FANS_INL_HPP
#undef LIVERMARK_INTERACTIVE_FANS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_FANS_INL_HPP
#endif

#include "interactive/kernels/explicit_rows.hpp"
#include "interactive/kernels/neo_hookean-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Fans of a slice, one to a lane, on the way along their tetrahedra. Values of the rim are from the start of the axis
/// on.
class Fans {
  public:
    /// @param nodes    rows of four, as ExplicitRows::displacement
    /// @param numbers  of the tetrahedra, as ExplicitRows::tetrahedra
    HWY_INLINE Fans(const ExplicitRows &rows, const Aligned<float> &nodes, const Aligned<float> &numbers,
                    std::size_t slice, std::size_t lane)
        : nodes_(nodes.data()), corner_(rows.corner.data() + rows.first_corner(slice) + lane),
          start_(fetch(nodes_, corner_)), end_(fetch(nodes_, corner_ + slice_size)),
          numbers_(numbers.data() + rows.line_start[slice] * numbers_of_tetrahedron * slice_size + lane),
          last_(numbers_ +
                (rows.line_start[slice + 1] - rows.line_start[slice]) * numbers_of_tetrahedron * slice_size) {
        corner_ += 2 * slice_size;
        from_ = from_start(fetch(nodes_, corner_));
        corner_ += slice_size;
        to_ = from_start(fetch(nodes_, corner_));
    }

    HWY_INLINE bool is_at_end() const { return numbers_ == last_; }
    HWY_INLINE void go_on() {
        numbers_ += numbers_of_tetrahedron * slice_size;
        from_ = to_;
        if (is_at_end())
            return;
        corner_ += slice_size;
        to_ = from_start(fetch(nodes_, corner_));
    }

    HWY_INLINE V number_of_tetrahedron(std::size_t k) const { return hn::Load(d, numbers_ + k * slice_size); }
    HWY_INLINE ShapeGradients gradients() const { return ShapeGradients(numbers_); }
    HWY_INLINE Vec3 axis() const { return end_.v - start_.v; }
    HWY_INLINE V pressures() const { return hn::Add(hn::Add(start_.w, end_.w), hn::Add(from_.w, to_.w)); } ///< sum
    HWY_INLINE const Row &from() const { return from_; }
    HWY_INLINE const Row &to() const { return to_; }

  private:
    HWY_INLINE Row from_start(const Row &node) const { return {node.v - start_.v, node.w}; }

    const float *nodes_;
    const std::int32_t *corner_;
    Row start_, end_;
    const float *numbers_, *last_;
    Row from_, to_;
};

/// What tetrahedra of fans add at their corners, put into the slots of the fans.
class FanSums {
  public:
    /// @param slots   as ExplicitRows::force
    /// @param corner  the slot of the start of the axis, in ExplicitRows::slot
    HWY_INLINE FanSums(Aligned<float> &slots, const std::int32_t *corner)
        : slots_(slots.data()), axis_(corner), rim_(corner + 2 * slice_size), start_(zero()), end_(zero()),
          from_(zero()) {}

    /// Of the next tetrahedron.
    HWY_INLINE void add(const Vec3 &start, const Vec3 &end, const Vec3 &from, const Vec3 &to) {
        start_ = start_ + start;
        end_ = end_ + end;
        store(from_ + from, slots_, rim_);
        from_ = to;
        rim_ += slice_size;
    }
    /// Forces of the next tetrahedron.
    /// @param stress  V P
    HWY_INLINE void add_forces(const Matrix &stress, const ShapeGradients &g) {
        const auto of_end = pull_of(stress, g.b), at_from = pull_of(stress, g.r), at_to = pull_of(stress, g.s);
        add(at_from + at_to + of_end, minus(of_end), minus(at_from), minus(at_to));
    }
    HWY_INLINE void finish() const {
        store(from_, slots_, rim_);
        store(end_, slots_, axis_ + slice_size);
        store(start_, slots_, axis_);
    }

  private:
    static HWY_INLINE Vec3 zero() { return {hn::Zero(d), hn::Zero(d), hn::Zero(d)}; }

    float *slots_;
    const std::int32_t *axis_, *rim_;
    Vec3 start_, end_, from_;
};

/// Forces of tetrahedra, summed at the corners of fans.
/// @param stress  of fans and the gradient H of their displacements: V P
template <class Stress> HWY_INLINE void find_forces_of_fans(ExplicitRows &rows, const Stress &stress) {
    for (std::size_t slice = 0; slice < rows.num_slices(); ++slice)
        for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
            FanSums sums(rows.force, rows.slot.data() + rows.first_corner(slice) + lane);
            Fans fans(rows, rows.displacement, rows.tetrahedra, slice, lane);
            const auto axis = fans.axis();
            for (; !fans.is_at_end(); fans.go_on()) {
                const auto g = fans.gradients();
                const auto h = displacement_gradient(g, axis, fans.from().v, fans.to().v);
                sums.add_forces(stress(fans, h), g);
            }
            sums.finish();
        }
}

/// What slots hold for four nodes side by side, summed in their order.
HWY_INLINE V summed_slots(const ExplicitRows &rows, const Aligned<float> &slots, std::size_t four, std::size_t lane,
                          V sum) {
    for (std::size_t k = rows.slot_start[four]; k < rows.slot_start[four + 1]; ++k)
        sum = hn::Add(sum, hn::Load(d, slots.data() + k * 4 * nodes_at_once + lane));
    return sum;
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_FANS_INL_HPP
