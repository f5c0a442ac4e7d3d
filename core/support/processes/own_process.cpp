#include "core/support/processes/own_process.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <new>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "core/support/input_error.hpp"

namespace livermark::support {

std::string reason_of(const std::exception &error, std::string_view remedy) {
    const std::string_view text = error.what();
    // deal.II has an exception of its own, of several lines.
    const bool is_of_deal_ii = text.find("tried to allocate some memory") != std::string_view::npos;
    if (is_of_deal_ii || dynamic_cast<const std::bad_alloc *>(&error) != nullptr)
        return fmt::format("there is too little memory; {}", remedy);
    return std::string(text);
}

void return_freed_memory() {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

namespace {

namespace fs = std::filesystem;

constexpr double unlimited = std::numeric_limits<double>::infinity();

/// The number that a file begins with; nothing for "max", and where there is no such file.
std::optional<double> number_in(const fs::path &file) {
    std::ifstream stream(file);
    double number = 0.0;
    return stream >> number ? std::optional(number) : std::nullopt;
}

/// The number behind a word, in a file of lines that begin with a word.
std::optional<double> number_behind(const fs::path &file, std::string_view wanted) {
    std::ifstream lines(file);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string word;
        if (double number = 0.0; words >> word && word == wanted && words >> number)
            return number;
    }
    return std::nullopt;
}

bool is_in_list(std::string_view list, std::string_view word) {
    while (!list.empty()) {
        const auto comma = std::min(list.find(','), list.size());
        if (list.substr(0, comma) == word)
            return true;
        list.remove_prefix(std::min(comma + 1, list.size()));
    }
    return false;
}

/// Place where a kind of control groups is mounted.
struct Mount {
    std::string group; ///< the group that is seen there
    std::string place;
};

/// @param controller  of version 1; empty for version 2
std::optional<Mount> mount_of(const fs::path &root, std::string_view controller) {
    std::ifstream lines(root / "proc/self/mountinfo");
    for (std::string line; std::getline(lines, line);) {
        const auto dash = line.find(" - ");
        if (dash == std::string::npos)
            continue;
        std::istringstream before(line.substr(0, dash)), after(line.substr(dash + 3));
        std::string ignored, kind, options;
        Mount mount;
        before >> ignored >> ignored >> ignored >> mount.group >> mount.place;
        after >> kind >> ignored >> options;
        if (controller.empty() ? kind == "cgroup2" : kind == "cgroup" && is_in_list(options, controller))
            return mount;
    }
    return std::nullopt;
}

/// The group of this process, such as /docker/12ab.
std::optional<std::string> group_of_process(const fs::path &root, std::string_view controller) {
    std::ifstream lines(root / "proc/self/cgroup");
    for (std::string line; std::getline(lines, line);) {
        const auto first = line.find(':'), second = line.find(':', first + 1);
        if (second == std::string::npos)
            continue;
        const auto controllers = std::string_view(line).substr(first + 1, second - first - 1);
        if (controller.empty() ? controllers.empty() : is_in_list(controllers, controller))
            return line.substr(second + 1);
    }
    return std::nullopt;
}

/// Folders of the group of this process and of all above it that can be seen.
std::vector<fs::path> folders_of_groups(const fs::path &root, std::string_view controller) {
    const auto mount = mount_of(root, controller);
    auto group = group_of_process(root, controller);
    if (!mount || !group)
        return {};
    const auto top = root / fs::path(mount->place).relative_path();
    if (mount->group != "/" && group->starts_with(mount->group)) // a container that sees its own group alone
        group->erase(0, mount->group.size());
    auto below = fs::path(*group).relative_path().lexically_normal();
    std::vector<fs::path> folders;
    for (std::error_code ignored; !below.empty() && *below.begin() != ".."; below = below.parent_path())
        if (fs::is_directory(top / below, ignored))
            folders.push_back(top / below);
    folders.push_back(top);
    return folders;
}

/// @param cache  the word for memory that holds files which nobody uses, in memory.stat
double left_in(const fs::path &group, const char *limit, const char *usage, std::string_view cache) {
    const auto most = number_in(group / limit);
    if (!most)
        return unlimited;
    const double used = number_in(group / usage).value_or(0.0);
    const double cached = number_behind(group / "memory.stat", cache).value_or(0.0);
    return std::max(*most - std::max(used - cached, 0.0), 0.0);
}

double memory_of_groups(const fs::path &root) {
    double bytes = unlimited;
    for (const auto &group : folders_of_groups(root, ""))
        for (const char *limit : {"memory.max", "memory.high"})
            bytes = std::min(bytes, left_in(group, limit, "memory.current", "inactive_file"));
    for (const auto &group : folders_of_groups(root, "memory"))
        bytes =
            std::min(bytes, left_in(group, "memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"));
    return bytes;
}

double cores_of_groups(const fs::path &root) {
    double cores = unlimited;
    for (const auto &group : folders_of_groups(root, "")) {
        std::ifstream stream(group / "cpu.max");
        if (double quota = 0.0, period = 0.0; stream >> quota >> period && quota > 0.0 && period > 0.0)
            cores = std::min(cores, quota / period);
    }
    for (const auto &group : folders_of_groups(root, "cpu")) {
        const double quota = number_in(group / "cpu.cfs_quota_us").value_or(-1.0);
        const double period = number_in(group / "cpu.cfs_period_us").value_or(-1.0);
        if (quota > 0.0 && period > 0.0)
            cores = std::min(cores, quota / period);
    }
    return cores;
}

} // namespace

MachineShare share_of_machine(const fs::path &root) {
    const double cores = std::max(1U, std::thread::hardware_concurrency()); // those that this process may run on
    const auto free_kibibytes = number_behind(root / "proc/meminfo", "MemAvailable:");
    return {.cores = static_cast<int>(std::max(std::floor(std::min(cores, cores_of_groups(root))), 1.0)),
            .bytes = std::min(free_kibibytes ? 1024.0 * *free_kibibytes : unlimited, memory_of_groups(root))};
}

namespace {

/// Exit statuses of the process.
enum Ending : int { done = 0, refused = 2, failed = 3, out_of_memory = 4 };

/// Memory in a file without a name, which both processes see.
class SharedText {
  public:
    SharedText() : file_(memfd_create("livermark", MFD_CLOEXEC)) {
        if (file_ < 0)
            throw std::runtime_error(fmt::format("no memory to share: {}", std::strerror(errno)));
    }
    ~SharedText() { close(file_); }
    SharedText(const SharedText &) = delete;
    SharedText &operator=(const SharedText &) = delete;

