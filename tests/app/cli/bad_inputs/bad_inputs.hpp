#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/child.hpp"

/// The table of bad inputs: what a user may get wrong.
namespace livermark::tests {

/// One row. The page docs/studies/bad_input.md has its message, to the letter.
struct BadInput {
    std::string what;                           ///< the input, for people, and for the name of its test
    std::string arguments;                      ///< of livermark, in the folder of the row
    std::map<std::string, std::string> files{}; ///< by name, in the folder
    std::function<void(const std::filesystem::path &)> prepare{}; ///< makes what is no text
    ChildOptions how{};                                           ///< without the folder
};

struct BadInputGroup {
    std::string title; ///< on the page
    std::vector<BadInput> rows;
};

std::vector<BadInput> bad_meshes();
std::vector<BadInput> bad_bodies();
std::vector<BadInput> bad_load_cases();
std::vector<BadInput> bad_releases();
std::vector<BadInput> bad_cuts();
std::vector<BadInput> bad_blades();
std::vector<BadInput> bad_histories();
std::vector<BadInput> bad_touches();
std::vector<BadInput> bad_foundations();
std::vector<BadInput> bad_hdf5_files();
std::vector<BadInput> bad_images(); ///< and surfaces; need ITK and CGAL
std::vector<BadInput> bad_solutions();
std::vector<BadInput> bad_command_lines();
std::vector<BadInput> bad_places();
std::vector<BadInputGroup> all_bad_inputs();

/// Names of the files and folders below a folder, with their sizes.
using Files = std::map<std::string, std::uintmax_t>;
Files files_below(const std::filesystem::path &folder);

/// Makes the files of a row in a folder that is empty.
/// @return what is there then
Files prepare_bad_input(const BadInput &row, const std::filesystem::path &folder);

/// Runs livermark on them.
ChildEnd try_bad_input(const BadInput &row, const std::filesystem::path &folder);

/// Lines of standard error without those that tell of progress.
std::vector<std::string> message_lines(const std::string &errors);

/// A message as docs/studies/bad_input.md has it: without the program's name and the folder, and without numbers of
/// bytes, which depend on libraries, and of models.
std::string as_documented(const std::string &line, const std::filesystem::path &folder);

/// Good inputs that the rows start from.
extern const std::string good_msh;                   ///< two tetrahedra, a triangle
extern const std::string good_body;                  ///< bar.toml
extern const std::string good_case;                  ///< case.toml: the bar is pulled
extern const std::string good_release;               ///< the same, let go
extern const std::string good_run;                   ///< arguments that read both
void write_bar(const std::filesystem::path &folder); ///< bar.toml, bar.msh, what a run left

/// A text with a part that occurs in it replaced.
/// @throws std::invalid_argument if it does not occur
std::string replaced(std::string text, const std::string &from, const std::string &to);

/// Bytes without a meaning, the same ones each time.
std::string random_bytes();

} // namespace livermark::tests
