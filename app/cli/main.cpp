#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fmt/format.h>
#include <functional>
#include <iostream>
#include <iterator>
#include <optional>
#include <ostream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "app/cli/commands.hpp"
#include "core/support/files.hpp"
#include "core/support/input_error.hpp"
#include "core/support/processes/child_process.hpp"
#include "core/support/processes/mpi_session.hpp"
#include "core/support/processes/own_process.hpp"
#include "msm/integrator.hpp"
#include "studies/models/model_table.hpp"
#include "studies/study.hpp"

namespace livermark::cli {

namespace {

bool is_number(const std::string &word) {
    double value = 0.0;
    return CLI::detail::lexical_cast(word, value);
}

bool has_list_of_places(const CLI::App &command) {
    const auto is_list = [](const CLI::Option *option) {
        return option->get_positional() && option->get_items_expected_max() > 1;
    };
    return !command.get_options(is_list).empty();
}

const CLI::App *command_below(const CLI::App &command, const std::string &name) {
    const auto all = command.get_subcommands({});
    const auto found = std::ranges::find(all, name, [](const CLI::App *each) { return each->get_name(); });
    return found == all.end() ? nullptr : *found;
}

/// The option that a word names; none for words without a minus, and for unknown options.
const CLI::Option *option_of(const CLI::App &command, const std::string &word) {
    return word.size() > 1 && word.starts_with('-') ? command.get_option_no_throw(word.substr(0, word.find('=')))
                                                    : nullptr;
}

/// Whether the values of an option are bodies or paths themselves.
bool takes_places(const CLI::Option &option) {
    return std::ranges::any_of(std::array{"--body", "--load-case", "--surfaces"},
                               [&](const char *name) { return option.check_name(name); });
}

/// CLI11 gives all words behind an option that takes several to that option: in `run --model lloyd liver.msh` also the
/// folder, which belongs to the command. Puts such words where they belong, behind the name of the command: those
/// behind the first word of a list, or behind as many as it takes at most, that mean the list of bodies or paths of the
/// command. Options whose values are bodies or paths themselves keep them.
/// @param words     of the command line, without the name of the program
/// @param is_place  whether a text is a body or a path, and no value of any option; numbers are not asked about
std::vector<std::string> with_places_first(const CLI::App &app, std::vector<std::string> words,
                                           const std::function<bool(const std::string &)> &is_place) {
    const CLI::App *command = &app;
    std::size_t first = 0;
    while (const auto *below = first < words.size() ? command_below(*command, words[first]) : nullptr) {
        command = below;
        ++first;
    }
    if (!has_list_of_places(*command))
        return words;
    std::vector<std::string> places, others;
    const CLI::Option *list = nullptr; // of which values come
    int num_values = 0;
    for (auto at = words.begin() + static_cast<std::ptrdiff_t>(first); at != words.end(); ++at) {
        if (*at == "--") { // from here on there are no options
            others.insert(others.end(), at, words.end());
            break;
        }
        if (at->size() > 1 && at->starts_with('-') && !is_number(*at)) {
            const auto *const option = option_of(*command, *at);
            list = option && option->get_items_expected_max() > 1 ? option : nullptr;
            num_values = at->find('=') == std::string::npos ? 0 : 1;
            others.push_back(*at);
        } else if (list && num_values > 0 &&
                   (num_values >= list->get_items_expected_max() ||
                    (!takes_places(*list) && !is_number(*at) && is_place(*at)))) {
            places.push_back(*at);
        } else {
            ++num_values;
            others.push_back(*at);
        }
    }
    words.resize(first);
    std::ranges::copy(places, std::back_inserter(words));
    std::ranges::copy(others, std::back_inserter(words));
    return words;
}

/// Whether a word is the name of a body that ships or a path of something that is there, and no name of a model or an
/// integrator.
bool is_body_or_path(const std::string &word) {
    namespace fs = std::filesystem;
    const auto names = [&](const auto &table) {
        return std::ranges::any_of(table, [&](const auto &entry) { return entry.name == word; });
    };
    if (names(models::all_models()) || names(msm::known_integrators()))
        return false;
    std::error_code ignored;
    return fs::exists(word, ignored) ||
           (word.find('/') == std::string::npos &&
            fs::exists(support::root_folder() / studies::bodies_folder / (word + ".toml"), ignored));
}

} // namespace

} // namespace livermark::cli

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
        livermark::cli::add_springs(app, command_line),
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

/// A message without what breaks its line: files and words from outside may hold that.
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
