#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <vector>

#include "app/commands.hpp"
#include "core/input_error.hpp"

namespace {

constexpr int failed = 1;
constexpr int bad_input = 2;

int run(int argc, char **argv) {
    CLI::App app{"Validation benchmark suite of soft-tissue models: a liver's mass-spring models against finite "
                 "elements"};
    app.name("livermark");
    app.set_version_flag("--version", "livermark " LIVERMARK_VERSION);
    app.require_subcommand(1);
    const std::vector<livermark::app::Command> commands{
        livermark::app::add_list(app),
        livermark::app::add_run(app, fmt::format("{}", fmt::join(argv, argv + argc, " "))),
        livermark::app::add_mesh(app),
    };
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : bad_input; // help and version are no errors
    }
    const auto subcommands = app.get_subcommands({});
    for (std::size_t c = 0; c < commands.size(); ++c)
        if (subcommands[c]->parsed())
            return commands[c]();
    return bad_input;
}

} // namespace

int main(int argc, char **argv) {
    try {
        return run(argc, argv);
    } catch (const livermark::core::InputError &error) {
        fmt::print(stderr, "livermark: {}\n", error.what());
        return bad_input;
    } catch (const std::exception &error) {
        fmt::print(stderr, "livermark: failed: {}\n", error.what());
        return failed;
    }
}
