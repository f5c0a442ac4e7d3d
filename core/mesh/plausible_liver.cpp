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

std::optional<std::pair<std::size_t, std::size_t>> apart_by_faces(std::span<const std::array<int, 4>> tetrahedra) {
    const auto part = parts_by_faces(tetrahedra);
    const auto other = std::ranges::find_if(part, [](int number) { return number != 0; });
    if (other != part.end())
        return std::pair(std::size_t{0}, static_cast<std::size_t>(other - part.begin()));
    return std::nullopt;
}

} // namespace livermark::core
