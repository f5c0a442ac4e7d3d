#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include "msm/dynamics/stepper.hpp"
#include "msm/integrator.hpp"
#include "msm/kernels/energy_kernels.hpp"
#include "msm/kernels/fast_steps.hpp"
#include "msm/kernels/simd/coupled_steps-inl.hpp"
#include "msm/kernels/vector_springs.hpp"
#include "msm/springs/springs.hpp"
#include "tests/samples/moving_samples.hpp"

// An energy that no model has, as CONTRIBUTING.md says how to add one: its kernels, and what the terms have of it. The
// test compiles the kernels for one vector unit.

HWY_BEFORE_NAMESPACE();
namespace livermark::msm::HWY_NAMESPACE {

/// W_s = mu (tr E - ln J + (J - 1)^2 / 2), and g = J - 1.
template <class D> class SquaredVolumeChange {
    using T = hn::TFromD<D>;

  public:
    SquaredVolumeChange(D d, hn::Vec<D> modulus, const Symmetric<D> &twice_strain, double least_stretch = 0.0)
        : modulus_(modulus), twice_strain_(twice_strain), of_(cauchy_green(d, twice_strain, least_stretch)),
          j_(hn::Sqrt(hn::Add(hn::Set(d, T(1)), of_.det_change))) {}

    const CauchyGreen<D> &strain() const { return of_; }

    hn::Vec<D> energy(D d) const {
        const auto half = hn::Set(d, 0.5), change = volume_change(d);
        const auto shape_part = hn::Sub(of_.i1, hn::Log1p(d, of_.det_change));
        return hn::Mul(hn::Mul(modulus_, half), hn::MulAdd(change, change, shape_part));
    }
    /// mu (I - C^-1 + r C^-1) with r = (J - 1) J
    Symmetric<D> stress(D d) const {
        const auto one = hn::Set(d, T(1)), r = hn::Mul(volume_change(d), j_);
        const auto scale = hn::Div(modulus_, hn::Add(one, of_.det_change));
        const auto mean = hn::Mul(scale, hn::MulAdd(r, hn::Add(one, of_.i1), of_.two_and_three));
        return plus_identity(scaled<D>(hn::Mul(scale, hn::Sub(one, r)), minus<D>(twice_strain_, of_.adjugate)), mean);
    }
    Symmetric<D> isochoric_stress(D d) const {
        return livermark::msm::HWY_NAMESPACE::isochoric_stress(d, modulus_, twice_strain_, of_);
    }
    Symmetric<D> stress_rate(D d, const Symmetric<D> &rate) const {
        const auto one = hn::Set(d, 1.0), half = hn::Set(d, 0.5), change = volume_change(d);
        const auto inverse = scaled<D>(hn::Div(one, hn::Add(one, of_.det_change)),
                                       plus_identity(minus<D>(of_.adjugate, twice_strain_), hn::Add(one, of_.i1)));
        const auto turning = hn::Mul(modulus_, hn::NegMulAdd(change, j_, one));
        const auto slope = hn::Mul(hn::Mul(half, j_), hn::Add(j_, change)); // (2 J - 1) J / 2
        const auto swelling = hn::Mul(modulus_, hn::Mul(slope, contraction(inverse, rate)));
        return plus_scaled<D>(scaled<D>(turning, sandwich(inverse, rate)), swelling, inverse);
    }

    static SquaredVolume<D> volume(D d, hn::Vec<D> change) {
        return {hn::Mul(change, change), change, hn::Set(d, 1.0)};
    }
    static hn::Vec<D> volume_push(D /*d*/, hn::Vec<D> change) { return change; }
    static hn::Vec<D> push_inside(D d, hn::Vec<D> j, hn::Vec<D> square) {
        const auto size = hn::Sqrt(square);
        return hn::Mul(hn::Sub(hn::Add(hn::Set(d, T(1)), size), square), hn::Div(j, square));
    }
    static constexpr bool is_finite = false;

  private:
    /// J - 1
    hn::Vec<D> volume_change(D d) const { return hn::Div(of_.det_change, hn::Add(hn::Set(d, T(1)), j_)); }

    hn::Vec<D> modulus_;
    Symmetric<D> twice_strain_;
    CauchyGreen<D> of_;
    hn::Vec<D> j_;
};

EnergyFunctions kernels_of_squared_volume_change() {
    return functions_of_energy<SquaredVolumeChange>();
}

} // namespace livermark::msm::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

