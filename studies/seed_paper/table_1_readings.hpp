#pragma once

#include <string>
#include <vector>

namespace livermark::studies {

/// m u'' + b u' + k u = f
struct OneDegreeOfFreedom {
    std::string name;       ///< as in a result file
    std::string title;      ///< liver, and how the numbers are read
    double mass = 0.0;      ///< m [kg]
    double stiffness = 0.0; ///< k [N/m]
    double damping = 0.0;   ///< b [N s/m]
};

/// Table 1 of Jurnal Teknologi 75, 10.11113/jt.v75.5068 (mass in kg, stiffness in "kPa", damping in "N/m^2"; a liver
/// without and with tumours) put into its equation 1. Neither unit is that of k or b, so each is read in every way that
/// gives one.
std::vector<OneDegreeOfFreedom> readings_of_table_1();

} // namespace livermark::studies
