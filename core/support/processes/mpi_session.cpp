#include "core/support/processes/mpi_session.hpp"

#include <deal.II/base/mpi.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace livermark::support {

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

} // namespace livermark::support
