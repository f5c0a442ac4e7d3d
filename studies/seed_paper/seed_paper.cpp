#include "studies/seed_paper/seed_paper.hpp"

#include <cmath>
#include <fmt/format.h>

namespace livermark::studies {

namespace {

constexpr Unit newton_per_metre{"N/m", {0, 1, -2}, 1.0};
constexpr Unit newton_second_per_metre{"N s/m", {0, 1, -1}, 1.0};

/// Livers hold 1505 +- 385 mL.
constexpr double liver_volume = 1.505e-3;
constexpr double liver_volume_deviation = 0.385e-3;
/// What is farther from the mean than this many standard deviations is no liver.
constexpr double most_deviations = 2.0;
/// Nearer than this factor a number is said to be that of the body.
constexpr double near_factor = 1.25;
constexpr double litre = 1e-3;

bool is_near(double ratio) {
    return ratio > 1.0 / near_factor && ratio < near_factor;
}

double printed_for(const PrintedQuantity &quantity, const BodyParameters &body) {
    return body.tumour_volume > 0.0 ? quantity.with_tumours : quantity.without_tumours;
}

Claim mass_claim(const BodyParameters &body) {
    const double printed = printed_for(printed_mass, body);
    const double density = body.node_mass.sum / body.volume;
    const double volume = printed / density;
    const double deviations = std::abs(volume - liver_volume) / liver_volume_deviation;
    Claim claim{&printed_mass, printed, {{"mass of the body [kg]", printed, body.node_mass.sum}}, {}};
    if (deviations > most_deviations)
        claim.objection =
            fmt::format("At this body's mean density of {:.0f} kg/m^3 it would fill {:.2f} L, {:.1f} "
                        "standard deviations from the {:.3f} +- {:.3f} L of adult livers",
                        density, volume / litre, deviations, liver_volume / litre, liver_volume_deviation / litre);
    if (body.tumour_volume > 0.0) {
        const double gain = printed_mass.with_tumours - printed_mass.without_tumours;
        const double needed = gain / body.tumour_volume;
        if (!is_near(needed / density))
            claim.objection +=
                fmt::format("{}the {:.2f} kg by which the two printed masses differ, put into the {:.3f} L of these "
                            "tumours, would be {:.0f} kg/m^3",
                            claim.objection.empty() ? "" : "; ", gain, body.tumour_volume / litre, needed);
    }
    return claim;
}

/// Two faults can be found: a unit that is not the one of the quantity, and no reading that is near the body's number.
std::string objection_to(const Claim &claim, const char *what, const Unit &proper) {
    std::string objection;
    const Unit &unit = claim.quantity->unit;
    if (unit.dimension != proper.dimension)
        objection = fmt::format("{} is in {}, which is another dimension than {}", what, proper.name, unit.name);
    std::string near;
    for (const auto &reading : claim.readings)
        if (is_near(reading.ratio()))
            near +=
                fmt::format("{}{} ({:.3f} times it)", near.empty() ? "" : " and ", reading.meaning, reading.ratio());
    if (near.empty())
        return fmt::format("{}{}none of these readings is within a factor of {} of what this body has", objection,
                           objection.empty() ? "" : "; ", near_factor);
    return objection.empty() ? objection : fmt::format("{}; as a number it is near the {}", objection, near);
}

Claim stiffness_claim(const BodyParameters &body) {
    const double printed = printed_for(printed_stiffness, body);
    const double kilo = 1e3;
    Claim claim{&printed_stiffness,
                printed,
                {{"mean spring stiffness, read as N/m", printed, body.stiffness.mean},
                 {"mean spring stiffness, read as kN/m", kilo * printed, body.stiffness.mean},
                 {"sum of all spring stiffnesses, read as kN/m", kilo * printed, body.stiffness.sum},
                 {"mean Young's modulus that goes into the springs, read as kPa",
                  printed_stiffness.unit.in_si * printed, body.mean_young_modulus}},
                {}};
    claim.objection = objection_to(claim, "A spring stiffness", newton_per_metre);
    return claim;
}

Claim damping_claim(const BodyParameters &body) {
    const double printed = printed_for(printed_damping, body);
    Claim claim{&printed_damping, printed, {}, {}};
    const auto add = [&](const char *meaning, double computed) {
        if (computed > 0.0)
            claim.readings.push_back({meaning, printed, computed});
    };
    add("mean dashpot of a spring, read as N s/m", body.dashpot.mean);
    add("sum of all dashpots, read as N s/m", body.dashpot.sum);
    add("mean mass damper of a node, read as N s/m", body.ground_damper.mean);
    add("sum of all mass dampers, read as N s/m", body.ground_damper.sum);
    claim.objection = objection_to(claim, "A damping constant", newton_second_per_metre);
    return claim;
}

} // namespace

std::vector<Claim> compare_with_paper(const BodyParameters &body) {
    return {mass_claim(body), stiffness_claim(body), damping_claim(body)};
}

} // namespace livermark::studies
