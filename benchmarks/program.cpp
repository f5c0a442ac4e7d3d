#include "benchmarks/program.hpp"

#include <algorithm>
#include <benchmark/benchmark.h>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "core/support/input_error.hpp"
#include "results/quantile.hpp"
#include "results/records/result.hpp"
#include "results/records/timings.hpp"

namespace livermark::benchmarks {

namespace {

/// Lets the reporter of --benchmark_format print, and keeps what it is told.
class Collector : public benchmark::BenchmarkReporter {
  public:
    Collector() : printer_(benchmark::CreateDefaultDisplayReporter()) {}

    bool ReportContext(const Context &context) override { return printer_->ReportContext(context); }

    void ReportRuns(const std::vector<Run> &runs) override {
        printer_->ReportRuns(runs);
        for (const auto &run : runs)
            if (run.error_occurred)
                has_failed = true;
            else if (run.run_type == Run::RT_Iteration)
                keep(run);
    }

    void Finalize() override { printer_->Finalize(); }

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

    std::unique_ptr<benchmark::BenchmarkReporter> printer_;
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
                throw support::InputError(fmt::format("{}: name a file in a folder that exists", argument));
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

/// Google Benchmark asks for the help, and ends with 0, where one of its flags has none of the values to choose from.
void refuse_value() {
    throw support::InputError(
        "--benchmark_format, --benchmark_out_format, --benchmark_color or --benchmark_time_unit has a "
        "value that it does not take; --help names those that it does");
}

/// Takes the flags of Google Benchmark out of the arguments.
void initialize(int argc, char **argv) {
    const auto arguments = std::span(argv, argc).subspan(1);
    const bool is_help = std::ranges::find(arguments, std::string_view("--help")) != arguments.end();
    benchmark::Initialize(&argc, argv, is_help ? print_help : refuse_value);
    if (argc > 1)
        throw support::InputError(
            fmt::format("'{}' is no flag, or has a value that it does not take; --help names all flags", argv[1]));
}

int run(int argc, char **argv, const std::function<void()> &register_all) {
    const auto provenance = results::current_provenance(fmt::format("{}", fmt::join(std::span(argv, argc), " ")));
    const auto hdf5 = take_hdf5(argc, argv);
    register_all();
    initialize(argc, argv);
    add_context(provenance);
    Collector collector;
    if (benchmark::RunSpecifiedBenchmarks(&collector) == 0)
        throw support::InputError("no benchmark matches; --benchmark_list_tests names all");
    const auto timings = collector.timings();
    if (hdf5 && timings.empty() && !collector.has_failed)
        throw support::InputError("--hdf5 keeps single times, and there are none; leave --benchmark_list_tests, "
                                  "--benchmark_report_aggregates_only and --benchmark_display_aggregates_only out");
    if (hdf5)
        results::write_timings(*hdf5, {.provenance = provenance, .timings = timings});
    return collector.has_failed ? 1 : 0;
}

} // namespace

int run_program(int argc, char **argv, const std::function<void()> &register_all) {
    try {
        return run(argc, argv, register_all);
    } catch (const support::InputError &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print(stderr, "{}: {}\n", argv[0], error.what());
        return 1;
    }
}

} // namespace livermark::benchmarks
