#include "core/mesh/plausible_liver.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>
#include <utility>

#include "core/mesh/bounding_box.hpp"
#include "core/mesh/parts_by_faces.hpp"
#include "core/mesh/segment_names.hpp"

namespace livermark::core {

namespace {

/// Of all tetrahedra, and of each region with the name of a lesion [m^3].
struct LiverVolumes {
    double all = 0.0;
    std::vector<double> lesions;
};

LiverVolumes liver_volumes(const TetraMesh &mesh) {
    const auto volumes = tetrahedron_volumes(mesh);
    std::vector<double> of_region(mesh.region_names.size(), 0.0);
    for (std::size_t t = 0; t < volumes.size(); ++t)
        of_region[static_cast<std::size_t>(mesh.region[t])] += volumes[t];
    LiverVolumes result{std::accumulate(of_region.begin(), of_region.end(), 0.0), {}};
    for (std::size_t r = 0; r < of_region.size(); ++r)
        if (role_of_name(mesh.region_names[r]) == SegmentRole::lesion)
            result.lesions.push_back(of_region[r]);
    return result;
}

std::vector<std::string> doubts_about_share(const LiverVolumes &volumes) {
    const double of_lesions = std::accumulate(volumes.lesions.begin(), volumes.lesions.end(), 0.0);
    if (!(of_lesions > 0.5 * volumes.all))
        return {};
    return {fmt::format("lesions are {:.0f} % of the body, more than the liver around them; check whether liver and "
                        "lesions have been exchanged",
                        100.0 * of_lesions / volumes.all)};
}

} // namespace

std::vector<std::string> doubts_about_liver(double volume, std::span<const double> lesions) {
    constexpr double litres_per_cubic_metre = 1e3;
    std::vector<std::string> doubts;
    const double litres = litres_per_cubic_metre * volume;
    if (!(litres >= smallest_liver && litres <= largest_liver))
        doubts.push_back(fmt::format("the body has {:.2g} L, where an adult liver has {} to {} L; check its lengths, "
                                     "and whether it is a whole liver",
                                     litres, smallest_liver, largest_liver));
    for (auto &doubt : doubts_about_share({volume, {lesions.begin(), lesions.end()}}))
        doubts.push_back(std::move(doubt));
    return doubts;
}

std::vector<std::string> doubts_about_liver(const TetraMesh &mesh) {
    const auto volumes = liver_volumes(mesh);
    return doubts_about_liver(volumes.all, volumes.lesions);
}

std::vector<std::string> doubts_about_lesions(const TetraMesh &mesh) {
    return doubts_about_share(liver_volumes(mesh));
}

std::vector<std::string> doubts_about_unit(const std::vector<Vector3> &points) {
    constexpr double smallest_sample = 1e-3; // [m]
    constexpr double most_litres = 1000.0;   // of the box around it
    const Vector3 sides = bounding_box(points).sizes();
    const double longest = sides.maxCoeff(), litres = 1e3 * sides.prod();
    if (longest > largest_organ)
        return {fmt::format("the longest side is {:.4g} m, which fits no organ; check whether the lengths are in mm",
                            longest)};
    if (longest < smallest_sample)
        return {fmt::format(
            "the longest side is {:.4g} m, which fits no organ; check whether the lengths are in m already", longest)};
    if (litres > most_litres)
        return {fmt::format("the box around it holds {:.4g} L, which fits no organ; check the unit of the lengths",
                            litres)};
    return {};
}

std::vector<std::string> doubts_about_materials(std::span<const Material> materials,
                                                std::span<const std::string> names) {
    constexpr double lightest = 100.0, heaviest = 5000.0; // [kg/m^3] a lung, and more than tooth
    constexpr double softest = 50.0, stiffest = 1e8;      // [Pa] softer gels flow, and silicones are far below
    std::vector<std::string> doubts;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        const auto &[density, modulus, ratio] = materials[m];
        if (!(density >= lightest && density <= heaviest))
            doubts.push_back(
                fmt::format("region '{}' has a density of {:g} kg/m^3, which fits no tissue; check whether "
                            "it is in kg/m^3, in which water has 1000",
                            names[m], density));
        if (!(modulus >= softest && modulus <= stiffest))
            doubts.push_back(fmt::format("region '{}' has a Young's modulus of {:g} Pa, which fits no tissue; check "
                                         "whether it is in Pa, in which a liver has some thousands",
                                         names[m], modulus));
    }
    return doubts;
}

