#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <numbers>
#include <vector>

#include "core/mesh/local_refinement.hpp"
#include "fem_reference/hyperelastic/paths/load_path.hpp"
#include "tests/fem_reference/half_space.hpp"
#include "tests/fem_reference/hyperelastic_bodies.hpp"

namespace livermark {

namespace {

using core::Vector3;
using tests::HalfSpace;

/// The quarter of the half-space that is left between two planes of symmetry, cut out near the contact.
struct CutOut {
    HalfSpace space;
    double size; ///< [m] from the contact to the outer faces
    core::Problem problem;

    /// @param size_in_radii  of contact
    /// @param refined_in     radii of contact within which the mesh is refined, again and again
    CutOut(const HalfSpace &of, double size_in_radii, const std::vector<double> &refined_in)
        : space(of), size(size_in_radii * space.contact_radius()) {
        constexpr int bricks = 4;
        auto mesh = tests::box_mesh({size, size, size}, {bricks, bricks, bricks});
        for (auto &point : mesh.points)
            point.z() -= size;
        const auto body = tests::make_body(std::move(mesh), {1000.0, HalfSpace::modulus, space.poisson});
        auto load_case = tests::empty_load_case(body->mesh);
        for (const auto *patch : {"x_min", "x_max", "y_min", "y_max", "z_min"})
            tests::prescribe(load_case, body->mesh, patch, Vector3::Zero());
        load_case.conditions.push_back({"touch", core::ConditionKind::touch});
        load_case.touching = core::TouchingTool{.radius = HalfSpace::ball_radius,
                                                .start = {0.0, 0.0, HalfSpace::ball_radius},
                                                .press = {0.0, 0.0, -HalfSpace::depth},
                                                .constraint = load_case.num_constraints() - 1};
        problem = {body, load_case};
        for (const double radii : refined_in) {
            const core::InteriorPlace contact{Vector3::Zero(), space.contact_radius()};
            problem = core::refine_near_places(problem, std::span(&contact, 1), radii).problem;
        }
    }

    /// Symmetry, and on the outer faces the far field at the whole load.
    fem_reference::DofConditions conditions(const fem_reference::ElasticSystem &system) const {
        fem_reference::DofConditions conditions;
        const auto num_dofs = 3 * system.points.size();
        conditions.prescribed.assign(num_dofs, tests::free_component);
        conditions.constraint.assign(num_dofs, -1);
        conditions.load.assign(num_dofs, 0.0);
        const double rounding = 1e-9 * size;
        for (std::size_t node = 0; node < system.points.size(); ++node) {
            const Vector3 &x = system.points[node];
            const bool is_outer = x.x() > size - rounding || x.y() > size - rounding || x.z() < -size + rounding;
            if (is_outer)
                Vector3::Map(&conditions.prescribed[3 * node]) = space.pressed(space.force(), x);
            if (x.x() < rounding)
                conditions.prescribed[3 * node] = 0.0;
            if (x.y() < rounding)
                conditions.prescribed[3 * node + 1] = 0.0;
        }
        return conditions;
    }
};

struct Found {
    hyperelastic::FollowedPath path;
    std::size_t unknowns;
};

Found solve(const CutOut &cut) {
    const hyperelastic::Elements elements(cut.problem.body, 2, fem_reference::Formulation::displacement,
                                          hyperelastic::material_law("neo_hookean"),
                                          hyperelastic::TetrahedronRule::four_points);
    hyperelastic::TouchingBall ball(elements.system(), *cut.problem.body, cut.problem.load_case);
    const auto conditions = cut.conditions(elements.system());
    return {hyperelastic::follow(elements, conditions, cut.problem.load_case.num_constraints(), {},
                                 {.fractions = {1.0}, .tolerance = 1e-7}, &ball),
            3 * elements.system().points.size()};
}

/// Relative errors of force and radius of contact.
struct HertzErrors {
    double force, radius, radius_by_area;
};

HertzErrors errors_on(const std::vector<double> &refined_in) {
    const HalfSpace space{.poisson = 0.3};
    const CutOut cut(space, 8.0, refined_in);
    const auto [path, unknowns] = solve(cut);
    EXPECT_EQ(path.status, core::SolutionStatus::ok) << path.message;
    if (path.points.empty())
        return {};
    const auto &touch = path.points.back().touch;
    const HertzErrors errors{-4.0 * touch.force.z() / space.force() - 1.0, touch.radius / space.contact_radius() - 1.0,
                             std::sqrt(4.0 * touch.area / std::numbers::pi) / space.contact_radius() - 1.0};
    fmt::print("Hertz: {} unknowns, force {:+.3f} %, radius by pressure {:+.3f} %, by area {:+.3f} %, sunk in "
               "{:.1e} of the depth\n",
               unknowns, 100.0 * errors.force, 100.0 * errors.radius, 100.0 * errors.radius_by_area,
               touch.sunk_in / HalfSpace::depth);
    return errors;
}

} // namespace

/// Within a hundredth, also on a mesh with edges that are twice as long below the ball.
TEST(Hertz, ForceAndRadiusOfContactAreThoseOfTheClosedForm) {
    const auto coarse = errors_on({5.0, 3.2, 2.0}), fine = errors_on({5.0, 3.2, 2.0, 1.5});
    for (const auto &errors : {coarse, fine}) {
        EXPECT_LT(std::abs(errors.force), 0.01);
        EXPECT_LT(std::abs(errors.radius), 0.01);
    }
    EXPECT_LT(std::abs(fine.radius_by_area), 0.01);
    EXPECT_LT(std::abs(fine.force), std::abs(coarse.force));
}

} // namespace livermark
