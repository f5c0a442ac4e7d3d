#include "core/support/processes/mpi_session.hpp"

#include <deal.II/base/config.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <optional>
#include <string>

#ifdef DEAL_II_WITH_MPI
#include <deal.II/base/mpi.h>
#endif

#include "core/support/input_error.hpp"

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
        // transport is the one from a process to itself. Nor does it make a folder for those processes, which one
        // that ends takes away from another that starts. Other libraries do not know the names.
        const Environment alone("OMPI_MCA_ess_singleton_isolated", "1");
        const Environment to_itself("OMPI_MCA_btl", "self");
        const Environment without_folder("OMPI_MCA_orte_create_session_dirs", "0");
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

#ifdef LIVERMARK_WITHOUT_MPI

// One process, which is the only rank.

struct MpiSession::Impl {};

MpiSession::MpiSession() {
    throw InputError("this program was built without MPI; start it without mpirun, or build it with "
                     "-DLIVERMARK_WITH_MPI=ON");
}
MpiSession::~MpiSession() = default;

int mpi_rank() {
    return 0;
}

int mpi_num_ranks() {
    return 1;
}

std::string first_text_of_ranks(const std::string &mine) {
    return mine;
}

void abort_all_ranks(const std::string &why) {
    std::fprintf(stderr, "livermark: failed: %s\n", why.c_str());
    std::abort();
}

#else

namespace {

bool mpi_runs() {
    return dealii::Utilities::MPI::job_supports_mpi();
}

} // namespace

struct MpiSession::Impl {
    // PETSc, which deal.II starts as well, must not read our command line: it has its own idea of --help.
    int num_arguments = 1;
    std::array<char, 10> program{"livermark"};
    std::array<char *, 2> list{program.data(), nullptr};
    char **arguments = list.data();
    dealii::Utilities::MPI::MPI_InitFinalize mpi{num_arguments, arguments, 1};
};

MpiSession::MpiSession() : impl_(std::make_unique<Impl>()) {}
MpiSession::~MpiSession() = default;

int mpi_rank() {
    return mpi_runs() ? static_cast<int>(dealii::Utilities::MPI::this_mpi_process(MPI_COMM_WORLD)) : 0;
}

int mpi_num_ranks() {
    return mpi_runs() ? static_cast<int>(dealii::Utilities::MPI::n_mpi_processes(MPI_COMM_WORLD)) : 1;
}

std::string first_text_of_ranks(const std::string &mine) {
    if (mpi_num_ranks() == 1)
        return mine;
    const int num_ranks = mpi_num_ranks();
    const int speaker = dealii::Utilities::MPI::min(mine.empty() ? num_ranks : mpi_rank(), MPI_COMM_WORLD);
    if (speaker == num_ranks)
        return {};
    int size = static_cast<int>(mine.size());
    MPI_Bcast(&size, 1, MPI_INT, speaker, MPI_COMM_WORLD);
    std::string text = mine;
    text.resize(size);
    MPI_Bcast(text.data(), size, MPI_CHAR, speaker, MPI_COMM_WORLD);
    return text;
}

void abort_all_ranks(const std::string &why) {
    std::fprintf(stderr, "livermark: failed on rank %d of %d: %s\n", mpi_rank(), mpi_num_ranks(), why.c_str());
    std::fflush(stderr);
    MPI_Abort(MPI_COMM_WORLD, 1);
    std::abort(); // MPI_Abort does not come back
}

#endif

} // namespace livermark::support