std::vector<std::string> doubts_about_loads(const LoadCase &load_case, const TetraMesh &mesh) {
    constexpr double largest_traction = 1e6, largest_force = 1e3; // [Pa] and [N]
    constexpr double largest_acceleration = 1e3;                  // [m/s^2]
    if (load_case.scale_to_target)
        return {};
    struct Sums {
        double traction = 0.0, displacement = 0.0; ///< the largest [Pa, m]
        Vector3 force = Vector3::Zero();           ///< [N]
    };
    std::vector<Sums> of_place(load_case.conditions.size());
    for (int f = 0; f < load_case.num_facets(); ++f) {
        if (load_case.is_free(f) || load_case.presses(f))
            continue;
        auto &sums = of_place[static_cast<std::size_t>(load_case.condition_on[f])];
        const Vector3 value = load_case.value[f].array().isNaN().select(0.0, load_case.value[f].array()).matrix();
        if (load_case.is_constrained(f)) {
            sums.displacement = std::max(sums.displacement, value.norm());
        } else {
            sums.traction = std::max(sums.traction, value.norm());
            sums.force += area_vector(mesh, f).norm() * value;
        }
    }
    const double size = bounding_box(mesh.points).diagonal().norm();
    std::vector<std::string> doubts;
    const auto doubt = [&](const std::string &place, const std::string &what, const char *unit) {
        doubts.push_back(
            fmt::format("{}: '{}' has {}; check the number, which is in {}", load_case.name, place, what, unit));
    };
    for (std::size_t c = 0; c < of_place.size(); ++c) {
        const auto &place = load_case.conditions[c].place;
        const auto &sums = of_place[c];
        if (sums.traction > largest_traction)
            doubt(place,
                  fmt::format("a traction of {:.3g} Pa, where no instrument exerts more than {:g} Pa on tissue",
                              sums.traction, largest_traction),
                  "Pa");
        else if (sums.force.norm() > largest_force)
            doubt(place, fmt::format("a force of {:.3g} N, more than a hand exerts", sums.force.norm()), "N");
        if (sums.displacement > size)
            doubt(place,
                  fmt::format("a displacement of {:.3g} m, and the body is {:.3g} m across", sums.displacement, size),
                  "m unless the load case says its 'unit'");
    }
    if (load_case.press_depth > size)
        doubt("press", fmt::format("a depth of {:.3g} m, and the body is {:.3g} m across", load_case.press_depth, size),
              "m unless the load case says its 'unit'");
    if (load_case.acceleration.norm() > largest_acceleration)
        doubt("acceleration",
              fmt::format("{:.3g} m/s^2, more than a hundred times gravity", load_case.acceleration.norm()), "m/s^2");
    return doubts;
}

std::vector<std::string> doubts_about_noise(double noise, double largest) {
    constexpr double worst_camera = 0.01; // [m]
    if (!(noise > std::min(worst_camera, largest)))
        return {};
    return {
        fmt::format("the noise is {:g} m, and the largest displacement that was measured is {:.3g} m; check whether "
                    "the noise is in m",
                    noise, largest)};
}

std::optional<std::pair<std::size_t, std::size_t>> apart_by_faces(std::span<const std::array<int, 4>> tetrahedra) {
    const auto part = parts_by_faces(tetrahedra);
    const auto other = std::ranges::find_if(part, [](int number) { return number != 0; });
    if (other != part.end())
        return std::pair(std::size_t{0}, static_cast<std::size_t>(other - part.begin()));
    return std::nullopt;
}

} // namespace livermark::core
