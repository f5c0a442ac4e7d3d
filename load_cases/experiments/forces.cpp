#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/ranges.h>
#include <functional>
#include <iterator>
#include <limits>
#include <span>
#include <utility>

#include "core/support/input_error.hpp"
#include "core/units.hpp"
#include "load_cases/experiments/experiment.hpp"
#include "load_cases/experiments/markers.hpp"

namespace livermark::experiments {

namespace {

using core::Vector3;

/// Direction in which a place is moved: that of the mean prescribed displacement, or of the tool that touches.
Vector3 direction_of(const core::LoadCase &load_case, int constraint) {
    for (const auto &contact : load_case.contacts())
        if (contact.constraint == constraint)
            return contact.press.normalized();
    Vector3 sum = Vector3::Zero();
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == constraint)
            for (int i = 0; i < 3; ++i)
                if (std::isfinite(load_case.value[f][i]))
                    sum[i] += load_case.value[f][i];
    return sum.normalized();
}

int constraint_of(const MeasuredForce &measured, const core::LoadCase &load_case) {
    const auto names = load_case.constraint_names();
    return static_cast<int>(std::ranges::find(names, measured.place) - names.begin());
}

} // namespace

MeasuredForce read_force_table(const std::filesystem::path &file, double metres_per_unit, std::vector<double> at) {
    constexpr const char *header = "way,force,deviation";
    const auto rows = read_csv(file);
    if (rows.size() < 2 || rows.front().cells != std::vector<std::string>{"way", "force", "deviation"})
        throw support::InputError("{}: a table of forces has the first line {}, and lines of three numbers; correct it",
                                  file.string(), header);
    std::vector<std::array<double, 3>> points; // way [m], force and deviation [N]
    for (const auto &row : std::span(rows).subspan(1)) {
        if (row.cells.size() != 3)
            throw support::InputError("{}: the line has {} cells and not 3; correct it", row.place, row.cells.size());
        const std::array point{metres_per_unit * number_in(row, 0), number_in(row, 1), number_in(row, 2)};
        if (!points.empty() && !(point[0] > points.back()[0]))
            throw support::InputError("{}: the way does not grow; sort the lines by it", row.place);
        points.push_back(point);
    }
    constexpr double rounding = 1e-9;
    MeasuredForce measured{.place = {}, .way = std::move(at), .force = {}, .deviation = {}};
    for (const double wanted : measured.way) {
        const auto after =
            std::ranges::lower_bound(points, wanted * (1.0 - rounding), {}, [](const auto &point) { return point[0]; });
        if (after == points.end() || (after == points.begin() && (*after)[0] > wanted * (1.0 + rounding)))
            throw support::InputError("{}: the table goes from {:g} to {:g} mm, and the force at {:g} mm is asked for; "
                                      "change fit_at or compare_at, or the unit",
                                      file.string(), core::millimetres * points.front()[0],
                                      core::millimetres * points.back()[0], core::millimetres * wanted);
        const auto before = after == points.begin() ? after : std::prev(after);
        const double part =
            after == before ? 1.0 : std::clamp((wanted - (*before)[0]) / ((*after)[0] - (*before)[0]), 0.0, 1.0);
        measured.force.push_back(std::lerp((*before)[1], (*after)[1], part));
        measured.deviation.push_back(std::lerp((*before)[2], (*after)[2], part));
    }
    return measured;
}

std::vector<double> force_along_way(const MeasuredForce &measured, const core::LoadCase &load_case,
                                    const core::Solution &solution) {
    std::vector<double> found(measured.way.size(), std::numeric_limits<double>::quiet_NaN());
    const int constraint = constraint_of(measured, load_case);
    const auto direction = direction_of(load_case, constraint);
    for (std::size_t j = 0; j < std::min(found.size(), solution.path.size()); ++j)
        found[j] = measured.parts * solution.path[j].reaction[constraint].dot(direction);
    return found;
}

std::vector<double> uniform_force(const MeasuredForce &measured, const core::LoadCase &load_case,
                                  const core::TetraMesh &mesh) {
    if (!(measured.length > 0.0))
        return {};
    const auto constraint = constraint_of(measured, load_case);
    const auto direction = direction_of(load_case, constraint);
    double outward = 0.0;
    for (int f = 0; f < load_case.num_facets(); ++f)
        if (load_case.constraint_on(f) == constraint)
            outward += direction.dot(core::area_vector(mesh, f));
    const double sign = outward > 0.0 ? 1.0 : -1.0; // a tool that touches has no facets, and presses
    std::vector<double> found;
    for (const double way : measured.way) {
        const double part = 1.0 + sign * way / measured.length;
        found.push_back(std::abs(1.0 / (part * part) - part) / 3.0);
    }
    return found;
}

void check_force(const MeasuredForce &measured, const core::LoadCase &load_case, const std::string &place) {
    const auto refuse = [&](const std::string &what) {
        throw support::InputError("{}: state {}: {}", place, load_case.name, what);
    };
    if (load_case.regime != core::Regime::large)
        refuse("a force is measured along a path, which only the large regime has; leave the regime out");
    const auto names = load_case.constraint_names();
    if (std::ranges::find(names, measured.place) == names.end())
        refuse(fmt::format("the force of '{}' is asked for, and no such place is held or moved; take one of {}",
                           support::shown(measured.place), fmt::join(names, ", ")));
    if (measured.way.size() < 2 || !(measured.way.front() > 0.0) ||
        !std::ranges::is_sorted(measured.way, std::less_equal<>()))
        refuse("a force is fitted at one way and compared at longer ones; let fit_at be positive and less than all of "
               "compare_at, which ascend");
    for (std::size_t j = 0; j < measured.way.size(); ++j)
        if (!(measured.force[j] > 0.0) || !(measured.deviation[j] >= 0.0) || !std::isfinite(measured.force[j]) ||
            !std::isfinite(measured.deviation[j]))
            refuse(
                fmt::format("at {:g} mm the force is {:g} N and its deviation {:g} N; the first has to be positive and "
                            "the other 0 or more",
                            core::millimetres * measured.way[j], measured.force[j], measured.deviation[j]));
    if (!(measured.length >= 0.0) || (measured.length > 0.0 && !(measured.way.back() < 10.0 * measured.length)))
        refuse("the body is moved by more than ten of its lengths; check 'length' and the unit");
    if (!(measured.parts >= 1.0))
        refuse(fmt::format("the body is one of {:g} parts; give 1 or more", measured.parts));
}

} // namespace livermark::experiments
