#pragma once

#include <filesystem>
#include <string>

namespace livermark::support {

/// Claim on the name of a file that long work is going to write, so that no other process writes it meanwhile and one
/// of two results is lost. It is a lock (fcntl) on one byte of the file .livermark.lock in the same folder, which the
/// name chooses: the system gives it back when the process ends, however that ends, and processes that are forked have
/// none of it. The last claim in a folder removes the file. Where a file system has no locks nothing is claimed.
class FileClaim {
  public:
    /// @param file  in a folder that exists; it need not be there itself
    /// @throws InputError if another process has claimed it
    explicit FileClaim(const std::filesystem::path &file);
    ~FileClaim();
    FileClaim(const FileClaim &) = delete;
    FileClaim &operator=(const FileClaim &) = delete;

  private:
    std::filesystem::path lock_;
    long place_ = 0; ///< the byte
    bool is_held_ = false;
};

} // namespace livermark::support
