#include "benchmarks/limits.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <limits>
#include <new>
#include <numeric>
#include <unistd.h>

#include "msm/kernels/layout/sliced_body.hpp"

namespace livermark::benchmarks {

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
