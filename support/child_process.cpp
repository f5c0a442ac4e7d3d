#include "support/child_process.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "support/input_error.hpp"
#include "support/root_folder.hpp"
#include "support/whole_file.hpp"

extern char **environ; // NOLINT(readability-redundant-declaration): POSIX asks for it

namespace livermark::support {

ScratchFolder::ScratchFolder() {
    const auto parent = std::filesystem::temp_directory_path();
    auto name = (parent / "livermark_XXXXXX").string();
    if (!mkdtemp(name.data()))
        throw InputError(fmt::format("{}: no folder can be made here ({}); set TMPDIR to one that is writable",
                                     parent.string(), std::strerror(errno)));
    path = name;
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
}

ChildOutcome run_program(const std::vector<std::string> &words) {
    const ScratchFolder scratch;
    const auto output = scratch.path / "output";
    std::vector<std::string> kept = words; // posix_spawn wants them writable, and leaves them alone
    std::vector<char *> arguments;
    for (auto &word : kept)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    pid_t process = 0;
    const int error = posix_spawnp(&process, arguments.front(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    ChildOutcome outcome;
    int status = 0;
    if (error != 0) {
        outcome.lines.push_back(fmt::format("{}: {}", words.front(), std::strerror(error)));
        return outcome;
    }
    if (waitpid(process, &status, 0) == process && WIFEXITED(status))
        outcome.status = WEXITSTATUS(status);
    std::ifstream stream(output);
    for (std::string line; std::getline(stream, line);)
        if (!line.empty())
            outcome.lines.push_back(line);
    return outcome;
}

Converted convert_by_script(const std::string &script, const std::filesystem::path &file, const std::string &remedy) {
    const ScratchFolder scratch;
    const auto text = scratch.path / "converted";
    auto [status, lines] = run_program(
        {(root_folder() / "scripts" / script).string(), std::filesystem::absolute(file).string(), text.string()});
    if (status != 0)
        throw InputError(fmt::format("{}: cannot be converted ({}); {}", file.string(),
                                     lines.empty() ? "no reason given" : lines.back(), remedy));
    return {read_text(text), std::move(lines)};
}

} // namespace livermark::support
