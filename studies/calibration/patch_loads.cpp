#include "studies/calibration/patch_loads.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <random>

#include "load_cases/places/facets.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

using core::Vector3;

constexpr double smallest_radius = 0.015;
constexpr double largest_radius = 0.030;
constexpr double least_cosine = 0.5;

/// The distributions of the standard library differ from one library to the next.
class Random {
  public:
    explicit Random(std::int64_t seed) : generator_(static_cast<std::uint64_t>(seed)) {}

    /// In [0, 1)
    double uniform() { return 0x1p-53 * static_cast<double>(generator_() >> 11U); }

    /// Every direction alike: a point of the ball, by rejection.
    Vector3 direction() {
        while (true) {
            Vector3 point;
            for (int c = 0; c < 3; ++c)
                point[c] = 2.0 * uniform() - 1.0;
            if (point.norm() <= 1.0 && point.norm() > 0.1)
                return point.normalized();
        }
    }

  private:
    std::mt19937_64 generator_;
};

core::LoadCase constrained_only(const core::TetraMesh &mesh, int patch) {
    std::vector<int> held;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (mesh.boundary_patch[f] == patch)
            held.push_back(f);
    auto load_case = core::with_free_surface({}, mesh);
    load_case.put({mesh.patch_names[patch]}, held, Vector3::Zero());
    return load_case;
}

} // namespace

std::vector<core::LoadCase> random_patch_loads(const core::TetraMesh &mesh, const std::string &constrained, int count,
                                               std::int64_t seed) {
    const auto found = std::ranges::find(mesh.patch_names, constrained);
    if (found == mesh.patch_names.end())
        throw support::InputError(
            fmt::format("the body has no patch '{}' to constrain; choose with --constrained among {}", constrained,
                        fmt::join(mesh.patch_names, ", ")));
    const auto at_rest = constrained_only(mesh, static_cast<int>(found - mesh.patch_names.begin()));
    std::vector<int> free;
    for (int f = 0; f < mesh.num_boundary_triangles(); ++f)
        if (at_rest.is_free(f))
            free.push_back(f);
    if (free.empty())
        throw support::InputError(fmt::format("all of the surface belongs to patch '{}'; constrain a smaller one "
                                              "with --constrained",
                                              constrained));
    Random random(seed);
    std::vector<core::LoadCase> loads;
    for (int l = 0; l < count; ++l) {
        auto load_case = at_rest;
        load_case.name = fmt::format("disc_{}", l);
        const int middle = free[static_cast<std::size_t>(random.uniform() * static_cast<double>(free.size()))];
        const Vector3 centre = load_cases::facet_centroid(mesh, middle);
        const Vector3 normal = area_vector(mesh, middle).normalized();
        const double radius = smallest_radius + (largest_radius - smallest_radius) * random.uniform();
        const Vector3 traction = random.direction();
        std::vector<int> disc;
        std::ranges::copy_if(free, std::back_inserter(disc), [&](int f) {
            return (load_cases::facet_centroid(mesh, f) - centre).norm() <= radius &&
                   area_vector(mesh, f).normalized().dot(normal) >= least_cosine;
        });
        load_case.put({load_case.name, core::ConditionKind::traction}, disc, traction);
        loads.push_back(std::move(load_case));
    }
    return loads;
}

} // namespace livermark::studies
