#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fmt/format.h>
#include <iostream>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "cli/commands/commands.hpp"
#include "cli/usage.hpp"
#include "cli/word_order.hpp"
#include "support/input_error.hpp"
#include "support/processes/memory.hpp"
#include "support/processes/mpi_session.hpp"
#include "support/processes/standard_error.hpp"

namespace {

constexpr int failed = 1;
constexpr int bad_input = 2;

/// `help` and `help run` are `--help` and `run --help`.
std::vector<std::string> without_help_command(std::vector<std::string> words) {
    if (!words.empty() && words.front() == "help") {
        words.erase(words.begin());
        words.emplace_back("--help");
    }
    return words;
}

int run(int argc, char **argv) {
    CLI::App app{
        "Validation benchmark suite for models of soft tissue: mass-spring models of livers against finite elements"};
    app.name("livermark");
    livermark::cli::describe_arguments_once(app);
    app.set_version_flag("--version", "livermark " LIVERMARK_VERSION);
    app.require_subcommand(1);
    app.footer("`livermark help COMMAND` is `livermark COMMAND --help`.\nEnvironment: LIVERMARK_ROOT is the folder "
               "with the meshes/, load_cases/ and results/ that ship; by default the source tree around the program, "
               "or else the one it was built from.");
    const auto command_line = fmt::format("{}", fmt::join(argv, argv + argc, " "));
    const auto words = without_help_command({argv + 1, argv + argc});
    const std::vector<livermark::cli::Command> commands{
        livermark::cli::add_list(app),
        livermark::cli::add_advise(app, command_line),
        livermark::cli::add_modes(app, command_line),
        livermark::cli::add_needle(app, command_line),
        livermark::cli::add_cut(app, command_line),
        livermark::cli::add_run(app, command_line),
        livermark::cli::add_arena(app, command_line),
        livermark::cli::add_experiment(app, command_line),
        livermark::cli::add_sensitivity(app, command_line),
        livermark::cli::add_cohort(app, command_line),
        livermark::cli::add_reference(app, command_line),
        livermark::cli::add_mesh(app, command_line),
        livermark::cli::add_stability(app, command_line),
        livermark::cli::add_table(app),
        livermark::cli::add_report(app, command_line),
        livermark::cli::add_view(app),
        livermark::cli::add_export(app, command_line),
        livermark::cli::add_score(app, command_line),
    };
    livermark::cli::refuse_empty_places(app);
    livermark::cli::refuse_unknown_subcommand(app, words);
    auto in_order = livermark::cli::with_places_first(app, words, livermark::cli::is_body_or_path);
    std::ranges::reverse(in_order); // which CLI11 takes from the back
    try {
        app.parse(std::move(in_order));
    } catch (const CLI::Success &help_or_version) {
        std::ostream nowhere(nullptr);
        return app.exit(help_or_version, livermark::support::mpi_rank() == 0 ? std::cout : nowhere);
    } catch (const CLI::ParseError &error) {
        throw livermark::support::InputError(livermark::cli::usage_sentence(app, error));
    }
    const auto subcommands = app.get_subcommands({});
    if (livermark::support::mpi_rank() != 0 && !app.got_subcommand("run"))
        return 0; // there is nothing to share out
    for (std::size_t c = 0; c < commands.size(); ++c)
        if (subcommands[c]->parsed())
            return commands[c]();
    return bad_input;
}

/// What files and words from outside hold may break the line of a message.
std::string one_line(std::string message) {
    std::ranges::replace_if(
        message, [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; }, ' ');
    return message;
}

int refuse(const std::string &message) {
    if (livermark::support::mpi_rank() == 0)
        fmt::print(stderr, "livermark: {}\n", one_line(message));
    return bad_input;
}

int refuse_output(const char *reason) {
    return refuse(
        fmt::format("standard output: cannot be written ({}); make room on the disk, or redirect it", reason));
}

} // namespace

int main(int argc, char **argv) {
    using namespace livermark::support;
    // Beyond a limit on the size of files, writing fails as on a full disk, with a message.
    std::signal(SIGXFSZ, SIG_IGN);
    const UnfailingStandardError standard_error;
    // Outlives every exception: all ranks have to end MPI together.
    std::optional<MpiSession> session;
    try {
        if (started_on_many_ranks())
            session.emplace();
        const int status = run(argc, argv);
        // Text stays in a buffer until the end, and nobody else would notice that it went nowhere.
        return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 ? status : refuse_output(std::strerror(errno));
    } catch (const livermark::support::InputError &error) {
        return refuse(error.what());
    } catch (const std::exception &error) {
        if (std::ferror(stdout) != 0)
            return refuse_output(error.what());
        if (mpi_num_ranks() > 1)
            abort_all_ranks(error.what());
        fmt::print(stderr, "livermark: failed: {}\n", reason_of(error));
        return failed;
    }
}
