/// What programs on several MPI ranks have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <functional>

#include "support/input_error.hpp"
#include "support/processes/mpi_session.hpp"

namespace livermark::benchmarks {

/// Reads the command line, and does something on every rank. What is refused is said once, because every rank reads the
/// same files.
/// @return exit status
inline int on_ranks(const char *program, CLI::App &app, int argc, char **argv, const std::function<void()> &run) {
    CLI11_PARSE(app, argc, argv);
    const support::MpiSession session;
    try {
        run();
        return 0;
    } catch (const support::InputError &fault) {
        if (support::mpi_rank() == 0)
            fmt::print(stderr, "{}: {}\n", program, fault.what());
        return 2;
    }
}

} // namespace livermark::benchmarks
