#include <algorithm>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <iostream>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "app/catalogue.hpp"
#include "app/commands.hpp"
#include "core/input_error.hpp"
#include "fem_reference/mpi_session.hpp"

namespace {

/// CLI11 would only say that a subcommand is missing.
void refuse_unknown_subcommand(const CLI::App &app, const std::string &word) {
    std::vector<std::string> known;
    for (const auto *subcommand : app.get_subcommands({}))
        known.push_back(subcommand->get_name());
    if (!word.starts_with('-') && std::ranges::find(known, word) == known.end())
        throw livermark::core::InputError(livermark::app::unknown_name("subcommand", word, known));
}

constexpr int failed = 1;
constexpr int bad_input = 2;

int run(int argc, char **argv) {
    CLI::App app{"Validation benchmark suite of soft-tissue models: a liver's mass-spring models against finite "
                 "elements"};
    app.name("livermark");
    app.set_version_flag("--version", "livermark " LIVERMARK_VERSION);
    app.require_subcommand(1);
    const auto command_line = fmt::format("{}", fmt::join(argv, argv + argc, " "));
    const std::vector<livermark::app::Command> commands{
        livermark::app::add_list(app),
        livermark::app::add_modes(app, command_line),
        livermark::app::add_run(app, command_line),
        livermark::app::add_mesh(app),
        livermark::app::add_histories(app, command_line),
        livermark::app::add_stability(app, command_line),
        livermark::app::add_parameters(app),
        livermark::app::add_table(app),
        livermark::app::add_export(app, command_line),
        livermark::app::add_score(app, command_line),
        livermark::app::add_calibrate(app, command_line),
    };
    if (argc > 1)
        refuse_unknown_subcommand(app, argv[1]);
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        std::ostream nowhere(nullptr);
        const bool speaks = livermark::fem_reference::mpi_rank() == 0;
        const int status = app.exit(error, speaks ? std::cout : nowhere, speaks ? std::cerr : nowhere);
        return status == 0 ? 0 : bad_input; // help and version are no errors
    }
    const auto subcommands = app.get_subcommands({});
    if (livermark::fem_reference::mpi_rank() != 0 && !app.got_subcommand("run"))
        return 0; // there is nothing to share out
    for (std::size_t c = 0; c < commands.size(); ++c)
        if (subcommands[c]->parsed())
            return commands[c]();
    return bad_input;
}

} // namespace

int main(int argc, char **argv) {
    using namespace livermark::fem_reference;
    // Outlives every exception: all ranks have to end MPI together.
    std::optional<MpiSession> session;
    if (started_on_many_ranks())
        session.emplace();
    try {
        return run(argc, argv);
    } catch (const livermark::core::InputError &error) {
        if (mpi_rank() == 0)
            fmt::print(stderr, "livermark: {}\n", error.what());
        return bad_input;
    } catch (const std::exception &error) {
        if (mpi_num_ranks() > 1)
            abort_all_ranks(error.what());
        fmt::print(stderr, "livermark: failed: {}\n", error.what());
        return failed;
    }
}
