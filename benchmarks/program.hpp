#pragma once

#include <functional>

namespace livermark::benchmarks {

/// The main function of a benchmark program: says on the terminal and in the output of --benchmark_out which machine,
/// compiler and commit were at work, and runs what is asked for.
/// @param register_all  registers the benchmarks
/// @return exit status: 0, 1 if one of them failed or could not be made, 2 for arguments that nobody knows
int run_program(int argc, char **argv, const std::function<void()> &register_all);

} // namespace livermark::benchmarks
