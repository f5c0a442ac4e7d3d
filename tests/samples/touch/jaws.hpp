#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "core/problem.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

/// A box and its mirror image in the plane z = 0, as one box; nodes of that plane are shared. The nodes of the half
/// come first, in its order.
/// @param half  box_mesh() or the like, whose side z_min is in the plane
inline core::TetraMesh with_mirror_image(const core::TetraMesh &half) {
    auto whole = half;
    std::vector<int> image;
    for (int i = 0; i < half.num_nodes(); ++i) {
        const auto &point = half.points[i];
        image.push_back(point.z() > 0.0 ? whole.num_nodes() : i);
        if (point.z() > 0.0)
            whole.points.emplace_back(point.x(), point.y(), -point.z());
    }
    for (const auto &[a, b, c, d] : half.tetrahedra)
        whole.tetrahedra.push_back({image[a], image[b], image[d], image[c]});
    whole.region.assign(whole.tetrahedra.size(), 0);
    put_patches_on_sides(whole);
    return whole;
}

/// Two jaws on a block that is its own mirror image, and one of them on half of it, which slides on the plane of
/// symmetry. Both blocks are held at x_min. An energy that is a sum over tetrahedra and facets is twice as large in a
/// state of the half and its mirror image, so each solution of the half is one of the whole.
struct JawsAndHalf {
    core::Problem whole, half;

    /// @param upper  mesh of the half, see with_mirror_image()
    /// @param ball   above it, which presses along -z
    JawsAndHalf(const core::TetraMesh &upper, const core::Material &material, core::TouchingTool ball,
                const std::vector<double> &path) {
        constexpr double nan = std::numeric_limits<double>::quiet_NaN();
        half = held(upper, material, path);
        prescribe(half.load_case, half.body->mesh, "z_min", {nan, nan, 0.0});
        touch(half, ball);
        whole = held(with_mirror_image(upper), material, path);
        ball.between = core::Vector3(ball.start.x(), ball.start.y(), 0.0);
        touch(whole, ball);
        whole.load_case.conditions.push_back({"other jaw", core::ConditionKind::touch});
    }

    static core::Vector3 mirrored(const core::Vector3 &vector) { return {vector.x(), vector.y(), -vector.z()}; }

  private:
    static core::Problem held(core::TetraMesh mesh, const core::Material &material, const std::vector<double> &path) {
        core::Problem problem{make_body(std::move(mesh), material), {}};
        problem.load_case = empty_load_case(problem.body->mesh);
        problem.load_case.regime = core::Regime::large;
        problem.load_case.path = path;
        prescribe(problem.load_case, problem.body->mesh, "x_min", core::Vector3::Zero());
        return problem;
    }
    static void touch(core::Problem &problem, core::TouchingTool &ball) {
        ball.constraint = problem.load_case.num_constraints();
        problem.load_case.touching = ball;
        problem.load_case.conditions.push_back({"touch", core::ConditionKind::touch});
    }
};

} // namespace livermark::tests
