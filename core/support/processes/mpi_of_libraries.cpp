#include <deal.II/base/config.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>

#ifdef DEAL_II_WITH_MPI
#include <deal.II/base/mpi.h>
#endif

#include "core/support/processes/mpi_session.hpp"

/// The part of Livermark that does not need MPI: whether somebody wanted several ranks, and what libraries ask for that
/// were built with MPI.
namespace livermark::support {

bool started_on_many_ranks() {
    constexpr std::array sizes{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE"};
    return std::ranges::any_of(sizes, [](const char *name) {
        const char *size = std::getenv(name);
        return size && std::atoi(size) > 1;
    });
}

#ifdef DEAL_II_WITH_MPI

namespace {

/// A variable of the environment, for as long as this lives.
class Environment {
  public:
    Environment(const char *name, const char *value) : name_(name) {
        if (const char *before = std::getenv(name))
            before_ = before;
        ::setenv(name, value, 1);
    }
    ~Environment() {
        if (before_)
            ::setenv(name_, before_->c_str(), 1);
        else
            ::unsetenv(name_);
    }
    Environment(const Environment &) = delete;
    Environment &operator=(const Environment &) = delete;

  private:
    const char *name_;
    std::optional<std::string> before_;
};

/// Ends MPI with the program, if nobody else has by then.
struct SingleProcess {
    SingleProcess() {
        // Open MPI: a process that nobody started with mpirun asks no daemon to start others for it, and the only
        // transport is the one from a process to itself. Other libraries do not know the names.
        const Environment alone("OMPI_MCA_ess_singleton_isolated", "1");
        const Environment to_itself("OMPI_MCA_btl", "self");
        MPI_Init(nullptr, nullptr);
    }
    ~SingleProcess() {
        int ended = 0;
        MPI_Finalized(&ended);
        if (!ended)
            MPI_Finalize();
    }
};

} // namespace

void start_mpi_in_one_process() {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    int is_running = 0;
    MPI_Initialized(&is_running);
    if (is_running)
        return;
    static const SingleProcess session;
}

#else

void start_mpi_in_one_process() {}

#endif

} // namespace livermark::support
