#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tests/fuzz/mutations.hpp"
#include "tests/fuzz/seed_files.hpp"

/// Damaged files of somebody else's formats: they have to be read, or refused in one sentence, in bounded
/// time, and nothing is left behind.
namespace livermark::tests {

/// All kinds that can be tried: those of fuzz::kinds_of_seeds(), and hdf5 for result files.
std::vector<std::string> kinds_to_try();

/// Ends that one or several inputs came to.
struct Attempts {
    int num_tried = 0, num_read = 0, num_refused = 0;
    double longest = 0.0;              ///< [s]
    std::vector<std::string> faults{}; ///< a sentence each, with the number of the input
    void add(const Attempts &more);
};

/// Inputs of one kind.
class Readers {
  public:
    /// @param folder  an empty one, for the inputs
    Readers(const std::string &kind, std::filesystem::path folder);

    /// Lets the reader of the kind read the seeds as they are.
    Attempts try_seeds() const;
    /// Lets the reader of the kind read the damaged seed of this number, in a process of its own.
    Attempts try_reader(std::uint64_t number) const;
    /// Lets the program do so: it looks at the file, and for some numbers makes a mesh of it.
    Attempts try_program(std::uint64_t number) const;

    /// Writes the damaged seed of a number.
    /// @return what to give to a reader
    std::filesystem::path write(std::uint64_t number) const;

  private:
    std::filesystem::path write(const fuzz::SeedFile &seed, std::string bytes) const;
    Attempts read_apart(const std::filesystem::path &input, const std::string &name) const;

    std::string kind_;
    std::filesystem::path folder_;
    std::vector<fuzz::SeedFile> seeds_;
    std::vector<std::vector<fuzz::ChecksummedBlock>> blocks_; ///< of each seed, of HDF5
};

} // namespace livermark::tests
