#pragma once

/// Table 1 of "Integrating biomechanical parameters in modeling of liver with and without tumor in virtual
/// environment", Jurnal Teknologi 75, 10.11113/jt.v75.5068, as it is printed. Nothing depends on its numbers but what
/// is said about them.
namespace livermark::studies {

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

} // namespace livermark::studies
