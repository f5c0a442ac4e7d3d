#include "studies/cohort/cohort.hpp"

#include <algorithm>
#include <charconv>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/processes/own_process.hpp"
#include "core/support/toml_input.hpp"
#include "meshes/generators/liver_generator.hpp"
#include "meshes/generators/liver_shape.hpp"
#include "results/one_reference.hpp"
#include "results/records/cohort.hpp"
#include "results/records/result.hpp"
#include "studies/run/run.hpp"
#include "studies/study.hpp"

namespace livermark::studies {

namespace {

namespace fs = std::filesystem;

constexpr int largest_number = 1000000;
constexpr std::size_t most_bodies = 1000;

[[noreturn]] void refuse_numbers(const std::string &text, const std::string &fault) {
    throw support::InputError(
        fmt::format("--bodies '{}': {}; give numbers from 1 to {} and ranges, {} at most, such as 1-8,12",
                    support::shown(text), fault, largest_number, most_bodies));
}

int number_of(std::string_view word, const std::string &text) {
    int number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc{} || end != word.data() + word.size() || number < 1 || number > largest_number)
        refuse_numbers(text, fmt::format("'{}' is not a number of a body", support::shown(word)));
    return number;
}

std::string body_name(int number) {
    return fmt::format("liver_variant_{}", number);
}

/// The command that makes the body, in the folder where it stands.
std::string generator_of(int number, int tetrahedra) {
    return fmt::format("livermark mesh liver --variant {}{} -o {}.msh", number,
                       tetrahedra > 0 ? fmt::format(" --tetrahedra {}", tetrahedra) : "", body_name(number));
}

/// The command in a body file; empty where there is none.
std::string generator_in(const std::filesystem::path &file) {
    try {
        return support::parse_toml(support::read_text(file), file)["generator"].value_or(std::string());
    } catch (const support::InputError &) {
        return {};
    }
}

/// The drawn numbers of a body, as a cohort file has them.
results::CohortBody drawn_body(const meshes::LiverVariant &variant) {
    results::CohortBody body{.number = variant.number,
                             .name = body_name(variant.number),
                             .volume = variant.volume,
                             .body_surface = variant.body_surface,
                             .left_part = variant.left_part,
                             .front_to_back = variant.front_to_back,
                             .has_riedel_lobe = variant.has_riedel_lobe,
                             .lesions = {}};
    for (const auto &lesion : variant.lesions)
        body.lesions.push_back({lesion.center, lesion.semi_axes});
    return body;
}

fs::path bodies_in(const CohortOptions &options) {
    return fs::path(options.run.output) / "bodies";
}

RunOptions options_of_cohort(const CohortOptions &options) {
    auto run = options.run;
    run.only_static = true;
    run.resume = true;
    run.may_leave_out = true;
    for (auto &load_case : run.load_cases) // files keep their place wherever the command is typed again
        if (std::error_code error; fs::is_regular_file(load_case, error))
            load_case = fs::absolute(load_case).lexically_normal().string();
    return run;
}

/// The command that makes the results of one body again, typed in the output folder. It is the same for every number of
/// workers and every choice of the other bodies, so these do not decide whether a result is kept.
std::string command_of_body(const RunOptions &options, const std::string &body_file) {
    auto command = fmt::format("livermark run --static --body {}", body_file);
    if (!options.load_cases.empty())
        command += fmt::format(" --load-case {}", fmt::join(options.load_cases, " "));
    else
        command +=
            fmt::format(" --regime {}", options.regimes.size() > 1 ? "all" : core::to_string(options.regimes.front()));
    if (!options.models.empty())
        command += fmt::format(" --model {}", fmt::join(options.models, " "));
    for (const auto &[constant, values] : options.model_options.sweeps)
        command += fmt::format(" --sweep {}={}", constant, fmt::join(values, ","));
    if (!options.poisson_ratios.empty())
        command += fmt::format(" --poisson {}", fmt::join(options.poisson_ratios, ","));
    return command + (options.reference_on_mesh ? " --reference-on-mesh" : "") + " --output .";
}

/// Statistics and the interpreter that makes them.
/// @param arguments  of python/livermark/studies/cohort.py
void run_statistics(const std::vector<std::string> &arguments) {
    support::run_python("studies.cohort", arguments, {}, "statistics of a cohort", "python3-numpy python3-h5py");
}

/// Everything that a user may have got wrong: on the livers that ship, which have the places of all others.
void check_all(const CohortOptions &options, RunOptions run) {
    if (support::mpi_num_ranks() > 1)
        throw support::InputError("`livermark cohort` works on one rank only; start it without mpirun");
    run_statistics({"ready"});
    run.bodies = {"liver_healthy", "liver_tumours"};
    read_run(run);
    for (const int number : options.bodies)
        check_cohort_body(cohort_body_file(bodies_in(options), number), number, options.tetrahedra);
}

void make_folders(const CohortOptions &options) {
    std::error_code error;
    fs::create_directories(bodies_in(options), error);
    if (error)
        throw support::InputError(fmt::format("{}: cannot be made ({}); choose another --output",
                                              bodies_in(options).string(), error.message()));
}

/// Makes and reads one body with its load cases.
Run run_of_body(const meshes::LiverVariant &variant, const fs::path &file, const CohortOptions &options,
                const RunOptions &run) {
    std::error_code error;
    const bool was_there = fs::exists(file, error);
    make_cohort_body(file, variant, options.tetrahedra);
    try {
        return prepare(run);
    } catch (const support::InputError &fault) {
        if (!was_there)
            throw;
        throw support::InputError(
            fmt::format("{}; or remove {}, and the same command makes the body again", fault.what(), file.string()));
    }
}

/// Keeps what a cohort file has of results, which are much larger.
void add_outcome(RunOutcome &&outcome, const std::string &body, CohortOutcome &all) {
    for (const auto &result : outcome.done) {
        std::ranges::move(results::result_remarks({&result, 1}), std::back_inserter(all.notes));
        std::ranges::move(results::cohort_errors({&result, 1}), std::back_inserter(all.cohort.errors));
    }
    std::ranges::move(outcome.failures, std::back_inserter(all.cohort.failures));
    if (outcome.num_kept > 0)
        all.kept.push_back({body, outcome.num_kept, static_cast<int>(outcome.done.size())});
    std::ranges::move(outcome.notes, std::back_inserter(all.notes));
    all.spent.add(outcome.spent);
}

void run_body(int number, const CohortOptions &options, RunOptions run, const ProgressReport &report,
              CohortOutcome &all) {
    const auto variant = meshes::draw_liver(number);
    const auto &body = all.cohort.bodies.emplace_back(drawn_body(variant));
    const auto place = fmt::format("body {} of {}", all.cohort.bodies.size(), options.bodies.size());
    std::optional<Run> task;
    all.spent.begin("bodies and load cases");
    try {
        const auto file = cohort_body_file(bodies_in(options), number);
        run.bodies = {file.string()};
        if (report)
            report(static_cast<int>(all.cohort.bodies.size()), static_cast<int>(options.bodies.size()),
                   fmt::format("{}: body and load cases", body.name));
        task = run_of_body(variant, file, options, run);
    } catch (const std::exception &error) {
        all.cohort.failures.push_back(fmt::format("{}: {}", body.name, support::reason_of(error)));
    }
    all.spent.stop();
    if (!task)
        return;
    std::ranges::move(task->notes, std::back_inserter(all.notes));
    const auto report_on_body = [&](int step, int num_steps, const std::string &about) {
        if (report)
            report(step, num_steps, fmt::format("{}: {}", place, about));
    };
    const auto body_file = fmt::format("bodies/{}.toml", body.name);
    try {
        add_outcome(run_cases(*task, command_of_body(run, body_file), report_on_body), body.name, all);
    } catch (const support::InputError &) {
        throw; // results have no place any more
    } catch (const std::exception &error) {
        all.cohort.failures.push_back(fmt::format("{}: {}", body.name, support::reason_of(error)));
    }
}

} // namespace

