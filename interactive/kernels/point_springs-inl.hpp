// Springs beside elements, one to a lane. Written once for each vector unit: see explicit_steps.cpp.
#if defined(LIVERMARK_INTERACTIVE_POINT_SPRINGS_INL_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef LIVERMARK_INTERACTIVE_POINT_SPRINGS_INL_HPP
#undef LIVERMARK_INTERACTIVE_POINT_SPRINGS_INL_HPP
#else
#define LIVERMARK_INTERACTIVE_POINT_SPRINGS_INL_HPP
#endif

#include "interactive/kernels/point_spring_rows.hpp"
#include "interactive/kernels/vectors-inl.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::interactive::kernels::HWY_NAMESPACE {

/// Springs of a batch, from a lane on.
class PointSpringLanes {
  public:
    HWY_INLINE PointSpringLanes(const PointSpringSet &set, std::size_t batch, std::size_t lane)
        : num_nodes_(set.num_nodes), corner_(set.corner.data() + batch * set.num_nodes * slice_size + lane),
          slot_(set.slot.data() + batch * set.num_nodes * slice_size + lane),
          numbers_(set.numbers.data() + batch * set.num_numbers() * slice_size + lane) {}

    /// Sum of w v, from the first node on, so that nothing of a common motion is left.
    /// @param nodes  v, rows of four
    HWY_INLINE Vec3 span(const Aligned<float> &nodes) const {
        const auto first = fetch(nodes.data(), corner_).v;
        Vec3 sum{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
        for (std::size_t a = 1; a < num_nodes_; ++a)
            sum = plus_scaled(sum, weight(a), fetch(nodes.data(), corner_ + a * slice_size).v - first);
        return sum;
    }
    HWY_INLINE StretchedSpring stretched(const Aligned<float> &displacement) const {
        return {load3(numbers_ + num_nodes_ * slice_size), span(displacement), number_behind(3)};
    }
    HWY_INLINE V stiffness() const { return number_behind(4); }

    /// Puts value(w) of each node into its slot.
    template <class Value> HWY_INLINE void put(Aligned<float> &slots, const Value &value) const {
        for (std::size_t a = 0; a < num_nodes_; ++a)
            store(value(weight(a)), slots.data(), slot_ + a * slice_size);
    }

  private:
    HWY_INLINE V weight(std::size_t a) const { return hn::Load(d, numbers_ + a * slice_size); }
    HWY_INLINE V number_behind(std::size_t k) const { return hn::Load(d, numbers_ + (num_nodes_ + k) * slice_size); }

    std::size_t num_nodes_;
    const std::int32_t *corner_, *slot_;
    const float *numbers_;
};

/// Forces of springs, into their slots.
/// @param displacement  rows of four
inline HWY_NOINLINE void find_forces_of_springs(PointSpringRows &springs, const Aligned<float> &displacement) {
    for (const auto &set : springs.sets)
        for (std::size_t batch = 0; batch < set.num_batches(); ++batch)
            for (std::size_t lane = 0; lane < slice_size; lane += hn::Lanes(d)) {
                const PointSpringLanes lanes(set, batch, lane);
                const auto spring = lanes.stretched(displacement);
                const auto inwards = hn::Neg(hn::Div(hn::Mul(lanes.stiffness(), spring.change), spring.length));
                lanes.put(springs.force,
                          [&](V weight) HWY_ATTR { return scaled(hn::Mul(weight, inwards), spring.now); });
            }
}

} // namespace livermark::interactive::kernels::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif // LIVERMARK_INTERACTIVE_POINT_SPRINGS_INL_HPP
