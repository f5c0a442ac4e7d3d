#include "support/processes/own_process.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <new>
#include <stdexcept>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>

#include "support/input_error.hpp"

namespace livermark::support {

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
    throw InputError(fmt::format(
        "{}: it cannot be read ({}), so it is damaged or not what its name says; export it again", file.string(), why));
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
            throw InputError(fmt::format("{}: reading it was broken off from outside; start again", file.string()));
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
