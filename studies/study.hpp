#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "core/support/files.hpp"

namespace livermark::studies {

/// Records that a study finds, of each body one, and what a user should know of the input, a sentence each.
template <class Record> struct Found {
    std::vector<Record> records;
    std::vector<std::string> notes;
};

/// Folders of bodies and load cases below the root.
inline constexpr const char *bodies_folder = "meshes";
inline constexpr const char *load_cases_folder = "load_cases";
inline constexpr const char *moving_load_cases_folder = "load_cases/moving";  ///< in which a tool moves
inline constexpr const char *needle_load_cases_folder = "load_cases/needles"; ///< in which a needle is driven in
inline constexpr const char *slow_load_cases_folder = "load_cases/slow";      ///< in which time passes in the material
inline constexpr const char *touching_load_cases_folder = "load_cases/touching"; ///< that run where they are named

/// A .toml file, or of a body also a mesh file, for each name or path that was asked for; all that ship if none was.
/// Among load cases those of touching_load_cases_folder are known by name too.
/// @param folder  one of these
/// @param word    "body" or "load case", for messages
/// @throws support::InputError for a name that does not ship, with the nearest one that does; for a load case of
///   another folder with the command that takes it
std::vector<std::filesystem::path> find_toml_files(const std::vector<std::string> &wanted, const char *folder,
                                                   const char *word);

/// A folder for result files, made where it is missing. If nothing has come into a folder that was made, it is removed
/// again, so that refused input leaves none.
class OutputFolder {
  public:
    /// @throws support::InputError if it cannot be made
    explicit OutputFolder(std::filesystem::path path);
    ~OutputFolder();
    OutputFolder(const OutputFolder &) = delete;
    OutputFolder &operator=(const OutputFolder &) = delete;

    const std::filesystem::path &path() const { return path_; }

  private:
    std::filesystem::path path_;
    std::vector<std::filesystem::path> made_; ///< the inner ones first
};

/// A file in such a folder that this process alone writes as long as this lives.
class OutputFile {
  public:
    /// @throws support::InputError if the folder cannot be made, the file cannot be written, or another process is
    ///   about to write it
    OutputFile(const std::filesystem::path &folder, const std::string &name);
    /// The same in the folder of a body, <output>/<body>.
    OutputFile(const std::filesystem::path &output, const core::Problem &problem, const std::string &name)
        : OutputFile(output / problem.body->name, name) {}

    const std::filesystem::path &path() const { return path_; }

  private:
    std::unique_ptr<OutputFolder> folder_;
    std::filesystem::path path_;
    std::unique_ptr<support::FileClaim> claim_; ///< given back before the folder
};

/// Called before each step of long work: its number, from 1, how many steps there are, and what it is about.
using ProgressReport = std::function<void(int step, int num_steps, const std::string &about)>;

/// Numbers the steps of one piece of work.
class Steps {
  public:
    /// @param report  may be empty; it has to outlive this
    Steps(int num_steps, const ProgressReport &report) : num_steps_(num_steps), report_(report) {}

    /// Begins the next step.
    void next(const std::string &about);

  private:
    int num_steps_;
    int step_ = 0;
    const ProgressReport &report_;
};

/// A clock that is in one of several stages of the work, or stands still.
class TimeSpent {
  public:
    /// Ends the stage that it was in, if any. A stage that comes again goes on where it was.
    void begin(const std::string &stage);

    /// Ends the stage that it is in, if any, and begins no other.
    void stop();

    /// Adds what another clock measured [s].
    void add(const std::string &stage, double seconds);
    void add(const TimeSpent &other);

    /// In the order in which they began; with what they took [s], each when it has ended.
    const std::vector<std::pair<std::string, double>> &stages() const { return stages_; }

    /// A sentence, then a line for each stage that took a hundredth of the time or more, the longest first.
    std::string text() const;

  private:
    using Clock = std::chrono::steady_clock;

    std::vector<std::pair<std::string, double>> stages_; ///< [s]
    std::string current_;
    bool is_running_ = false;
    Clock::time_point start_;
};

} // namespace livermark::studies
