#pragma once

#include <string>

namespace livermark::meshes {

/// More have no place in a benchmark: references are solved on eight times as many.
inline constexpr double most_tetrahedra = 2e6;

/// Number of regular tetrahedra that fill a volume. Meshes have about as many: body-centred lattices 11 % more, those
/// of Kuhn half as many again.
/// @param side_of_cube  of the same volume [m], which a number holds where it does not hold the volume
/// @param edge_length   [m]
double expected_tetrahedra(double side_of_cube, double edge_length);

/// The same in words, with two digits: "about 16000 tetrahedra".
std::string text_of_expected_tetrahedra(double expected);

/// Refuses a mesh before it is made, which may take hours and all of the memory.
/// @param what  "a box of 0.1 x 0.2 x 0.1 m"
/// @throws support::InputError if more than most_tetrahedra are expected
void check_number_of_tetrahedra(const std::string &what, double side_of_cube, double edge_length);

} // namespace livermark::meshes
