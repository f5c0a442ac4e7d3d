#include "tests/child.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <fcntl.h>
#include <grp.h>
#include <memory>
#include <stdexcept>
#include <sys/resource.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace livermark::tests {

namespace {

constexpr int cannot_start = 126;
constexpr unsigned nobody = 65534;

using File = std::unique_ptr<std::FILE, int (*)(std::FILE *)>;

File scratch_file() {
    File file(std::tmpfile(), std::fclose);
    if (!file)
        throw std::runtime_error("no temporary file can be made");
    return file;
}

std::string content(std::FILE *file) {
    std::rewind(file);
    std::string text;
    std::array<char, 4096> buffer{};
    while (const auto size = std::fread(buffer.data(), 1, buffer.size(), file))
        text.append(buffer.data(), size);
    return text;
}

/// Only what may be called between fork and exec.
[[noreturn]] void become(const std::vector<char *> &words, const ChildOptions &options, int output, int errors) {
    bool is_ready = options.folder.empty() || chdir(options.folder.c_str()) == 0;
    is_ready = is_ready && dup2(output, STDOUT_FILENO) >= 0 && dup2(errors, STDERR_FILENO) >= 0;
    if (options.largest_file) {
        const rlimit limit{*options.largest_file, *options.largest_file};
        is_ready = is_ready && setrlimit(RLIMIT_FSIZE, &limit) == 0;
    }
    if (options.address_space) {
        const rlimit limit{*options.address_space, *options.address_space};
        is_ready = is_ready && setrlimit(RLIMIT_AS, &limit) == 0;
    }
    if (options.without_rights && geteuid() == 0)
        is_ready = is_ready && setgroups(0, nullptr) == 0 && setgid(nobody) == 0 && setuid(nobody) == 0;
    if (is_ready)
        execv(words.front(), words.data());
    _exit(cannot_start);
}

} // namespace

ChildEnd run_child(const std::vector<std::string> &words, const ChildOptions &options) {
    const auto output = scratch_file();
    const auto errors = scratch_file();
    const File elsewhere(options.output.empty() ? nullptr : std::fopen(options.output.c_str(), "w"),
                         [](std::FILE *file) { return file ? std::fclose(file) : 0; });
    auto kept = words;
    std::vector<char *> arguments;
    for (auto &word : kept)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const auto process = fork();
    if (process == 0)
        become(arguments, options, fileno(elsewhere ? elsewhere.get() : output.get()), fileno(errors.get()));
    if (process < 0)
        throw std::runtime_error("no process can be started");
    int status = 0;
    auto ended = pid_t{0};
    while (options.killed_when && ended == 0 && !options.killed_when()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        ended = waitpid(process, &status, WNOHANG);
    }
    if (options.killed_when && ended == 0)
        kill(process, options.kill_signal);
    if (ended == 0)
        ended = waitpid(process, &status, 0);
    if (ended != process)
        throw std::runtime_error("the process is lost");
    return {.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
            .signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0,
            .was_started = !(WIFEXITED(status) && WEXITSTATUS(status) == cannot_start),
            .output = content(output.get()),
            .errors = content(errors.get())};
}

} // namespace livermark::tests
