#include "server/remembered.hpp"

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <sys/stat.h>
#include <tuple>
#include <utility>

namespace livermark::server {

namespace {

using State = std::tuple<dev_t, ino_t, off_t, time_t, long>; ///< device, inode, size, time of change [s], [ns]

std::optional<State> state_of(const std::filesystem::path &path) {
    struct stat found {};
    if (::stat(path.c_str(), &found) != 0)
        return std::nullopt;
    return State{found.st_dev, found.st_ino, found.st_size, found.st_mtim.tv_sec, found.st_mtim.tv_nsec};
}

struct Memory {
    static constexpr std::size_t most_files = 100'000;
    struct Reply {
        State state;
        bool is;
    };
    std::mutex mutex; ///< of what follows
    std::map<std::string, Reply> replies;
};

} // namespace

AskAboutFile remembered(AskAboutFile ask) {
    return [ask = std::move(ask), memory = std::make_shared<Memory>()](const std::filesystem::path &path) {
        // Before the question: if the file changes in between, the next one asks again.
        const auto state = state_of(path);
        if (!state)
            return false;
        {
            const std::lock_guard lock(memory->mutex);
            if (const auto known = memory->replies.find(path.native());
                known != memory->replies.end() && known->second.state == *state)
                return known->second.is;
        }
        const bool is = ask(path);
        const std::lock_guard lock(memory->mutex);
        if (memory->replies.size() >= Memory::most_files)
            memory->replies.clear(); // names that are long gone
        memory->replies.insert_or_assign(path.native(), Memory::Reply{*state, is});
        return is;
    };
}

} // namespace livermark::server
