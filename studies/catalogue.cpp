#include "studies/catalogue.hpp"

#include <algorithm>
#include <cstddef>
#include <fmt/format.h>

#include "support/file_ending.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"
#include "support/root_folder.hpp"
#include "support/toml_input.hpp"

namespace livermark::studies {

std::vector<std::filesystem::path> find_toml_files(const std::vector<std::string> &wanted, const char *folder,
                                                   const char *word) {
    const auto path = support::root_folder() / folder;
    const auto known = support::list_toml(path);
    if (known.empty() && wanted.empty())
        throw support::InputError(
            fmt::format("{}: there is no {} here; set LIVERMARK_ROOT to a Livermark source tree", path.string(), word));
    const auto touching_path = support::root_folder() / touching_load_cases_folder;
    const bool may_touch = folder == std::string_view(load_cases_folder) && std::filesystem::exists(touching_path);
    const auto touching = may_touch ? support::list_toml(touching_path) : std::vector<std::string>{};
    std::vector<std::filesystem::path> files;
    for (const auto &name : wanted.empty() ? known : wanted) {
        std::filesystem::path file = name;
        if (std::ranges::find(known, name) != known.end())
            file = path / (name + ".toml");
        else if (std::ranges::find(touching, name) != touching.end())
            file = touching_path / (name + ".toml");
        else if (support::file_ending(file) != ".toml" &&
                 !(folder == std::string_view(bodies_folder) && file.has_extension()))
            throw support::InputError(support::unknown_name(word, name, known));
        if (std::ranges::find(files, file) != files.end())
            throw support::InputError(fmt::format("{} '{}' is asked for twice; name it once", word, name));
        files.push_back(file);
    }
    return files;
}

} // namespace livermark::studies
