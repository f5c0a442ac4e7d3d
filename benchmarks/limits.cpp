#include "benchmarks/limits.hpp"

#include <cstring>

// This file is compiled once for every instruction set, by including itself.
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "benchmarks/limits.cpp"
#include <hwy/foreach_target.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <hwy/highway.h>
#include <limits>
#include <new>
#include <numeric>
#include <unistd.h>

#include "msm/kernels/layout/sliced_body.hpp"

HWY_BEFORE_NAMESPACE();
namespace livermark::benchmarks::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET == HWY_SCALAR
// For a machine without vectors of four.
void fetch_kernel(const float *HWY_RESTRICT positions, const std::uint32_t *HWY_RESTRICT offsets, std::size_t size,
                  float *HWY_RESTRICT sum) {
    for (int c = 0; c < 4; ++c)
        sum[c] = 0.0F;
    for (std::size_t k = 0; k < size; ++k)
        for (int c = 0; c < 4; ++c)
            sum[c] += positions[offsets[k] + c];
}
#else
void fetch_kernel(const float *HWY_RESTRICT positions, const std::uint32_t *HWY_RESTRICT offsets, std::size_t size,
                  float *HWY_RESTRICT sum) {
    const hn::FixedTag<float, 4> four;
    // Eight sums: an addition takes four cycles, and two begin in each.
    auto s0 = hn::Zero(four), s1 = s0, s2 = s0, s3 = s0, s4 = s0, s5 = s0, s6 = s0, s7 = s0;
    // Two offsets in each read: positions are not the only thing that reads have to be made for.
    const auto low = [positions](std::uint64_t pair) { return positions + static_cast<std::uint32_t>(pair); };
    const auto high = [positions](std::uint64_t pair) { return positions + (pair >> 32); };
    std::uint64_t pairs[4];
    for (std::size_t k = 0; k < size; k += 8) {
        std::memcpy(pairs, offsets + k, sizeof(pairs));
        s0 = hn::Add(s0, hn::Load(four, low(pairs[0])));
        s1 = hn::Add(s1, hn::Load(four, high(pairs[0])));
        s2 = hn::Add(s2, hn::Load(four, low(pairs[1])));
        s3 = hn::Add(s3, hn::Load(four, high(pairs[1])));
        s4 = hn::Add(s4, hn::Load(four, low(pairs[2])));
        s5 = hn::Add(s5, hn::Load(four, high(pairs[2])));
        s6 = hn::Add(s6, hn::Load(four, low(pairs[3])));
        s7 = hn::Add(s7, hn::Load(four, high(pairs[3])));
    }
    s0 = hn::Add(hn::Add(hn::Add(s0, s1), hn::Add(s2, s3)), hn::Add(hn::Add(s4, s5), hn::Add(s6, s7)));
    hn::StoreU(s0, four, sum);
}
#endif

void triad_kernel(float *HWY_RESTRICT a, const float *HWY_RESTRICT b, const float *HWY_RESTRICT c, float s,
                  std::size_t size) {
    const hn::ScalableTag<float> wide;
    const std::size_t lanes = hn::Lanes(wide);
    const auto factor = hn::Set(wide, s);
    for (std::size_t i = 0; i < size; i += lanes)
        hn::Store(hn::MulAdd(factor, hn::Load(wide, c + i), hn::Load(wide, b + i)), wide, a + i);
}

float add_up_kernel(const float *HWY_RESTRICT a, std::size_t size) {
    const hn::ScalableTag<float> wide;
    const std::size_t lanes = hn::Lanes(wide);
    auto s0 = hn::Zero(wide), s1 = s0, s2 = s0, s3 = s0;
    const std::size_t quarter = size / 4; // one stream alone does not keep the memory busy
    for (std::size_t i = 0; i < quarter; i += lanes) {
        s0 = hn::Add(s0, hn::Load(wide, a + i));
        s1 = hn::Add(s1, hn::Load(wide, a + i + quarter));
        s2 = hn::Add(s2, hn::Load(wide, a + i + 2 * quarter));
        s3 = hn::Add(s3, hn::Load(wide, a + i + 3 * quarter));
    }
    return hn::GetLane(hn::SumOfLanes(wide, hn::Add(hn::Add(s0, s1), hn::Add(s2, s3))));
}

