#include "support/process_pool.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <exception>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <poll.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <vector>

#include "support/input_error.hpp"
#include "support/work_queue.hpp"

namespace livermark::support {

namespace {

/// What comes home from a worker.
enum class Kind : std::int32_t { text, done, input_error, other_error };

struct Header {
    Kind kind = Kind::text;
    std::int32_t length = 0; ///< of the text behind it [byte]
};

bool write_all(int pipe, const void *bytes, std::size_t count) {
    const char *at = static_cast<const char *>(bytes);
    while (count > 0) {
        const auto written = write(pipe, at, count);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return false;
        at += written;
        count -= static_cast<std::size_t>(written);
    }
    return true;
}

/// @return false at the end of what comes
bool read_all(int pipe, void *bytes, std::size_t count) {
    char *at = static_cast<char *>(bytes);
    while (count > 0) {
        const auto got = read(pipe, at, count);
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return false;
        at += got;
        count -= static_cast<std::size_t>(got);
    }
    return true;
}

using Work = std::function<void(int, const SendMessage &)>;

/// The life of a worker: items come in, texts go home, until no more items come or nobody listens.
[[noreturn]] void serve(int items, int home, const Work &work) {
    const auto send = [home](Kind kind, const std::string &text) {
        const Header header{kind, static_cast<std::int32_t>(text.size())};
        if (!write_all(home, &header, sizeof header) || !write_all(home, text.data(), text.size()))
            _exit(1);
    };
    for (int item = 0; read_all(items, &item, sizeof item);) {
        try {
            work(item, [&](const std::string &text) { send(Kind::text, text); });
            send(Kind::done, "");
        } catch (const InputError &error) {
            send(Kind::input_error, error.what());
        } catch (const std::exception &error) {
            send(Kind::other_error, error.what());
        }
    }
    std::fflush(nullptr);
    _exit(0); // destructors are for the process that this one is a copy of
}

/// A process that works. It goes with the object, at the latest when this process goes.
class Worker {
  public:
    explicit Worker(const Work &work) {
        int items[2], home[2];
        if (pipe(items) != 0)
            throw std::system_error(errno, std::generic_category(), "no pipe to a worker");
        if (pipe(home) != 0) {
            close(items[0]);
            close(items[1]);
            throw std::system_error(errno, std::generic_category(), "no pipe from a worker");
        }
        std::fflush(nullptr); // or both print what is in the buffers
        const auto parent = getpid();
        process_ = fork();
        if (process_ == 0) {
            prctl(PR_SET_PDEATHSIG, SIGKILL);
            if (getppid() != parent)
                _exit(1);
            close(items[1]);
            close(home[0]);
            serve(items[0], home[1], work);
        }
        close(items[0]);
        close(home[1]);
        items_ = items[1];
        home_ = home[0];
        if (process_ < 0) {
            close(items_);
            close(home_);
            throw std::system_error(errno, std::generic_category(), "no process for a worker");
        }
    }
    ~Worker() {
        close(items_);
        close(home_);
        if (process_ > 0) {
            kill(process_, SIGKILL);
            waitpid(process_, nullptr, 0);
        }
    }
    Worker(const Worker &) = delete;
    Worker &operator=(const Worker &) = delete;

    int home() const { return home_; }
    bool has_item() const { return item_ >= 0; }
    int item() const { return item_; }

    void begin(WorkQueue &queue) {
        item_ = queue.next(group_).value_or(-1);
        if (item_ >= 0)
            write_all(items_, &item_, sizeof item_); // if it is gone, its end is read
    }

    /// @throws std::runtime_error if it is gone
    /// @param name_of  for the message
    Header receive(std::string &text, const std::function<std::string(int)> &name_of) {
        Header header;
        bool is_there = read_all(home_, &header, sizeof header);
        text.assign(is_there ? header.length : 0, '\0');
        is_there = is_there && read_all(home_, text.data(), text.size());
        if (!is_there) {
            int status = 0;
            waitpid(process_, &status, 0);
            process_ = -1;
            throw std::runtime_error(fmt::format(
                "a worker ended before its work did ({}), on {}; start again with fewer at once, or without it",
                WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "without a signal",
                name_of ? name_of(item_) : fmt::format("item {} of its work", item_ + 1)));
        }
        return header;
    }

  private:
    pid_t process_ = -1;
    int items_ = -1;
    int home_ = -1;
    int item_ = -1;
    int group_ = -1;
};

/// Writing to a worker that was killed is an error like any other, not the end of this process.
class IgnoredPipeSignal {
  public:
    IgnoredPipeSignal() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
    ~IgnoredPipeSignal() { std::signal(SIGPIPE, before_); }
    IgnoredPipeSignal(const IgnoredPipeSignal &) = delete;
    IgnoredPipeSignal &operator=(const IgnoredPipeSignal &) = delete;

  private:
    void (*before_)(int);
};

/// @return [byte] that a new process could have; infinite where the system does not say
double available_memory() {
    std::ifstream lines("/proc/meminfo");
    std::string word;
    while (lines >> word)
        if (double kibibytes = 0.0; word == "MemAvailable:" && lines >> kibibytes)
            return 1024.0 * kibibytes;
    return std::numeric_limits<double>::infinity();
}

} // namespace

void run_in_process_pool(std::span<const int> group, int num_workers, const Work &work,
                         const std::function<void(int, const std::string &)> &receive,
                         std::span<const std::vector<int>> waits_for, const std::function<std::string(int)> &name_of) {
    WorkQueue queue(group, waits_for);
    if (num_workers == 1 || group.size() < 2) {
        int at = -1;
        while (const auto item = queue.next(at)) {
            work(*item, [&](const std::string &text) { receive(*item, text); });
            queue.done(*item);
        }
        return;
    }
    const IgnoredPipeSignal ignored;
    std::deque<Worker> workers; // they do not move
    for (int worker = 0; worker < std::min(num_workers, static_cast<int>(group.size())); ++worker)
        workers.emplace_back(work).begin(queue);
    std::string text;
    for (;;) {
        std::vector<pollfd> pipes;
        std::vector<Worker *> at_work;
        for (auto &worker : workers)
            if (worker.has_item()) {
                pipes.push_back({worker.home(), POLLIN, 0});
                at_work.push_back(&worker);
            }
        if (pipes.empty())
            return;
        if (poll(pipes.data(), pipes.size(), -1) < 0 && errno != EINTR)
            throw std::system_error(errno, std::generic_category(), "waiting for workers");
        for (std::size_t w = 0; w < pipes.size(); ++w) {
            if (pipes[w].revents == 0)
                continue;
            switch (at_work[w]->receive(text, name_of).kind) {
            case Kind::text:
                receive(at_work[w]->item(), text);
                break;
            case Kind::done:
                queue.done(at_work[w]->item());
                at_work[w]->begin(queue);
                for (auto &worker : workers) // it may be what others wait for
                    if (!worker.has_item())
                        worker.begin(queue);
                break;
            case Kind::input_error:
                throw InputError(text);
            case Kind::other_error:
                throw std::runtime_error(text);
            }
        }
    }
}

int workers_that_fit(double bytes_per_worker) {
    const auto cores = static_cast<double>(std::max(1U, std::thread::hardware_concurrency()));
    return static_cast<int>(std::clamp(std::floor(available_memory() / bytes_per_worker), 1.0, cores));
}

} // namespace livermark::support