    bool put(std::string_view text) const {
        while (!text.empty()) {
            const auto written = write(file_, text.data(), text.size());
            if (written < 0 && errno != EINTR)
                return false;
            text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(written, 0)));
        }
        return true;
    }

    std::string get() const {
        std::string text(static_cast<std::size_t>(std::max<off_t>(lseek(file_, 0, SEEK_END), 0)), '\0');
        std::size_t place = 0;
        while (place < text.size()) {
            const auto count = pread(file_, text.data() + place, text.size() - place, static_cast<off_t>(place));
            if (count <= 0 && errno != EINTR)
                break;
            place += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
        }
        text.resize(place);
        return text;
    }

  private:
    int file_;
};

/// Bytes of address space that this process has.
std::uint64_t address_space() {
    std::uint64_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::uint64_t value) {
    const rlimit both{value, value};
    setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

void put_limits(const ReaderLimits &limits) {
    prctl(PR_SET_PDEATHSIG, SIGKILL); // nobody would take what it reads
    limit(RLIMIT_CORE, 0);
    limit(RLIMIT_CPU, static_cast<std::uint64_t>(limits.seconds));
    alarm(30U + 3U * static_cast<unsigned>(limits.seconds));
#ifndef __SANITIZE_ADDRESS__ // which takes terabytes of address space for itself
    limit(RLIMIT_AS, address_space() + limits.bytes);
#endif
    for (const int signal : {SIGSEGV, SIGABRT, SIGFPE, SIGBUS, SIGILL, SIGXCPU, SIGALRM, SIGINT, SIGTERM})
        std::signal(signal, SIG_DFL); // handlers of MPI and others print pages
    if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0) {
        dup2(nowhere, STDOUT_FILENO);
        dup2(nowhere, STDERR_FILENO);
    }
}