float multiply_add_kernel(float x, float m, float b, std::size_t length) {
    const hn::ScalableTag<float> wide;
    const auto factor = hn::Set(wide, m), addend = hn::Set(wide, b);
    // Each starts at one more than the one before, lest a compiler sees that they are alike.
    const auto one = hn::Set(wide, 1.0F);
    auto x0 = hn::Set(wide, x);
    auto x1 = hn::Add(x0, one);
    auto x2 = hn::Add(x1, one);
    auto x3 = hn::Add(x2, one);
    auto x4 = hn::Add(x3, one);
    auto x5 = hn::Add(x4, one);
    auto x6 = hn::Add(x5, one);
    auto x7 = hn::Add(x6, one);
    auto x8 = hn::Add(x7, one);
    auto x9 = hn::Add(x8, one);
    auto x10 = hn::Add(x9, one);
    auto x11 = hn::Add(x10, one);
    for (std::size_t k = 0; k < length; ++k) {
        x0 = hn::MulAdd(x0, factor, addend);
        x1 = hn::MulAdd(x1, factor, addend);
        x2 = hn::MulAdd(x2, factor, addend);
        x3 = hn::MulAdd(x3, factor, addend);
        x4 = hn::MulAdd(x4, factor, addend);
        x5 = hn::MulAdd(x5, factor, addend);
        x6 = hn::MulAdd(x6, factor, addend);
        x7 = hn::MulAdd(x7, factor, addend);
        x8 = hn::MulAdd(x8, factor, addend);
        x9 = hn::MulAdd(x9, factor, addend);
        x10 = hn::MulAdd(x10, factor, addend);
        x11 = hn::MulAdd(x11, factor, addend);
    }
    x0 = hn::Add(hn::Add(hn::Add(x0, x1), hn::Add(x2, x3)), hn::Add(hn::Add(x4, x5), hn::Add(x6, x7)));
    return hn::GetLane(hn::Add(hn::Add(x0, hn::Add(x8, x9)), hn::Add(x10, x11)));
}

std::size_t lanes_of_multiply_add() {
    return hn::Lanes(hn::ScalableTag<float>());
}

const char *name_of_target() {
    return hwy::TargetName(HWY_TARGET);
}

} // namespace livermark::benchmarks::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace livermark::benchmarks {

namespace {

HWY_EXPORT(fetch_kernel);
HWY_EXPORT(triad_kernel);
HWY_EXPORT(add_up_kernel);
HWY_EXPORT(multiply_add_kernel);
HWY_EXPORT(lanes_of_multiply_add);
HWY_EXPORT(name_of_target);

} // namespace

void fetch(const float *positions, std::span<const std::uint32_t> offsets, float *sum) {
    HWY_DYNAMIC_DISPATCH(fetch_kernel)(positions, offsets.data(), offsets.size(), sum);
}

void triad(float *a, const float *b, const float *c, float s, std::size_t size) {
    HWY_DYNAMIC_DISPATCH(triad_kernel)(a, b, c, s, size);
}

float add_up(const float *a, std::size_t size) {
    return HWY_DYNAMIC_DISPATCH(add_up_kernel)(a, size);
}

float multiply_add(float x, float m, float b, std::size_t length) {
    return HWY_DYNAMIC_DISPATCH(multiply_add_kernel)(x, m, b, length);
}

std::size_t operations_of_multiply_add() {
    return 2 * num_chains * HWY_DYNAMIC_DISPATCH(lanes_of_multiply_add)();
}

const char *instruction_set() {
    return HWY_DYNAMIC_DISPATCH(name_of_target)();
}

namespace {

/// Others may be at work on the same machine: the shortest of many is what it can do.
constexpr double seconds_of_trying = 0.2;

template <class Work> double shortest_time(const Work &work) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    double shortest = std::numeric_limits<double>::infinity();
    for (auto start = begin; std::chrono::duration<double>(start - begin).count() < seconds_of_trying;) {
        work();
        const auto end = Clock::now();
        shortest = std::min(shortest, std::chrono::duration<double>(end - start).count());
        start = end;
    }
    return shortest;
}

std::size_t cache_size(int name) {
    return static_cast<std::size_t>(std::max(0L, sysconf(name)));
}

