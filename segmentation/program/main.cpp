// livermark-segment: what of `livermark` needs ITK and CGAL, which take longer to compile and to load than all the
// rest. `livermark` starts it and prints what it prints; nobody else needs to.
#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>
#include <exception>
#include <fmt/format.h>
#include <functional>
#include <string>
#include <sys/prctl.h>
#include <unistd.h>

#include "segmentation/program/body_command.hpp"
#include "support/input_error.hpp"
#include "support/processes/standard_error.hpp"

namespace {

using livermark::segmentation::BodyCommand;

void add_body_options(CLI::App &command, BodyCommand &body) {
    command.add_option("--tetrahedra", body.tetrahedra)->required();
    command.add_option("--mesh", body.mesh)->required();
    command.add_option("--made-of", body.made_of)->required();
    command.add_option("--command-line", body.command_line)->required();
}

/// Nobody would print what this process has to say once the one that started it is gone.
void end_with(int parent) {
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) // it went before
        std::raise(SIGTERM);
}

int run(int argc, char **argv) {
    namespace segmentation = livermark::segmentation;
    CLI::App app{"What `livermark` starts to make bodies of segmentations; see `livermark mesh --help`"};
    app.require_subcommand(1);
    BodyCommand body;
    segmentation::PhantomCommand phantom;
    std::string file;
    std::function<int()> action;

    auto *labels = app.add_subcommand("labels", "A body of a label image");
    labels->add_option("file", body.labels)->required();
    labels->add_option("--liver", body.liver)->delimiter(',');
    labels->add_option("--tumours", body.tumours)->delimiter(',');
    add_body_options(*labels, body);
    labels->callback([&] { action = [&] { return segmentation::make_body_of_labels(body); }; });

    auto *surfaces = app.add_subcommand("surfaces", "A body of closed surfaces");
    surfaces->add_option("files", body.surfaces)->required();
    surfaces->add_option("--unit", body.unit);
    add_body_options(*surfaces, body);
    surfaces->callback([&] { action = [&] { return segmentation::make_body_of_surfaces(body); }; });

    const auto add_figures = [&](const char *name, std::string (*figures)(const std::string &)) {
        auto *command = app.add_subcommand(name, "Its figures");
        command->add_option("file", file)->required();
        command->callback([&action, &file, figures] {
            action = [&file, figures] {
                fmt::print("{}", figures(file));
                return 0;
            };
        });
    };
    add_figures("figures-of-labels", segmentation::figures_of_labels);
    add_figures("figures-of-surface", segmentation::figures_of_surface);

    auto *shipped = app.add_subcommand("phantom", "A label image of the liver that ships");
    shipped->add_option("--spacing", phantom.spacing)->expected(3)->required();
    shipped->add_option("--turn", phantom.turn)->expected(3)->required();
    shipped->add_flag("--touching", phantom.touching);
    shipped->add_option("--scan", phantom.scan);
    shipped->add_option("--output", phantom.output)->required();
    shipped->callback([&] { action = [&] { return segmentation::make_phantom(phantom); }; });

    app.add_option_function<int>("--parent", end_with, "Process that this one ends with");
    CLI11_PARSE(app, argc, argv);
    return action();
}

} // namespace

/// Exit status 2 is that of a refusal, 3 that of a failure; the sentence is all of the standard output then.
int main(int argc, char **argv) {
    std::signal(SIGXFSZ, SIG_IGN); // writing fails as on a full disk
    const livermark::support::UnfailingStandardError standard_error;
    try {
        return run(argc, argv);
    } catch (const livermark::support::InputError &error) {
        fmt::print("{}", error.what());
        return 2;
    } catch (const std::exception &error) {
        fmt::print("{}", error.what());
        return 3;
    }
}
