#include "fem_reference/mpi_session.hpp"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace livermark::fem_reference {

namespace {

bool mpi_runs() {
    return dealii::Utilities::MPI::job_supports_mpi();
}

} // namespace

bool started_on_many_ranks() {
    constexpr std::array sizes{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_SIZE"};
    return std::ranges::any_of(sizes, [](const char *name) {
        const char *size = std::getenv(name);
        return size && std::atoi(size) > 1;
    });
}

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
    for (const auto &text : dealii::Utilities::MPI::all_gather(MPI_COMM_WORLD, mine))
        if (!text.empty())
            return text;
    return {};
}

} // namespace livermark::fem_reference
