// Time of one evaluation of all spring forces, the work that every explicit time step repeats.
#include <benchmark/benchmark.h>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <memory>

#include "core/toml_input.hpp"
#include "meshes/body_reader.hpp"
#include "msm/spring_network.hpp"

namespace {

using livermark::core::Vector3;

struct Case {
    livermark::core::SpringNetwork springs;
    std::vector<Vector3> positions; ///< the body stretched by 1 % along x
};

std::shared_ptr<const Case> make_case(const std::string &body_name) {
    const auto body = livermark::meshes::read_body(fmt::format("{}/meshes/{}.toml", LIVERMARK_SOURCE_DIR, body_name));
    auto springs = livermark::msm::spring_network(body, livermark::msm::all_spring_laws().front());
    auto positions = body.mesh.points;
    for (auto &x : positions)
        x.x() *= 1.01;
    return std::make_shared<const Case>(Case{std::move(springs), std::move(positions)});
}

/// Forces between nodes have no resultant; that, and that they are there at all, is checked before anything is timed.
bool is_right(const std::vector<Vector3> &forces) {
    Vector3 resultant = Vector3::Zero();
    double total = 0.0;
    for (const auto &force : forces) {
        resultant += force;
        total += force.norm();
    }
    return total > 0.0 && resultant.norm() < 1e-12 * total;
}

void time_forces(benchmark::State &state, const Case &at) {
    if (!is_right(livermark::msm::elastic_gradient(at.springs, at.positions))) {
        state.SkipWithError("the forces do not balance");
        return;
    }
    for (auto _ : state)
        benchmark::DoNotOptimize(livermark::msm::elastic_gradient(at.springs, at.positions));
    const auto num_springs = static_cast<double>(at.springs.edges.size());
    state.counters["springs"] = num_springs;
    state.counters["time_per_spring"] =
        benchmark::Counter(num_springs, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

} // namespace

int main(int argc, char **argv) {
    try {
        for (const auto &body : livermark::core::list_toml(LIVERMARK_SOURCE_DIR "/meshes"))
            benchmark::RegisterBenchmark(fmt::format("force/scalar/{}", body).c_str(),
                                         [at = make_case(body)](benchmark::State &state) { time_forces(state, *at); });
    } catch (const std::exception &error) {
        fmt::print(stderr, "force_benchmark: {}\n", error.what());
        return 1;
    }
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 2;
    benchmark::RunSpecifiedBenchmarks();
    return 0;
}
