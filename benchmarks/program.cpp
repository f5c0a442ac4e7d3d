#include "benchmarks/program.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <unistd.h>

#include "core/input_error.hpp"
#include "results/provenance.hpp"
#include "results/timings_file.hpp"

namespace livermark::benchmarks {

namespace {

/// Prints what Google Benchmark prints, and keeps it.
class Collector : public benchmark::ConsoleReporter {
  public:
    Collector() : ConsoleReporter(isatty(STDOUT_FILENO) == 1 ? OO_Defaults : OO_None) {}

    void ReportRuns(const std::vector<Run> &runs) override {
        ConsoleReporter::ReportRuns(runs);
        for (const auto &run : runs)
            if (run.error_occurred)
                has_failed = true;
            else if (run.run_type == Run::RT_Iteration)
                keep(run);
    }

    /// The medians of the repetitions.
    std::vector<results::Timing> timings() const {
        auto timings = timings_;
        for (auto &timing : timings)
            for (const auto &[name, values] : counters_.at(timing.name))
                timing.counters[name] = results::median(values);
        return timings;
    }

    bool has_failed = false;

  private:
    void keep(const Run &run) {
        const auto &name = run.run_name.function_name;
        if (timings_.empty() || timings_.back().name != name)
            timings_.push_back({.name = name, .seconds = {}, .counters = {}});
        auto &timing = timings_.back();
        timing.is_wall_clock = !run.run_name.time_type.empty();
        timing.iterations = run.iterations;
        timing.seconds.push_back((timing.is_wall_clock ? run.real_accumulated_time : run.cpu_accumulated_time) /
                                 static_cast<double>(run.iterations));
        for (const auto &[counter, value] : run.counters)
            counters_[name][counter].push_back(value.value);
        counters_.try_emplace(name);
    }

    std::vector<results::Timing> timings_;
    std::map<std::string, std::map<std::string, std::vector<double>>> counters_;
};

/// Takes --hdf5=FILE out of the arguments, which Google Benchmark does not know.
std::optional<std::filesystem::path> take_hdf5(int &argc, char **argv) {
    constexpr std::string_view option = "--hdf5=";
    for (int i = 1; i < argc; ++i)
        if (const std::string_view argument = argv[i]; argument.starts_with(option)) {
            const auto path = std::filesystem::absolute(argument.substr(option.size()));
            if (path.filename().empty() || !std::filesystem::is_directory(path.parent_path()))
                throw core::InputError(fmt::format("{}: name a file in a folder that exists", argument));
            std::copy(argv + i + 1, argv + argc, argv + i);
            --argc;
            return path;
        }
    return std::nullopt;
}

void add_context(const results::Provenance &provenance) {
    benchmark::AddCustomContext("livermark", provenance.software_version);
    benchmark::AddCustomContext("git_commit", provenance.git_commit);
    benchmark::AddCustomContext("cpu", provenance.cpu);
    benchmark::AddCustomContext("compiler", provenance.compiler);
    benchmark::AddCustomContext("build_type", provenance.build_type);
}

void print_help() {
    benchmark::PrintDefaultHelp();
    fmt::print("          [--hdf5=<file>]\n");
}

int run(int argc, char **argv, const std::function<void()> &register_all) {
    const auto provenance = results::current_provenance(fmt::format("{}", fmt::join(std::span(argv, argc), " ")));
    const auto hdf5 = take_hdf5(argc, argv);
    for (const char *argument : std::span(argv, argc))
        if (std::string_view(argument).starts_with("--benchmark_format"))
            throw core::InputError("--benchmark_format is not known here; take --benchmark_out=<file>");
    register_all();
    benchmark::Initialize(&argc, argv, print_help);
    if (benchmark::ReportUnrecognizedArguments(argc, argv))
        return 2;
    add_context(provenance);
    Collector collector;
    if (benchmark::RunSpecifiedBenchmarks(&collector) == 0)
        throw core::InputError("no benchmark matches; --benchmark_list_tests names all");
    if (hdf5)
        results::write_timings(*hdf5, {.provenance = provenance, .timings = collector.timings()});
    return collector.has_failed ? 1 : 0;
}

} // namespace

int run_program(int argc, char **argv, const std::function<void()> &register_all) {
    try {
        return run(argc, argv, register_all);
    } catch (const core::InputError &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 1;
    }
}

} // namespace livermark::benchmarks
