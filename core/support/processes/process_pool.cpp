#include "core/support/processes/own_process.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <deque>
#include <exception>
#include <fmt/format.h>
#include <new>
#include <optional>
#include <poll.h>
#include <span>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <system_error>
#include <unistd.h>
#include <utility>
#include <vector>

#include "core/support/input_error.hpp"

namespace livermark::support {

namespace {

/// Queue of the work for the workers of run_in_process_pool(), which says who does what.
class WorkQueue {
  public:
    /// @param group      shape (I) the group of each item, >= 0
    /// @param waits_for  of each item the items that have to be done before it begins; may be shorter, and has to live
    ///   as long as this
    WorkQueue(std::span<const int> group, std::span<const std::vector<int>> waits_for)
        : waits_for_(waits_for), is_done_(group.size(), 0) {
        for (std::size_t item = 0; item < group.size(); ++item) {
            if (static_cast<std::size_t>(group[item]) >= groups_.size())
                groups_.resize(group[item] + 1);
            groups_[group[item]].items.push_back(static_cast<int>(item));
        }
    }

    /// @param at  the group that the worker is at, or -1; where it goes on
    /// @return nothing if all is begun, or has to wait
    std::optional<int> next(int &at) {
        if (at < 0 || !has_something(groups_[at])) {
            at = -1;
            for (int g = 0; g < static_cast<int>(groups_.size()); ++g) {
                if (!has_something(groups_[g]))
                    continue;
                if (!groups_[g].is_begun) {
                    at = g;
                    break;
                }
                if (at < 0 || groups_[g].items.size() > groups_[at].items.size())
                    at = g;
            }
        }
        if (at < 0)
            return std::nullopt;
        auto &group = groups_[at];
        group.is_begun = true;
        const auto place = first_to_begin(group);
        const int item = *place;
        group.items.erase(place);
        return item;
    }

    void done(int item) { is_done_[item] = 1; }

  private:
    struct Group {
        std::deque<int> items;
        bool is_begun = false;
    };

    std::deque<int>::const_iterator first_to_begin(const Group &group) const {
        return std::ranges::find_if(group.items, [&](int item) {
            return static_cast<std::size_t>(item) >= waits_for_.size() ||
                   std::ranges::all_of(waits_for_[item], [&](int other) { return is_done_[other] != 0; });
        });
    }
    bool has_something(const Group &group) const { return first_to_begin(group) != group.items.end(); }

    std::span<const std::vector<int>> waits_for_;
    std::vector<char> is_done_;
    std::vector<Group> groups_;
};

/// Result of a worker.
enum class Kind : std::int32_t { text, done, input_error, other_error, out_of_memory, gone };

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
        } catch (const std::bad_alloc &) {
            send(Kind::out_of_memory, "");
        } catch (const std::exception &error) {
            send(Kind::other_error, error.what());
        }
    }
    std::fflush(nullptr);
    _exit(0); // destructors are for the process that this one is a copy of
}

/// A place for a process that works. The process goes with the object, at the latest when this process goes.
class Worker {
  public:
    explicit Worker(const Work &work) : work_(work) {}
    ~Worker() { end(); }
    Worker(const Worker &) = delete;
    Worker &operator=(const Worker &) = delete;

    /// @return whether there is a process
    bool start() {
        end();
        int items[2], home[2];
        if (pipe(items) != 0)
            return false;
        if (pipe(home) != 0) {
            close(items[0]);
            close(items[1]);
            return false;
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
            serve(items[0], home[1], work_);
        }
        close(items[0]);
        close(home[1]);
        items_ = items[1];
        home_ = home[0];
        if (process_ < 0)
            end();
        return process_ > 0;
    }

    int home() const { return home_; }
    bool is_there() const { return process_ > 0; }
    bool has_item() const { return item_ >= 0; }
    int item() const { return item_; }

    void begin(WorkQueue &queue) {
        if (!is_there())
            return;
        item_ = queue.next(group_).value_or(-1);
        if (item_ >= 0)
            write_all(items_, &item_, sizeof item_); // if it is gone, its end is read
    }

    /// @param text  how it ended, if it is gone
    Kind receive(std::string &text) {
        Header header;
        bool is_whole = read_all(home_, &header, sizeof header);
        text.assign(is_whole ? header.length : 0, '\0');
        is_whole = is_whole && read_all(home_, text.data(), text.size());
        if (is_whole)
            return header.kind;
        int status = 0;
        waitpid(process_, &status, 0);
        process_ = -1;
        text = WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "ended by itself";
        return Kind::gone;
    }

