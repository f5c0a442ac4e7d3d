#pragma once

#include <arpack/arpack.hpp>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"

namespace livermark::tests {

/// The lowest angular frequencies of K phi = omega^2 M phi [rad/s] by ARPACK, ascending: another program than the one
/// under test for all but the factor of K. Its mode 3, about zero, on all unknowns; where one is prescribed K^-1 gives
/// zero, so that nothing but the free ones takes part.
/// (Lehoucq, Sorensen, Yang 1998, ARPACK Users' Guide, sections 2.4 and 3.2)
inline std::vector<double> arpack_frequencies(const fem_reference::SymmetricMatrix &stiffness,
                                              const fem_reference::SymmetricMatrix &mass,
                                              const std::vector<double> &prescribed, int count) {
    fem_reference::ConstrainedSolver solver(stiffness);
    solver.factorise(prescribed);
    const int size = static_cast<int>(prescribed.size());
    const int num_vectors = 2 * count + 20;
    std::vector<double> start(size), vectors(static_cast<std::size_t>(size) * num_vectors), work(3 * prescribed.size());
    const int small_work_size = num_vectors * (num_vectors + 8);
    std::vector<double> small_work(small_work_size), image(prescribed.size());
    for (int i = 0; i < size; ++i)
        start[i] = std::isnan(prescribed[i]) ? std::cos(1.0 + i) : 0.0; // any that favours no mode
    int parameters[11] = {1, 0, 1000, 1, 0, 0, 3, 0, 0, 0, 0};
    int pointers[11] = {};
    int request = 0;
    int info = 1; // the start is given
    const auto slot = [&](int pointer) { return std::span(work).subspan(pointers[pointer] - 1, prescribed.size()); };
    for (;;) {
        arpack::saupd(request, arpack::bmat::generalized, size, arpack::which::largest_magnitude, count, 1e-13,
                      start.data(), num_vectors, vectors.data(), size, parameters, pointers, work.data(),
                      small_work.data(), small_work_size, info);
        if (request == -1) {
            fem_reference::multiply_mass(mass, slot(0), image);
            solver.solve_constrained(image, slot(1));
        } else if (request == 1)
            solver.solve_constrained(slot(2), slot(1)); // the mass times the vector is there
        else if (request == 2)
            fem_reference::multiply_mass(mass, slot(0), slot(1));
        else
            break;
    }
    if (info != 0 || parameters[4] < count)
        throw std::runtime_error("ARPACK's saupd stopped with info " + std::to_string(info));
    std::vector<int> select(num_vectors);
    std::vector<double> squares(count);
    arpack::seupd(0, arpack::howmny::ritz_vectors, select.data(), squares.data(), vectors.data(), size, 0.0,
                  arpack::bmat::generalized, size, arpack::which::largest_magnitude, count, 1e-13, start.data(),
                  num_vectors, vectors.data(), size, parameters, pointers, work.data(), small_work.data(),
                  small_work_size, info);
    if (info != 0)
        throw std::runtime_error("ARPACK's seupd stopped with info " + std::to_string(info));
    std::ranges::sort(squares);
    for (double &square : squares)
        square = std::sqrt(square);
    return squares;
}

} // namespace livermark::tests
