#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

namespace livermark::cli {

/// A subcommand adds itself, with its options, to the command line and returns what to do when it was asked for.
/// That returns the exit status: 0 all done, 1 a run failed. Bad input is a support::InputError.
using Command = std::function<int()>;

Command add_list(CLI::App &parent);
Command add_table(CLI::App &parent);
Command add_view(CLI::App &parent);
/// @param command_line  kept in the result files
Command add_mesh(CLI::App &parent, const std::string &command_line);
Command add_advise(CLI::App &parent, const std::string &command_line);
Command add_arena(CLI::App &parent, const std::string &command_line);
Command add_cohort(CLI::App &parent, const std::string &command_line);
Command add_modes(CLI::App &parent, const std::string &command_line);
Command add_needle(CLI::App &parent, const std::string &command_line);
Command add_cut(CLI::App &parent, const std::string &command_line);
Command add_experiment(CLI::App &parent, const std::string &command_line);
Command add_export(CLI::App &parent, const std::string &command_line);
Command add_score(CLI::App &parent, const std::string &command_line);
Command add_reference(CLI::App &parent, const std::string &command_line);
Command add_run(CLI::App &parent, const std::string &command_line);
Command add_report(CLI::App &parent, const std::string &command_line);
Command add_sensitivity(CLI::App &parent, const std::string &command_line);
Command add_stability(CLI::App &parent, const std::string &command_line);

} // namespace livermark::cli