/// Bytes per second that add_up() reads from an array of so many bytes.
double read_bandwidth(std::size_t bytes) {
    const std::size_t size = std::max<std::size_t>(1, bytes / (64 * sizeof(float))) * 64;
    const auto a = aligned_zeros(size);
    // A clock that is read around a microsecond says little.
    const std::size_t times = std::max<std::size_t>(1, 1'000'000 / size);
    volatile float sink = 0.0F;
    const double seconds = shortest_time([&] {
        for (std::size_t t = 0; t < times; ++t)
            sink = add_up(a.get(), size);
    });
    return static_cast<double>(sizeof(float) * size * times) / seconds;
}

/// Floating point operations per second of multiply_add(), measured when first asked for.
double arithmetic_throughput() {
    static const double known = [] {
        constexpr std::size_t length = 100'000;
        volatile float sink = 0.0F;
        const double seconds = shortest_time([&] { sink = multiply_add(1.0F, 0.5F, 1.0F, length); });
        return static_cast<double>(length * operations_of_multiply_add()) / seconds;
    }();
    return known;
}

} // namespace

Neighbours neighbours(std::span<const std::array<int, 2>> edges, int num_nodes) {
    const auto order = msm::reverse_cuthill_mckee(edges, num_nodes);
    std::vector<int> number(order.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        number[order[i]] = static_cast<int>(i);
    Neighbours result{.start = std::vector<int>(num_nodes + 1, 0), .neighbour = std::vector<int>(2 * edges.size())};
    for (const auto &edge : edges)
        for (const int node : edge)
            ++result.start[number[node] + 1];
    std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
    auto place = result.start;
    for (const auto &[i, j] : edges) {
        result.neighbour[place[number[i]]++] = number[j];
        result.neighbour[place[number[j]]++] = number[i];
    }
    return result;
}

AlignedFloats aligned_zeros(std::size_t size) {
    auto zeros = hwy::AllocateAligned<float>(size);
    if (!zeros)
        throw std::bad_alloc();
    std::fill_n(zeros.get(), size, 0.0F);
    return zeros;
}

FetchCase::FetchCase(const Neighbours &neighbours)
    : positions(aligned_zeros(4 * static_cast<std::size_t>(neighbours.num_nodes()))) {
    for (std::size_t i = 0; i < 4 * static_cast<std::size_t>(neighbours.num_nodes()); ++i)
        positions[i] = static_cast<float>(i / 4 % 2); // sums stay below 2^24, where a float is exact
    for (const int node : neighbours.neighbour)
        offsets.push_back(4 * static_cast<std::uint32_t>(node));
    while (offsets.size() % 8 != 0)
        offsets.push_back(0);
    for (const auto offset : offsets)
        sum += positions[offset];
}

std::vector<MemoryLevel> memory_levels() {
    const std::size_t l1 = cache_size(_SC_LEVEL1_DCACHE_SIZE), l2 = cache_size(_SC_LEVEL2_CACHE_SIZE),
                      l3 = cache_size(_SC_LEVEL3_CACHE_SIZE), last = std::max({l1, l2, l3}),
                      most = std::size_t{1} << 30;
    std::vector<MemoryLevel> levels;
    for (const auto &[name, size] : {std::pair{"L1", l1}, std::pair{"L2", l2}, std::pair{"L3", l3}})
        if (size > 0)
            levels.push_back({name, std::min(size / 2, most)});
    if (last < most / 2)
        levels.push_back({"memory", std::min(std::max(4 * last, most / 8), most)});
    return levels;
}

double SpringLimit::longest() const {
    return std::max({fetch, memory, arithmetic});
}

double streamed_bytes_per_spring(const Neighbours &neighbours) {
    constexpr double per_end = 3 * 4, per_node = 4 * 16 + 4;
    return 2 * per_end + per_node * neighbours.num_nodes() / neighbours.num_springs();
}

SpringLimit spring_limit(const Neighbours &neighbours) {
    const FetchCase at(neighbours);
    std::array<float, 4> sum{};
    const double num_springs = neighbours.num_springs();
    const double bytes = streamed_bytes_per_spring(neighbours);
    return {.fetch = shortest_time([&] { fetch(at.positions.get(), at.offsets, sum.data()); }) / num_springs,
            .memory = bytes / read_bandwidth(static_cast<std::size_t>(bytes * num_springs)),
            .arithmetic = operations_per_spring / arithmetic_throughput()};
}

} // namespace livermark::benchmarks
#endif
