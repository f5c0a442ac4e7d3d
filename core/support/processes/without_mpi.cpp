#include <cstdio>
#include <cstdlib>

#include "core/support/input_error.hpp"
#include "core/support/processes/mpi_session.hpp"

/// A build without MPI: one process, which is the only rank.
namespace livermark::support {

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

} // namespace livermark::support