namespace livermark {
namespace {

using Eigen::Matrix3d;

Matrix3d cauchy_green_of(const Matrix3d &strain) {
    return Matrix3d::Identity() + 2.0 * strain;
}

double volume_of(const Matrix3d &strain) {
    return std::sqrt(cauchy_green_of(strain).determinant());
}

double energy(double mu, const Matrix3d &strain) {
    const double j = volume_of(strain);
    return mu * (strain.trace() - std::log(j) + 0.5 * (j - 1.0) * (j - 1.0));
}

Matrix3d stress(double mu, const Matrix3d &strain) {
    const double j = volume_of(strain);
    return mu * (Matrix3d::Identity() + ((j - 1.0) * j - 1.0) * cauchy_green_of(strain).inverse());
}

msm::Matrix6 stiffness(double mu, const Matrix3d &strain) {
    const double j = volume_of(strain);
    const Matrix3d inverse = cauchy_green_of(strain).inverse();
    const msm::Vector6 trace = msm::components(inverse);
    msm::Matrix6 result = (2.0 * j - 1.0) * j * trace * trace.transpose();
    for (int c = 0; c < 6; ++c)
        result.col(c) +=
            2.0 * (1.0 - (j - 1.0) * j) * msm::components(inverse * msm::tensor(msm::Vector6::Unit(c)) * inverse);
    return mu * result;
}

/// Shape is resisted as by the neo-Hookean energy.
msm::SpringEnergy squared_volume_change() {
    auto new_energy = std::ranges::find(msm::all_spring_energies(), "neo_hookean", &msm::SpringEnergy::name)[0];
    new_energy.name = "squared_volume_change";
    new_energy.energy = energy;
    new_energy.stress = stress;
    new_energy.stiffness = stiffness;
    new_energy.volume = msm::change_of_volume;
    new_energy.kernels = msm::HWY_NAMESPACE::kernels_of_squared_volume_change;
    return new_energy;
}

using Choice = std::tuple<bool, msm::StrainMeasure>; // around edges or nodes, and means of what

class NewEnergy : public testing::TestWithParam<Choice> {
  protected:
    NewEnergy() {
        const auto [is_around_edges, measure] = GetParam();
        springs_.domains = {
            .nodes = is_around_edges ? 0.0 : 0.8, .edges = is_around_edges ? 0.8 : 0.0, .tetrahedra = 0.2};
        springs_.measure = measure;
        springs_.energy = squared_volume_change();
        springs_.averages_volumes = is_around_edges;
        sample_.body.terms = msm::coupled_springs_with_volume(body_, springs_).terms;
    }

    /// Pressed and sheared, with every node somewhere else by a little: no tetrahedron is inside out.
    std::vector<core::Vector3> deformed() const {
        std::mt19937 random(7);
        auto positions = sample_.positions;
        for (auto &x : positions)
            x += core::Vector3(-0.3 * x.x() + 0.2 * x.y(), 0.1 * x.z(), 0.0) + tests::random_vector(random, 0.0005);
        return positions;
    }

    core::Body body_ = tests::two_materials(108, 0.1, 0.45);
    msm::CoupledSprings springs_;
    tests::Sample sample_ = tests::loose(body_);
};

TEST_P(NewEnergy, MovesInTheKernelsAsItsTermsDo) {
    ASSERT_TRUE(msm::are_in_kernels(springs_));
    const auto start_at = deformed();
    for (const auto &damping : {core::RayleighDamping{0.0, 0.0}, core::RayleighDamping{3.0, 0.002}})
        for (const auto precision : tests::both_precisions) {
            auto expected = tests::shaken(sample_);
            for (std::size_t i = 0; i < start_at.size(); ++i)
                msm::node_part(expected.displacement, static_cast<int>(i)) = start_at[i] - sample_.positions[i];
            const auto start = expected;
            auto steps = msm::FastSteps::prepare(sample_.body, sample_.positions, sample_.conditions, damping,
                                                 "symplectic_euler", tests::sample_step, {.precision = precision});
            ASSERT_TRUE(steps.has_value());
            steps->set_state(start);
            steps->take(3);
            const auto equation = msm::elastic_motion(sample_.body, sample_.positions, sample_.conditions, damping);
            const auto step = msm::find_integrator("symplectic_euler").prepare(equation, tests::sample_step);
            for (int s = 0; s < 3; ++s)
                step(expected);
            EXPECT_LT((steps->state().velocity - expected.velocity).lpNorm<Eigen::Infinity>(),
                      tests::tolerance(precision) * (expected.velocity - start.velocity).lpNorm<Eigen::Infinity>());
        }
}

TEST_P(NewEnergy, HasTheEnergiesForcesAndProductsOfItsTermsAtEquilibria) {
    const auto vectors = msm::in_vectors(sample_.body, sample_.positions);
    const bool is_around_edges = springs_.averages_volumes;
    ASSERT_EQ(vectors.terms.size() == 1 && vectors.terms != sample_.body.terms, !is_around_edges);
    const auto x = msm::to_unknowns(deformed()), u = msm::to_unknowns(sample_.positions);
    Eigen::VectorXd product = Eigen::VectorXd::Zero(x.size()), expected_product = product;
    for (const auto &term : vectors.terms)
        term->add_hessian_product(x, u, product);
    for (const auto &term : sample_.body.terms)
        term->add_hessian_product(x, u, expected_product);
    const auto force = msm::to_unknowns(msm::elastic_gradient(vectors, deformed())),
               expected_force = msm::to_unknowns(msm::elastic_gradient(sample_.body, deformed()));
    const double energy = msm::elastic_energy(sample_.body, deformed());
    constexpr double rounding = 1e-11;
    EXPECT_NEAR(msm::elastic_energy(vectors, deformed()), energy, rounding * energy);
    EXPECT_LT((force - expected_force).norm(), rounding * expected_force.norm());
    EXPECT_LT((product - expected_product).norm(), rounding * expected_product.norm());
}

INSTANTIATE_TEST_SUITE_P(CoupledSprings, NewEnergy,
                         testing::Combine(testing::Bool(), testing::Values(msm::StrainMeasure::cauchy_green,
                                                                           msm::StrainMeasure::deformation_gradient)));

} // namespace
} // namespace livermark
