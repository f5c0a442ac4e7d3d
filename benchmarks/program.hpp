#pragma once

#include <functional>

namespace livermark::benchmarks {

/// The main function of a benchmark program, with all flags of Google Benchmark: says which machine, compiler and
/// commit were at work, and runs what is asked for. What --benchmark_format asks for is all that goes to standard
/// output. With
/// --hdf5=FILE it also writes the timing file of results/schema.md.
/// @param register_all  registers the benchmarks
/// @return exit status: 0, 1 if one of them refused a solution or could not be made, 2 for wrong arguments
int run_program(int argc, char **argv, const std::function<void()> &register_all);

} // namespace livermark::benchmarks
