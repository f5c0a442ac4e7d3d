#pragma once

#include <memory>
#include <string>

namespace livermark::support {

/// Whether mpirun (or srun) started this program more than once, from what Open MPI, PMI or PMIx put into the
/// environment; MPI need not run for that.
bool started_on_many_ranks();

/// MPI runs while this lives. One per program; every rank has to end it in an orderly way, outside of any exception.
class MpiSession {
  public:
    /// @throws InputError in a build without MPI
    MpiSession();
    ~MpiSession();
    MpiSession(const MpiSession &) = delete;
    MpiSession &operator=(const MpiSession &) = delete;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

/// Starts MPI, unless it runs, for a library that wants a communicator where there is one process. Nobody else is there
/// to talk to: MPI opens no port, starts no daemon, and ends with the program. The environment decides that, whatever
/// it said before, and is afterwards as it was.
void start_mpi_in_one_process();

/// Number of this rank, 0 where MPI does not run.
int mpi_rank();

/// Number of ranks, 1 where MPI does not run.
int mpi_num_ranks();

/// The text of the lowest rank that has one; collective.
/// @return empty if every rank's is empty
std::string first_text_of_ranks(const std::string &mine);

/// Says why and ends all ranks at once, for a fault that the others cannot know of: they would wait for ever.
[[noreturn]] void abort_all_ranks(const std::string &why);

} // namespace livermark::support
