#include "studies/seed_paper/table_1_readings.hpp"

#include <array>
#include <cmath>
#include <fmt/format.h>

#include "studies/seed_paper/table_1.hpp"

namespace livermark::studies {

namespace {

struct PrintedRow {
    const char *name;
    const char *title;
    double mass, stiffness, damping; // as printed
};

constexpr std::array table_1{PrintedRow{"without_tumour", "without tumour", printed_mass.without_tumours,
                                        printed_stiffness.without_tumours, printed_damping.without_tumours},
                             PrintedRow{"with_tumour", "with tumour", printed_mass.with_tumours,
                                        printed_stiffness.with_tumours, printed_damping.with_tumours}};

constexpr double kilo = 1000.0;
/// Of an adult liver [m^3]; the edge of a cube of it makes a stiffness of a modulus and a dashpot of a viscosity.
constexpr double liver_volume_of_table_1 = 1.5e-3;

struct TableReading {
    const char *name;
    const char *title;
    double stiffness;        // what 1 printed is [N/m]
    double damping;          // what 1 printed is [N s/m]
    double damping_per_mass; // and per kilogram of m [N s/m]
};

std::vector<TableReading> readings() {
    const double edge = std::cbrt(liver_volume_of_table_1);
    return {{"as_printed", "k in N/m, b in N s/m", 1.0, 1.0, 0.0},
            {"stiffness_in_kilo", "k in kN/m, b in N s/m", kilo, 1.0, 0.0},
            {"both_in_kilo", "k in kN/m, b in kN s/m", kilo, kilo, 0.0},
            {"modulus_and_viscosity", "k in kPa, b in Pa s, times 0.114 m", kilo * edge, edge, 0.0},
            {"damping_per_mass", "k in N/m, b / m in 1/s", 1.0, 0.0, 1.0},
            {"stiffness_in_kilo_damping_per_mass", "k in kN/m, b / m in 1/s", kilo, 0.0, 1.0}};
}

} // namespace

std::vector<OneDegreeOfFreedom> readings_of_table_1() {
    std::vector<OneDegreeOfFreedom> all;
    for (const auto &reading : readings())
        for (const auto &row : table_1)
            all.push_back({.name = fmt::format("{}_{}", reading.name, row.name),
                           .title = fmt::format("{}: {}", row.title, reading.title),
                           .mass = row.mass,
                           .stiffness = reading.stiffness * row.stiffness,
                           .damping = (reading.damping + reading.damping_per_mass * row.mass) * row.damping});
    return all;
}

} // namespace livermark::studies
