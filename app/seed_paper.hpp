#pragma once

#include <string>
#include <vector>

#include "app/body_parameters.hpp"

/// Table 1 of "Integrating biomechanical parameters in modeling of liver with and without tumor in virtual
/// environment", Jurnal Teknologi 75, 10.11113/jt.v75.5068, against what is computed. Nothing depends on its numbers
/// but what is said about them.
namespace livermark::app {

/// Powers of metre, kilogram and second.
struct Dimension {
    int metre = 0;
    int kilogram = 0;
    int second = 0;
    bool operator==(const Dimension &) const = default;
};

struct Unit {
    const char *name;
    Dimension dimension;
    double in_si;
};

/// A row of the paper's table.
struct PrintedQuantity {
    const char *name;
    Unit unit;
    double without_tumours; ///< in that unit
    double with_tumours;
};

inline constexpr PrintedQuantity printed_mass{"mass", {"kg", {0, 1, 0}, 1.0}, 1.9825, 5.9256};
inline constexpr PrintedQuantity printed_stiffness{"stiffness", {"kPa", {-1, 1, -2}, 1e3}, 5.4225, 7.0484};
inline constexpr PrintedQuantity printed_damping{"damping", {"N/m^2", {-1, 1, -2}, 1.0}, 7.4525, 11.9012};

/// A number that a printed one could stand for.
struct Reading {
    std::string meaning;   ///< with its unit
    double printed = 0.0;  ///< the printed number, read in that unit [SI]
    double computed = 0.0; ///< what the body has [SI]

    double ratio() const { return printed / computed; }
};

/// A printed number beside all that it could stand for, and a sentence if it does not follow.
struct Claim {
    const PrintedQuantity *quantity;
    double printed = 0.0; ///< in the unit of the quantity
    std::vector<Reading> readings;
    std::string objection; ///< empty if it follows
};

/// The rows of the paper's table, held against a body: the column with tumours for a body that has some.
std::vector<Claim> hold_against_paper(const BodyParameters &body);

} // namespace livermark::app
