#include "app/cli/segment_program.hpp"

#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <sys/file.h>
#include <unistd.h>
#include <utility>

#include "core/support/input_error.hpp"

namespace livermark::cli {

namespace {

namespace fs = std::filesystem;

constexpr const char *segment_target = "livermark-segment";
constexpr const char *is_needed = "bodies of images and surfaces need the program livermark-segment";

/// The source tree of a build folder of CMake and Ninja; empty if it is none, or the tree went.
fs::path source_of(const fs::path &build_folder) {
    constexpr std::string_view key = "CMAKE_HOME_DIRECTORY:INTERNAL=";
    std::ifstream cache(build_folder / "CMakeCache.txt");
    for (std::string line; std::getline(cache, line);)
        if (line.starts_with(key)) {
            const fs::path source = line.substr(key.size());
            std::error_code error;
            return fs::exists(source / "scripts" / "bootstrap", error) ? source : fs::path();
        }
    return {};
}

bool has_segment_target(const fs::path &build_folder) {
    std::ifstream rules(build_folder / "build.ninja");
    for (std::string line; std::getline(rules, line);)
        if (line.find(segment_target) != std::string::npos)
            return true;
    return false;
}

/// Runs CMake with what it prints on standard error, because standard output is a result.
bool run_cmake(std::vector<std::string> words) {
    words.insert(words.begin(), {"sh", "-c", "exec cmake \"$@\" 1>&2", "sh"});
    return support::run_printing(words).status == 0;
}

/// Waits while another process builds in the same folder.
class BuildLock {
  public:
    explicit BuildLock(const fs::path &folder)
        : file_(open((folder / ".livermark-segment.lock").c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0666)) {
        if (file_ >= 0)
            flock(file_, LOCK_EX);
    }
    ~BuildLock() {
        if (file_ >= 0)
            close(file_);
    }
    BuildLock(const BuildLock &) = delete;
    BuildLock &operator=(const BuildLock &) = delete;
    bool is_held() const { return file_ >= 0; }

  private:
    int file_;
};

/// Builds the program that is missing, in the build folder that this one lies in. Packages are left alone.
/// @throws support::InputError with the command that does it, where it cannot be built here
void build_segment_program(const fs::path &program) {
    const auto folder = program.parent_path();
    const auto source = source_of(folder);
    if (source.empty())
        throw support::InputError(
            fmt::format("{}, which is not built here; build it with {}", is_needed, command_that_builds));
    const BuildLock lock(folder);
    if (!lock.is_held())
        throw support::InputError(fmt::format("{}, and {} cannot be written to; build it with {}", is_needed,
                                              folder.string(), command_that_builds));
    if (fs::exists(program))
        return; // another process has built it meanwhile
    if (!has_segment_target(folder)) {
        fmt::print(stderr, "livermark: {}; cmake looks for ITK and CGAL\n", is_needed);
        if (!run_cmake({"-S", source.string(), "-B", folder.string()}) || !has_segment_target(folder))
            throw support::InputError(fmt::format("{}, which needs ITK and CGAL, and they are not installed or are "
                                                  "switched off; install and build with {} in {}",
                                                  is_needed, command_that_builds, source.string()));
    }
    fmt::print(stderr, "livermark: {}, which is compiled now, once, in some minutes: cmake --build {} --target {}\n",
               is_needed, folder.string(), segment_target);
    if (!run_cmake({"--build", folder.string(), "--target", segment_target}) || !fs::exists(program))
        throw support::InputError(fmt::format("{}, which could not be compiled; what cmake says stands above, and {} "
                                              "in {} does it with all that it needs",
                                              is_needed, command_that_builds, source.string()));
}

fs::path segment_program() {
    return fs::read_symlink("/proc/self/exe").parent_path() / segment_target;
}

} // namespace

bool has_segment_program() {
    return fs::exists(segment_program());
}

support::Printed segment(std::vector<std::string> words) {
    const auto program = segment_program();
    if (!fs::exists(program))
        build_segment_program(program);
    words.insert(words.begin(), {program.string(), "--parent", std::to_string(getpid())});
    auto printed = support::run_printing(words);
    constexpr int refused = 2;
    if (printed.status == refused)
        throw support::InputError(printed.output);
    if (printed.status < 0 || printed.status > refused)
        throw std::runtime_error(
            printed.output.empty()
                ? fmt::format("{} was ended from outside; is there too little memory?", program.string())
                : printed.output);
    return printed;
}

} // namespace livermark::cli