  private:
    void end() {
        for (int *pipe : {&items_, &home_})
            if (*pipe >= 0)
                close(std::exchange(*pipe, -1));
        if (process_ > 0) {
            kill(process_, SIGKILL);
            waitpid(process_, nullptr, 0);
        }
        process_ = -1;
        item_ = -1;
        group_ = -1;
    }

    const Work &work_;
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

/// All workers, from the first item to the last.
class Pool {
  public:
    using Receive = std::function<void(int, const std::string &)>;

    /// @throws std::system_error if there can be no worker at all
    Pool(WorkQueue &queue, int num_workers, const Work &work, const Receive &receive, const Receive &lost)
        : queue_(queue), receive_(receive), lost_(lost) {
        for (int worker = 0; worker < num_workers; ++worker)
            if (workers_.emplace_back(work); !workers_.back().start()) {
                workers_.pop_back(); // fewer do as well
                break;
            }
        check_there_is_one();
        begin_all();
    }

    void run() {
        for (;;) {
            std::vector<pollfd> pipes;
            std::vector<Worker *> at_work;
            for (auto &worker : workers_)
                if (worker.has_item()) {
                    pipes.push_back({worker.home(), POLLIN, 0});
                    at_work.push_back(&worker);
                }
            if (pipes.empty())
                return;
            if (poll(pipes.data(), pipes.size(), -1) < 0 && errno != EINTR)
                throw std::system_error(errno, std::generic_category(), "waiting for workers");
            for (std::size_t w = 0; w < pipes.size(); ++w)
                if (pipes[w].revents != 0)
                    listen_to(*at_work[w]);
        }
    }

  private:
    /// To those that have nothing to do: what one has done may be what others wait for.
    void begin_all() {
        for (auto &worker : workers_)
            if (!worker.has_item())
                worker.begin(queue_);
    }

    void check_there_is_one() const {
        if (std::ranges::none_of(workers_, &Worker::is_there))
            throw std::system_error(errno, std::generic_category(), "no process for a worker");
    }

    void listen_to(Worker &worker) {
        const int item = worker.item();
        switch (const auto kind = worker.receive(text_); kind) {
        case Kind::text:
            return receive_(item, text_);
        case Kind::input_error:
            throw InputError(text_);
        case Kind::other_error:
            throw std::runtime_error(text_);
        case Kind::out_of_memory:
        case Kind::gone:
            if (kind == Kind::out_of_memory)
                text_ = "out of memory";
            if (!lost_)
                throw std::runtime_error(fmt::format("a worker ended before its work did ({}), on item {} of its work; "
                                                     "start again with fewer at once, or without it",
                                                     text_, item + 1));
            lost_(item, text_);
            worker.start(); // what it had kept may be what filled the memory
            check_there_is_one();
            [[fallthrough]];
        case Kind::done:
            queue_.done(item);
            worker.begin(queue_);
            begin_all();
        }
    }

    WorkQueue &queue_;
    const Receive &receive_;
    const Receive &lost_;
    std::deque<Worker> workers_; // they do not move
    std::string text_;
};

} // namespace

void run_in_process_pool(std::span<const int> group, int num_workers, const Work &work,
                         const std::function<void(int, const std::string &)> &receive,
                         std::span<const std::vector<int>> waits_for,
                         const std::function<void(int, const std::string &)> &lost) {
    WorkQueue queue(group, waits_for);
    if (num_workers == 1 || group.size() < 2) {
        int at = -1;
        while (const auto item = queue.next(at)) {
            try {
                work(*item, [&](const std::string &text) { receive(*item, text); });
            } catch (const std::bad_alloc &) {
                if (!lost)
                    throw;
                lost(*item, "out of memory");
            }
            queue.done(*item);
        }
        return;
    }
    const IgnoredPipeSignal ignored;
    Pool(queue, std::min(num_workers, static_cast<int>(group.size())), work, receive, lost).run();
}

int workers_that_fit(double bytes_per_worker, const MachineShare &share) {
    return static_cast<int>(
        std::clamp(std::floor(share.bytes / bytes_per_worker), 1.0, static_cast<double>(share.cores)));
}

} // namespace livermark::support
