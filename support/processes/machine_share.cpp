#include "support/processes/machine_share.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace livermark::support {

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

/// Where a kind of control groups is mounted.
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

} // namespace livermark::support