int ending_of(const std::function<std::string()> &work, const SharedText &result) {
    try {
        return result.put(work()) ? done : out_of_memory;
    } catch (const InputError &error) {
        result.put(error.what());
        return refused;
    } catch (const std::bad_alloc &) {
        return out_of_memory;
    } catch (const std::length_error &) {
        return out_of_memory;
    } catch (const std::exception &error) {
        result.put(error.what());
        return failed;
    } catch (...) {
        return failed;
    }
}

std::string megabytes(std::uint64_t bytes) {
    return fmt::format("{} MB", bytes >> 20);
}

[[noreturn]] void refuse_file(const std::filesystem::path &file, const std::string &why) {
    throw InputError("{}: it cannot be read ({}), so it is damaged or not what its name says; export it again",
                     file.string(), why);
}

} // namespace

ReaderLimits limits_for(const std::filesystem::path &file, double bytes_per_byte) {
    std::error_code error;
    double size = 0.0;
    if (std::filesystem::is_directory(file, error)) {
        for (auto entry = std::filesystem::directory_iterator(file, error);
             !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
            if (std::error_code ignored; entry->is_regular_file(ignored))
                size += static_cast<double>(entry->file_size(ignored));
    } else {
        size = static_cast<double>(std::filesystem::file_size(file, error));
        size = error ? 0.0 : size;
    }
    constexpr double least_bytes = 1 << 30, most_bytes = 16.0 * (1 << 30);
    constexpr double least_seconds = 5.0, most_seconds = 600.0, seconds_per_byte = 1e-3;
    return {.seconds = static_cast<int>(std::min(least_seconds + seconds_per_byte * size, most_seconds)),
            .bytes = static_cast<std::uint64_t>(std::min(least_bytes + bytes_per_byte * size, most_bytes))};
}

std::string in_own_process(const std::filesystem::path &file, const ReaderLimits &limits,
                           const std::function<std::string()> &work) {
    const SharedText result;
    const pid_t child = fork();
    if (child < 0)
        throw std::runtime_error(fmt::format("no process to read {}: {}", file.string(), std::strerror(errno)));
    if (child == 0) {
        put_limits(limits);
        _exit(ending_of(work, result)); // without what this process would do at its end
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            throw std::runtime_error(
                fmt::format("the process that reads {} is lost: {}", file.string(), std::strerror(errno)));
    if (WIFSIGNALED(status)) {
        const int signal = WTERMSIG(status);
        if (signal == SIGINT || signal == SIGTERM)
            throw InputError("{}: reading it was broken off from outside; start again", file.string());
        if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL)
            refuse_file(file, fmt::format("it takes more than {} s or {}", limits.seconds, megabytes(limits.bytes)));
        refuse_file(file, fmt::format("a library has broken off with {}", strsignal(signal)));
    }
    switch (WEXITSTATUS(status)) {
    case done:
        return result.get();
    case refused:
        throw InputError(result.get());
    case out_of_memory:
        refuse_file(file, fmt::format("it takes more than {} of memory", megabytes(limits.bytes)));
    default:
        const auto text = result.get();
        const auto line = text.substr(0, text.find('\n'));
        refuse_file(file, line.empty() ? "no reason given" : line.substr(0, 200));
    }
}

} // namespace livermark::support
