#pragma once

#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <sys/types.h>
#include <system_error>

/// Listening sockets, as /proc knows them.
namespace livermark::tests {

/// Numbers of the processes that a process has started, and those have.
inline std::set<pid_t> descendants(pid_t ancestor) {
    std::set<pid_t> found{ancestor};
    // Parents have been there before their children, but numbers begin again: several times round.
    for (std::size_t before = 0; before != found.size();) {
        before = found.size();
        std::error_code error;
        for (const auto &entry : std::filesystem::directory_iterator("/proc", error)) {
            const auto name = entry.path().filename().string();
            if (name.find_first_not_of("0123456789") != std::string::npos)
                continue;
            std::ifstream file(entry.path() / "stat");
            std::string text((std::istreambuf_iterator<char>(file)), {});
            // number (name, which may have anything in it) state parent
            std::istringstream rest(text.substr(std::min(text.rfind(')') + 1, text.size())));
            std::string state;
            pid_t parent = 0;
            if (rest >> state >> parent && found.contains(parent))
                found.insert(std::stoi(name));
        }
    }
    found.erase(ancestor);
    return found;
}

/// Local addresses on which a process listens over TCP, as /proc/net/tcp and tcp6 write them: hexadecimal, ip:port.
inline std::set<std::string> listening(pid_t process) {
    const auto folder = fmt::format("/proc/{}/", process);
    std::set<std::string> sockets;
    std::error_code error;
    for (auto entry = std::filesystem::directory_iterator(folder + "fd", error);
         !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
        std::error_code gone;
        sockets.insert(std::filesystem::read_symlink(entry->path(), gone).string());
    }
    std::set<std::string> found;
    for (const auto *kind : {"net/tcp", "net/tcp6"}) {
        std::ifstream table(folder + kind);
        std::string line;
        while (std::getline(table, line)) {
            std::istringstream words(line);
            std::string number, local, remote, state, queue, timer, retransmits, user, timeout, inode;
            words >> number >> local >> remote >> state >> queue >> timer >> retransmits >> user >> timeout >> inode;
            if (state == "0A" && sockets.contains(fmt::format("socket:[{}]", inode)))
                found.insert(local);
        }
    }
    return found;
}

} // namespace livermark::tests
