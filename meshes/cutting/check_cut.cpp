#include "meshes/cutting/check_cut.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <utility>

#include "core/mesh/bounding_box.hpp"

namespace livermark::meshes {

namespace {

[[noreturn]] void refuse_tool(const Cut &cut, const std::string &what, const std::string &remedy) {
    throw support::InputError(fmt::format("{}: {}; {}", cut.place, what, remedy));
}

void refuse_infinite(std::span<const core::Vector3> points, const Cut &cut) {
    if (!std::ranges::all_of(points, [](const core::Vector3 &point) { return point.allFinite(); }))
        refuse_tool(cut, "a coordinate is not finite", "correct it");
}

void check_blade(const BladeCut &blade, const Cut &cut) {
    refuse_infinite(blade.corners, cut);
    if (!(blade.thickness >= 0.0) || !std::isfinite(blade.thickness))
        refuse_tool(cut, fmt::format("the blade has a thickness of {} m", blade.thickness), "give 0 or more");
    const auto &[a, b, c, d] = blade.corners;
    const core::Vector3 first = (b - a).cross(c - a), second = (c - a).cross(d - a);
    const double size = core::extent(blade.corners);
    constexpr double flat = 1e-6;
    if (!(std::min(first.norm(), second.norm()) > flat * size * size) || !(first.dot(second) > 0.0))
        refuse_tool(cut, "the corners of the blade do not form a quadrilateral", "give four in turn, not on one line");
}

} // namespace

CutNotOnBody::CutNotOnBody(const std::string &place, std::string reason, std::string remedy)
    : InputError(fmt::format("{}: {}; {}", place, reason, remedy)), place_(place), reason_(std::move(reason)),
      remedy_(std::move(remedy)) {}

void check_cut(const Cut &cut, const core::TetraMesh &mesh) {
    const auto &names = mesh.region_names;
    if (const auto *region = std::get_if<RegionCut>(&cut.tool)) {
        if (!(region->margin >= 0.0) || !std::isfinite(region->margin))
            refuse_tool(cut, fmt::format("the margin is {} m", region->margin), "give 0 or more");
        if (std::ranges::find(names, region->region) == names.end())
            throw CutNotOnBody(cut.place, fmt::format("the body has no region '{}'", region->region),
                               fmt::format("it has {}", fmt::join(names, ", ")));
    } else if (const auto *half_space = std::get_if<HalfSpaceCut>(&cut.tool)) {
        refuse_infinite(std::array{half_space->point, half_space->normal}, cut);
        if (!(half_space->normal.norm() > 0.0))
            refuse_tool(cut, "the normal of the plane is zero", "give one that points to what is taken away");
    } else {
        check_blade(std::get<BladeCut>(cut.tool), cut);
    }
}

} // namespace livermark::meshes
