#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace livermark::cli {

/// CLI11 gives all words behind an option that takes several to that option: in `run --model lloyd liver.msh` also the
/// folder, which belongs to the command. Puts such words where they belong, behind the name of the command: those
/// behind the first word of a list, or behind as many as it takes at most, that mean the list of bodies or paths of the
/// command. Options whose values are bodies or paths themselves keep them.
/// @param words     of the command line, without the name of the program
/// @param is_place  whether a text is a body or a path, and no value of any option; numbers are not asked about
std::vector<std::string> with_places_first(const CLI::App &app, std::vector<std::string> words,
                                           const std::function<bool(const std::string &)> &is_place);

/// Whether a word is the name of a body that ships or a path of something that is there, and no name of a model or an
/// integrator.
bool is_body_or_path(const std::string &word);

} // namespace livermark::cli
