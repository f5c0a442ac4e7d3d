#include "core/support/processes/child_process.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <poll.h>
#include <spawn.h>
#include <sstream>
#include <stdexcept>
#include <sys/socket.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "core/support/files.hpp"
#include "core/support/input_error.hpp"

extern char **environ; // NOLINT(readability-redundant-declaration): POSIX asks for it

namespace livermark::support {

namespace {

struct Started {
    pid_t process;
    int error; ///< 0 if it runs
};

/// Starts a program, and destroys the actions.
Started start(const std::vector<std::string> &words, posix_spawn_file_actions_t &actions) {
    std::vector<std::string> kept = words; // posix_spawn wants them writable, and leaves them alone
    std::vector<char *> arguments;
    for (auto &word : kept)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    Started started{0, 0};
    started.error = posix_spawnp(&started.process, arguments.front(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    return started;
}

/// Waits for a program. The exit status; -1 if it was killed.
int end_of(pid_t process) {
    int status = 0;
    return waitpid(process, &status, 0) == process && WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::vector<std::string> lines_of(std::istream &stream) {
    std::vector<std::string> lines;
    for (std::string line; std::getline(stream, line);)
        if (!line.empty())
            lines.push_back(line);
    return lines;
}

/// A pair of sockets between this process and a standard stream of a child.
struct Channel {
    explicit Channel(int stream_of_child) : stream(stream_of_child) {
        std::array<int, 2> ends{};
        if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
            throw std::runtime_error(fmt::format("no connection to a child process: {}", std::strerror(errno)));
        ours = ends[0];
        theirs = ends[1];
    }
    ~Channel() {
        close_theirs();
        close(ours);
    }
    Channel(const Channel &) = delete;
    Channel &operator=(const Channel &) = delete;
    void close_theirs() {
        if (theirs >= 0)
            close(std::exchange(theirs, -1));
    }

    int stream;
    int ours = -1, theirs = -1;
};

struct Receiver {
    Channel *channel;
    std::string *text;
};

/// Sends and receives until the child has closed what it writes to.
void exchange(std::string_view input, const Channel &to_child, const std::vector<Receiver> &receivers) {
    std::array<char, 65536> buffer{};
    std::vector<pollfd> waiting{{to_child.ours, POLLOUT, 0}};
    for (const auto &receiver : receivers)
        waiting.push_back({receiver.channel->ours, POLLIN, 0});
    const auto is_open = [](const pollfd &one) { return one.fd >= 0; };
    while (std::any_of(waiting.begin() + 1, waiting.end(), is_open)) {
        if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR)
            return;
        if (waiting[0].fd >= 0 && waiting[0].revents != 0) {
            const auto sent = send(to_child.ours, input.data(), input.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
            input.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(sent, 0)));
            if (input.empty() || (sent < 0 && errno != EAGAIN && errno != EINTR)) {
                shutdown(to_child.ours, SHUT_WR);
                waiting[0].fd = -1; // which poll passes over
            }
        }
        for (std::size_t r = 0; r < receivers.size(); ++r)
            if (waiting[r + 1].fd >= 0 && waiting[r + 1].revents != 0) {
                const auto received = recv(waiting[r + 1].fd, buffer.data(), buffer.size(), 0);
                if (received > 0)
                    receivers[r].text->append(buffer.data(), static_cast<std::size_t>(received));
                else
                    waiting[r + 1].fd = -1;
            }
    }
}

/// Runs a program to its end, whose standard streams are channels.
/// @param fault  gets why it could not be started
/// @return its exit status; -1 if it could not be started or was killed
int run_on(const std::vector<std::string> &words, std::string_view input, Channel &to_child,
           const std::vector<Receiver> &receivers, std::string &fault) {
    std::vector<Channel *> channels{&to_child};
    for (const auto &receiver : receivers)
        channels.push_back(receiver.channel);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const auto *channel : channels)
        posix_spawn_file_actions_adddup2(&actions, channel->theirs, channel->stream);
    const auto [process, error] = start(words, actions);
    for (auto *channel : channels)
        channel->close_theirs();
    if (error != 0) {
        fault = fmt::format("{}: {}", words.front(), std::strerror(error));
        return -1;
    }
    exchange(input, to_child, receivers);
    return end_of(process);
}

/// Folders that go when a signal ends this process. A handler may neither allocate nor lock, so they are kept as plain
/// characters.
struct FolderToRemove {
    volatile std::sig_atomic_t is_used = 0;
    pid_t owner = 0;
    std::array<char, 512> path{}, gone{};
};
std::array<FolderToRemove, 16> folders_to_remove;

/// Lets rm do the work: it may be started from a handler, and what it does here may not.
void remove_and_end(int signal) {
    for (auto &folder : folders_to_remove)
        if (folder.is_used != 0 && folder.owner == getpid()) { // and not a copy of the process
            // Under another name nobody who still works puts a file into it while it is emptied.
            const bool is_renamed = std::rename(folder.path.data(), folder.gone.data()) == 0;
            const char *path = is_renamed ? folder.gone.data() : folder.path.data();
            const pid_t child = fork();
            if (child == 0) {
                execl("/bin/rm", "rm", "-rf", "--", path, static_cast<char *>(nullptr));
                _exit(1);
            }
            if (child > 0)
                waitpid(child, nullptr, 0);
        }
    std::signal(signal, SIG_DFL);
    raise(signal);
}

void remove_when_ended(const std::string &path) {
    static const bool are_installed = [] {
        for (const int signal : {SIGINT, SIGTERM, SIGHUP})
            if (const auto before = std::signal(signal, remove_and_end); before != SIG_DFL)
                std::signal(signal, before); // somebody else takes care of it
        return true;
    }();
    for (auto &folder : folders_to_remove)
        if (const auto gone = path + ".gone";
            are_installed && folder.is_used == 0 && gone.size() < folder.path.size()) {
            std::ranges::copy(path, folder.path.begin());
            folder.path.at(path.size()) = '\0';
            std::ranges::copy(gone, folder.gone.begin());
            folder.gone.at(gone.size()) = '\0';
            folder.owner = getpid();
            folder.is_used = 1;
            return;
        }
}

void keep_when_ended(const std::string &path) {
    for (auto &folder : folders_to_remove)
        if (folder.is_used != 0 && folder.owner == getpid() && path == folder.path.data())
            folder.is_used = 0;
}

} // namespace

ScratchFolder::ScratchFolder() {
    std::error_code error;
    const char *named = std::getenv("TMPDIR"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    const bool is_empty = named && *named == '\0';
    auto parent = is_empty ? std::filesystem::path("/tmp") : std::filesystem::temp_directory_path(error);
    if (error) {
        throw InputError("TMPDIR: '{}' is not a folder ({}); set it to one that is writable, or unset it",
                         named ? named : "", error.message());
    }
    auto name = (parent / "livermark_XXXXXX").string();
    if (!mkdtemp(name.data()))
        throw InputError("{}: no folder can be made here ({}); set TMPDIR to one that is writable", parent.string(),
                         std::strerror(errno));
    path = name;
    remove_when_ended(path.string());
}

ScratchFolder::~ScratchFolder() {
    keep_when_ended(path.string());
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
}

ChildOutcome run_program(const std::vector<std::string> &words) {
    const ScratchFolder scratch;
    const auto output = scratch.path / "output";
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    posix_spawn_file_actions_adddup2(&actions, STDOUT_FILENO, STDERR_FILENO);
    const auto [process, error] = start(words, actions);
    if (error != 0)
        return {.status = -1, .lines = {fmt::format("{}: {}", words.front(), std::strerror(error))}};
    const int status = end_of(process);
    std::ifstream stream(output);
    return {.status = status, .lines = lines_of(stream)};
}

Printed run_printing(const std::vector<std::string> &words) {
    Channel input(STDIN_FILENO), output(STDOUT_FILENO);
    Printed printed;
    std::string fault;
    printed.status = run_on(words, {}, input, {{&output, &printed.output}}, fault);
    if (!fault.empty())
        printed.output = fault;
    return printed;
}

FilterOutcome run_filter(const std::vector<std::string> &words, std::string_view input) {
    // A reader of a socket may be gone without a signal to this process.
    Channel to_child(STDIN_FILENO), output(STDOUT_FILENO), errors(STDERR_FILENO);
    std::string said;
    FilterOutcome outcome;
    outcome.status = run_on(words, input, to_child, {{&output, &outcome.output}, {&errors, &said}}, said);
    std::istringstream stream(said);
    outcome.lines = lines_of(stream);
    return outcome;
}

namespace {

/// Folder of the Python package: with compiled modules beside the program, in its build folder; else of the source
/// tree; or of an installed package, whose folder livermark/data is the root then.
std::filesystem::path package_folder() {
    std::error_code error;
    auto beside = std::filesystem::read_symlink("/proc/self/exe", error).parent_path() / "python";
    if (std::filesystem::exists(beside / "livermark", error))
        return beside;
    const auto in_tree = root_folder() / "python";
    return std::filesystem::exists(in_tree / "livermark") ? in_tree : root_folder() / ".." / "..";
}

/// The variable that makes the package found, before the absolute places that it held.
std::string search_path() {
    auto path = fmt::format("PYTHONPATH={}", std::filesystem::absolute(package_folder()).string());
    const char *others = std::getenv("PYTHONPATH"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    std::istringstream places(others ? others : "");
    for (std::string place; std::getline(places, place, ':');)
        if (place.starts_with('/'))
            path += ":" + place;
    return path;
}

/// Whether there is no such interpreter, or one that lacks a library.
bool is_lacking(const FilterOutcome &outcome, const std::string &last) {
    constexpr int no_such_program = 127; // what env says
    return outcome.status == no_such_program || last.starts_with("ModuleNotFoundError: ") ||
           last.starts_with("ImportError: ") ||
           std::ranges::any_of(outcome.lines, [](const auto &line) { return line.starts_with("Unknown option: -P"); });
}

/// Remedy where a program in Python could not import a module that is there, or could not start, and PYTHONPATH
/// names places to look for modules, which may be those of another Python.
/// @param lines  that it wrote to standard error
/// @return empty for another end, or if there is no such variable
std::string remedy_for_modules(const std::vector<std::string> &lines) {
    const char *places = std::getenv("PYTHONPATH"); // NOLINT(concurrency-mt-unsafe): nobody changes the environment
    if (!places || *places == '\0' || lines.empty())
        return "";
    const bool is_foreign = lines.back().starts_with("ImportError: "); // what is missing has another name, and remedy
    const bool cannot_start =
        lines.front().starts_with("Python path configuration") || lines.front().starts_with("Fatal Python error");
    return is_foreign || cannot_start ? "unset PYTHONPATH, which may name modules of another Python" : "";
}

/// The words that start Python with a program behind them. Nothing of the working directory is run, which may be a
/// folder of results that somebody was sent: no module there takes the place of one of Python's, neither by itself (-P,
/// Python 3.11) nor by an empty or relative place in PYTHONPATH. PYTHONHOME of another interpreter is left out.
/// @param interpreter  path or name
std::vector<std::string> start_of_python(const std::string &interpreter) {
    return {"env", "-u", "PYTHONHOME", "-u", "PYTHONINSPECT", "-u", "PYTHONSTARTUP", search_path(), interpreter, "-P"};
}

} // namespace

Converted convert_by_script(const std::string &script, const std::filesystem::path &file, const std::string &remedy) {
    check_readable(file);
    const ScratchFolder scratch;
    const auto text = scratch.path / "converted";
    auto words = start_of_python("/usr/bin/python3"); // of the distribution, as scripts are started by hand
    words.insert(words.end(), {(root_folder() / "scripts" / script).string(), std::filesystem::absolute(file).string(),
                               text.string()});
    auto [status, lines] = run_program(words);
    if (status != 0) {
        const auto reason = lines.empty() ? std::string("no reason given") : lines.back();
        const auto module_remedy = remedy_for_modules(lines);
        throw InputError("{}: cannot be converted ({}); {}", file.string(), reason,
                         module_remedy.empty() ? remedy : module_remedy);
    }
    return {read_text(text), std::move(lines)};
}

namespace {

/// The words that start a part of the package.
std::vector<std::string> words_of_part(const std::string &interpreter, const std::string &part,
                                       const std::vector<std::string> &arguments) {
    auto words = start_of_python(interpreter);
    words.insert(words.end(), {"-m", "livermark." + part});
    words.insert(words.end(), arguments.begin(), arguments.end());
    return words;
}

/// Output of a part, and the interpreter that ran it; throws as run_python().
std::pair<std::string, std::string> run_by_any_python(const std::string &part,
                                                      const std::vector<std::string> &arguments, std::string_view input,
                                                      const std::string &purpose, const std::string &packages) {
    std::string lacking, remedy;
    for (const auto *const interpreter : {"/usr/bin/python3", "python3"}) {
        auto outcome = run_filter(words_of_part(interpreter, part, arguments), input);
        const auto last = outcome.lines.empty() ? "no reason given" : outcome.lines.back();
        if (outcome.status == 0)
            return {std::move(outcome.output), interpreter};
        if (outcome.status == 2 && !is_lacking(outcome, last))
            throw InputError(last);
        if (remedy.empty())
            remedy = remedy_for_modules(outcome.lines);
        if (!is_lacking(outcome, last) && !remedy.empty())
            break;
        if (!is_lacking(outcome, last))
            throw std::runtime_error(fmt::format("livermark.{} failed: {}", part, fmt::join(outcome.lines, "\n")));
        if (lacking.empty())
            lacking = last.find(": ") == std::string::npos ? last : last.substr(last.find(": ") + 2);
    }
    throw InputError("{} needs libraries of Python ({}); {}", purpose, lacking.empty() ? "it does not start" : lacking,
                     remedy.empty() ? "apt-get install " + packages : remedy);
}

} // namespace

std::string run_python(const std::string &part, const std::vector<std::string> &arguments, std::string_view input,
                       const std::string &purpose, const std::string &packages) {
    return run_by_any_python(part, arguments, input, purpose, packages).first;
}

void continue_as_python(const std::string &part, const std::vector<std::string> &arguments, const std::string &purpose,
                        const std::string &packages) {
    const auto interpreter = run_by_any_python(part, {"--help"}, {}, purpose, packages).second;
    auto words = words_of_part(interpreter, part, arguments);
    std::vector<char *> pointers;
    for (auto &word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    std::fflush(nullptr);
    execvp(pointers.front(), pointers.data());
    throw std::runtime_error(fmt::format("{}: {}", interpreter, std::strerror(errno))); // NOLINT(concurrency-mt-unsafe)
}

namespace {

/// Says that all was written. A pipe without a reader would end the process by a signal, which is taken back.
ssize_t write_what_can_be(void * /*cookie*/, const char *text, std::size_t size) {
    sigset_t pipe_signal, before;
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    pthread_sigmask(SIG_BLOCK, &pipe_signal, &before);
    std::size_t place = 0;
    while (place < size) {
        const auto written = write(STDERR_FILENO, text + place, size - place);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            break;
        place += static_cast<std::size_t>(written);
    }
    if (place < size && errno == EPIPE) {
        const timespec at_once{0, 0};
        sigtimedwait(&pipe_signal, nullptr, &at_once);
    }
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return static_cast<ssize_t>(size);
}

} // namespace

UnfailingStandardError::UnfailingStandardError() : before_(stderr) {
    if (std::FILE *stream = fopencookie(nullptr, "w", {nullptr, write_what_can_be, nullptr, nullptr})) {
        std::setvbuf(stream, nullptr, _IOLBF, 4096); // lines of two processes do not mix
        stderr = stream;
    }
}

UnfailingStandardError::~UnfailingStandardError() {
    if (stderr != before_) {
        std::fclose(stderr);
        stderr = before_;
    }
}

} // namespace livermark::support