std::filesystem::path cohort_body_file(const std::filesystem::path &folder, int number) {
    return folder / (body_name(number) + ".toml");
}

void check_cohort_body(const std::filesystem::path &file, int number, int tetrahedra) {
    std::error_code error;
    if (!std::filesystem::exists(file, error))
        return;
    if (const auto generator = generator_in(file); !generator.empty() && generator != generator_of(number, tetrahedra))
        throw support::InputError(
            fmt::format("{}: this body was made by another command than `{}`; give the --tetrahedra that it was made "
                        "with, or another --output",
                        file.string(), generator_of(number, tetrahedra)));
}

void make_cohort_body(const std::filesystem::path &file, const meshes::LiverVariant &variant, int tetrahedra) {
    // The body file is written after the mesh, so where it is the mesh was whole.
    if (std::error_code error; std::filesystem::exists(file, error))
        return;
    auto mesh_file = file;
    meshes::write_liver_body(mesh_file.replace_extension(".msh"), meshes::generate_liver(variant, tetrahedra), variant,
                             generator_of(variant.number, tetrahedra));
}

std::vector<int> body_numbers(const std::string &text) {
    std::vector<int> numbers;
    for (std::size_t start = 0; start <= text.size();) {
        const auto end = std::min(text.find(',', start), text.size());
        const auto part = std::string_view(text).substr(start, end - start);
        const auto dash = part.find('-');
        const int first = number_of(part.substr(0, dash), text);
        const int last = dash == std::string_view::npos ? first : number_of(part.substr(dash + 1), text);
        if (last < first)
            refuse_numbers(text, fmt::format("the range {} ends before it begins", part));
        if (numbers.size() + static_cast<std::size_t>(last - first) >= most_bodies)
            refuse_numbers(text, fmt::format("these are more than {} bodies", most_bodies));
        for (int number = first; number <= last; ++number)
            numbers.push_back(number);
        start = end + 1;
    }
    std::ranges::sort(numbers);
    if (const auto twice = std::ranges::adjacent_find(numbers); twice != numbers.end())
        refuse_numbers(text, fmt::format("{} is given twice", *twice));
    return numbers;
}

CohortOutcome run_cohort(const CohortOptions &options, const std::string &command_line, const ProgressReport &report) {
    const auto run = options_of_cohort(options);
    check_all(options, run);
    const OutputFile file(options.run.output, "cohort.h5");
    make_folders(options);
    CohortOutcome all;
    all.cohort.tetrahedra = options.tetrahedra;
    for (const int number : options.bodies)
        run_body(number, options, run, report, all);
    all.cohort.provenance = results::current_provenance(command_line);
    results::write_cohort(file.path(), all.cohort);
    run_statistics({"finish", file.path().string()});
    all.is_well =
        all.cohort.failures.empty() && std::ranges::all_of(all.cohort.errors, [](const results::CohortError &error) {
            return error.status == core::SolutionStatus::ok || may_fail(error.model, error.regime);
        });
    return all;
}

} // namespace livermark::studies
