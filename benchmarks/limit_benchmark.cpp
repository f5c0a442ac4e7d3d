// Limits of this machine on one core: fetching the neighbours of nodes, streaming, calculating; see README.md.
#include <benchmark/benchmark.h>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "benchmarks/harness.hpp"
#include "benchmarks/limits.hpp"

namespace {

namespace benchmarks = livermark::benchmarks;
using benchmark::Counter;

void time_fetch(benchmark::State &state, const std::string &body_name) {
    const auto body = benchmarks::make_body(body_name);
    const auto edges = livermark::core::edge_table(body->mesh.tetrahedra).edges;
    const auto neighbours = benchmarks::neighbours(edges, body->mesh.num_nodes());
    const benchmarks::FetchCase at(neighbours);
    std::array<float, 4> sum{};
    benchmarks::fetch(at.positions.get(), at.offsets, sum.data());
    if (sum[0] != at.sum) {
        state.SkipWithError("the sum of the positions is wrong");
        return;
    }
    for (auto _ : state) {
        benchmarks::fetch(at.positions.get(), at.offsets, sum.data());
        benchmark::DoNotOptimize(sum);
    }
    state.counters["springs"] = neighbours.num_springs();
    state.counters["time_per_spring"] =
        Counter(neighbours.num_springs(), Counter::kIsIterationInvariantRate | Counter::kInvert);
}

void time_triad(benchmark::State &state, std::size_t bytes) {
    const std::size_t size = bytes / (3 * 64 * sizeof(float)) * 64;
    const auto a = benchmarks::aligned_zeros(size), b = benchmarks::aligned_zeros(size),
               c = benchmarks::aligned_zeros(size);
    for (std::size_t i = 0; i < size; ++i) {
        b[i] = static_cast<float>(i % 1000);
        c[i] = 2.0F;
    }
    benchmarks::triad(a.get(), b.get(), c.get(), 0.5F, size);
    for (std::size_t i = 0; i < size; ++i)
        if (a[i] != static_cast<float>(i % 1000 + 1)) {
            state.SkipWithError("the triad is wrong");
            return;
        }
    for (auto _ : state) {
        benchmarks::triad(a.get(), b.get(), c.get(), 0.5F, size);
        benchmark::ClobberMemory();
    }
    state.counters["bytes"] = static_cast<double>(bytes);
    state.SetBytesProcessed(static_cast<std::int64_t>(3 * sizeof(float) * size) * state.iterations());
}

void time_read(benchmark::State &state, std::size_t bytes) {
    const std::size_t size = bytes / (64 * sizeof(float)) * 64;
    const auto a = benchmarks::aligned_zeros(size);
    for (std::size_t i = 0; i < size; i += 64)
        a[i] = 1.0F;
    if (const std::size_t sum = size / 64; benchmarks::add_up(a.get(), size) != static_cast<float>(sum)) {
        state.SkipWithError("the sum is wrong");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(benchmarks::add_up(a.get(), size));
    state.counters["bytes"] = static_cast<double>(bytes);
    state.SetBytesProcessed(static_cast<std::int64_t>(sizeof(float) * size) * state.iterations());
}

void time_arithmetic(benchmark::State &state) {
    constexpr std::size_t length = 100'000;
    // Each chain ends where y = y / 2 + 1.
    if (const float sum = benchmarks::multiply_add(1.0F, 0.5F, 1.0F, length);
        sum != 2.0F * static_cast<float>(benchmarks::num_chains)) {
        state.SkipWithError("the chains do not end where they should");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(benchmarks::multiply_add(1.0F, 0.5F, 1.0F, length));
    state.counters["flop_per_second"] = Counter(static_cast<double>(length * benchmarks::operations_of_multiply_add()),
                                                Counter::kIsIterationInvariantRate);
    state.SetLabel(benchmarks::instruction_set());
}

} // namespace

int main(int argc, char **argv) {
    return benchmarks::run_program(argc, argv, [] {
        for (const auto &body : benchmarks::body_names())
            benchmark::RegisterBenchmark(fmt::format("limit/fetch/{}", body).c_str(), [body](benchmark::State &state) {
                time_fetch(state, body);
            })->Unit(benchmark::kMicrosecond);
        for (const auto &[name, bytes] : benchmarks::memory_levels()) {
            benchmark::RegisterBenchmark(fmt::format("limit/read/{}", name).c_str(),
                                         [bytes = bytes](benchmark::State &state) { time_read(state, bytes); });
            benchmark::RegisterBenchmark(fmt::format("limit/triad/{}", name).c_str(),
                                         [bytes = bytes](benchmark::State &state) { time_triad(state, bytes); });
        }
        benchmark::RegisterBenchmark("limit/arithmetic", time_arithmetic)->Unit(benchmark::kMicrosecond);
    });
}
