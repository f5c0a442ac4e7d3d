#include "core/model.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <utility>

#include "core/support/input_error.hpp"

namespace livermark::core {

namespace {

class EachAlone : public PreparedModel {
  public:
    EachAlone(std::shared_ptr<const Body> body, std::function<Solution(const Problem &)> solve)
        : body_(std::move(body)), solve_(std::move(solve)) {}

    std::vector<Solution> solve(std::span<const LoadCase> load_cases) override {
        std::vector<Solution> solutions;
        for (const auto &load_case : load_cases)
            solutions.push_back(solve_({body_, load_case}));
        return solutions;
    }

  private:
    std::shared_ptr<const Body> body_;
    std::function<Solution(const Problem &)> solve_;
};

} // namespace

Solution Model::solve(const Problem &problem) const {
    return std::move(prepare(problem.body, nullptr)->solve(std::span(&problem.load_case, 1)).front());
}

PrepareModel solves_each(std::function<Solution(const Problem &)> solve) {
    return [solve = std::move(solve)](const std::shared_ptr<const Body> &body, const LoadCase * /*common*/) {
        return std::make_unique<EachAlone>(body, solve);
    };
}

namespace {

/// Coordinates that went through a mesh file come back the same; this leaves room for their last digits only.
constexpr double rounding = 1e-12;

bool has_same_lengths(const CalibratedSprings &springs, const TetraMesh &mesh) {
    for (std::size_t s = 0; s < springs.edges.size(); ++s) {
        const double length = (mesh.points[springs.edges[s][1]] - mesh.points[springs.edges[s][0]]).norm();
        if (!(std::abs(length - springs.rest_length[s]) <= rounding * length))
            return false;
    }
    return true;
}

bool has_same_constants(const Material &a, const Material &b) {
    return a.young_modulus == b.young_modulus && a.poisson_ratio == b.poisson_ratio;
}

std::string constants_of(const std::vector<Material> &materials) {
    std::string text;
    for (const auto &material : materials)
        text += fmt::format("{}{:.6g} Pa and {:.6g}", text.empty() ? "" : ", ", material.young_modulus,
                            material.poisson_ratio);
    return text;
}

} // namespace

void check_fit(const CalibratedSprings &springs, const Body &body) {
    if (body.capsule)
        throw support::InputError("{} was fitted to a body without a capsule, and {} has one", springs.origin,
                                  body.name);
    if (body.vessels)
        throw support::InputError("{} was fitted to a body without vessels as lines, and {} has some", springs.origin,
                                  body.name);
    if (!body.modulus_factor.empty())
        throw support::InputError("{} was fitted to a body without a map of stiffness, and {} has one", springs.origin,
                                  body.name);
    if (springs.edges != edge_table(body.mesh.tetrahedra).edges || !has_same_lengths(springs, body.mesh))
        throw support::InputError(
            fmt::format("{}: was made for another mesh than that of {}; make one for this mesh with "
                        "`python3 -m livermark.calibration`",
                        springs.origin, body.name));
    if (!std::ranges::equal(springs.materials, body.materials, has_same_constants))
        throw support::InputError(
            fmt::format("{}: was made for Young's modulus and Poisson's ratio {}, not for {} of {}; make "
                        "one for these with `python3 -m livermark.calibration`",
                        springs.origin, constants_of(springs.materials), constants_of(body.materials), body.name));
}

} // namespace livermark::core
