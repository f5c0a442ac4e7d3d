#include "results/provenance.hpp"

#include <chrono>
#include <fmt/chrono.h>
#include <fstream>
#include <thread>
#include <utility>

namespace livermark::results {

namespace {

std::string cpu_name() {
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.starts_with("model name"))
            if (const auto colon = line.find(": "); colon != std::string::npos)
                return line.substr(colon + 2);
    return "unknown";
}

std::string now_utc() {
    return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                       fmt::gmtime(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now())));
}

} // namespace

Provenance current_provenance(std::string command) {
    Provenance provenance;
    provenance.software_version = LIVERMARK_VERSION;
    provenance.git_commit = git_commit();
    provenance.created = now_utc();
    provenance.command = std::move(command);
    provenance.cpu = cpu_name();
    provenance.compiler = LIVERMARK_COMPILER;
    provenance.build_type = LIVERMARK_BUILD_TYPE;
    // glibc counts the processors that this process may run on, not those of the machine.
    provenance.threads = static_cast<int>(std::thread::hardware_concurrency());
    return provenance;
}

} // namespace livermark::results
