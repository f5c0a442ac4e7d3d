#pragma once

#include "cli/commands/commands.hpp"

namespace livermark::cli {

/// `livermark mesh cut`.
/// @param parent        `livermark mesh`
/// @param command_line  kept in the body file
/// @return what to do, and the subcommand, which says whether it was asked for
std::pair<Command, CLI::App *> add_mesh_cut(CLI::App &parent, const std::string &command_line);

} // namespace livermark::cli
