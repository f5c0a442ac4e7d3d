#include "benchmarks/program.hpp"

#include <benchmark/benchmark.h>
#include <exception>
#include <fmt/format.h>
#include <span>

#include "results/provenance.hpp"

namespace livermark::benchmarks {

namespace {

void add_context(const results::Provenance &provenance) {
    benchmark::AddCustomContext("livermark", provenance.software_version);
    benchmark::AddCustomContext("git_commit", provenance.git_commit);
    benchmark::AddCustomContext("cpu", provenance.cpu);
    benchmark::AddCustomContext("compiler", provenance.compiler);
    benchmark::AddCustomContext("build_type", provenance.build_type);
}

} // namespace

int run_program(int argc, char **argv, const std::function<void()> &register_all) {
    const std::string command = fmt::format("{}", fmt::join(std::span(argv, argc), " "));
    try {
        register_all();
        benchmark::Initialize(&argc, argv);
        if (benchmark::ReportUnrecognizedArguments(argc, argv))
            return 2;
        add_context(results::current_provenance(command));
        benchmark::RunSpecifiedBenchmarks();
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 1;
    }
    return 0;
}

} // namespace livermark::benchmarks
