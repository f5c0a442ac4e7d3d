#include <Eigen/Dense>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "core/support/input_error.hpp"
#include "fem_reference/dynamics/modes.hpp"
#include "fem_reference/linear/conditions.hpp"
#include "fem_reference/solvers/constrained_solver.hpp"
#include "fem_reference/solvers/matrices.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"
#include "tests/fem_reference/fem_test_bodies.hpp"
#include "tests/not_a_number.hpp"

#include <arpack/arpack.hpp>

namespace livermark {

namespace {

using core::Vector3;
using tests::nan;

/// The lowest angular frequencies of K phi = omega^2 M phi [rad/s] by ARPACK, ascending: another program than the one
/// under test for all but the factor of K. Its mode 3, about zero, on all unknowns; where one is prescribed K^-1 gives
/// zero, so that nothing but the free ones takes part.
/// (Lehoucq, Sorensen, Yang 1998, ARPACK Users' Guide, sections 2.4 and 3.2)
std::vector<double> arpack_frequencies(const fem_reference::SymmetricMatrix &stiffness,
                                       const fem_reference::SymmetricMatrix &mass,
                                       const std::vector<double> &prescribed, int count) {
    fem_reference::ConstrainedSolver solver(stiffness);
    solver.factorise(prescribed);
    const int size = static_cast<int>(prescribed.size());
    const int num_vectors = 2 * count + 20;
    std::vector<double> start(size), vectors(static_cast<std::size_t>(size) * num_vectors), work(3 * prescribed.size());
    const int small_work_size = num_vectors * (num_vectors + 8);
    std::vector<double> small_work(small_work_size), image(prescribed.size());
    for (int i = 0; i < size; ++i)
        start[i] = std::isnan(prescribed[i]) ? std::cos(1.0 + i) : 0.0; // any that favours no mode
    int parameters[11] = {1, 0, 1000, 1, 0, 0, 3, 0, 0, 0, 0};
    int pointers[11] = {};
    int request = 0;
    int info = 1; // the start is given
    const auto slot = [&](int pointer) { return std::span(work).subspan(pointers[pointer] - 1, prescribed.size()); };
    for (;;) {
        arpack::saupd(request, arpack::bmat::generalized, size, arpack::which::largest_magnitude, count, 1e-13,
                      start.data(), num_vectors, vectors.data(), size, parameters, pointers, work.data(),
                      small_work.data(), small_work_size, info);
        if (request == -1) {
            fem_reference::multiply_mass(mass, slot(0), image);
            solver.solve_constrained(image, slot(1));
        } else if (request == 1)
            solver.solve_constrained(slot(2), slot(1)); // the mass times the vector is there
        else if (request == 2)
            fem_reference::multiply_mass(mass, slot(0), slot(1));
        else
            break;
    }
    if (info != 0 || parameters[4] < count)
        throw std::runtime_error("ARPACK's saupd stopped with info " + std::to_string(info));
    std::vector<int> select(num_vectors);
    std::vector<double> squares(count);
    arpack::seupd(0, arpack::howmny::ritz_vectors, select.data(), squares.data(), vectors.data(), size, 0.0,
                  arpack::bmat::generalized, size, arpack::which::largest_magnitude, count, 1e-13, start.data(),
                  num_vectors, vectors.data(), size, parameters, pointers, work.data(), small_work.data(),
                  small_work_size, info);
    if (info != 0)
        throw std::runtime_error("ARPACK's seupd stopped with info " + std::to_string(info));
    std::ranges::sort(squares);
    for (double &square : squares)
        square = std::sqrt(square);
    return squares;
}

/// A body that is constrained, as matrices.
struct ConstrainedBody {
    ConstrainedBody(const std::shared_ptr<const core::Body> &body, const core::LoadCase &load_case, int degree)
        : system(fem_reference::assemble(*body, degree)), stiffness(compressed_rows(system.stiffness)),
          mass(fem_reference::consistent_mass(*body, system)),
          prescribed(fem_reference::dof_conditions(load_case, system).prescribed) {}

    fem_reference::EigenPairs modes(int count) const {
        return fem_reference::lowest_eigenpairs(stiffness, mass, prescribed, count);
    }

    fem_reference::ElasticSystem system;
    fem_reference::SymmetricMatrix stiffness, mass;
    std::vector<double> prescribed;
};

/// A shaken box constrained at one side, without any symmetry.
ConstrainedBody shaken_box(int degree) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {5, 4, 3}), {1060.0, 5000.0, 0.45});
    auto load_case = tests::held(body->mesh);
    return {body, load_case, degree};
}

/// Two equal boxes that do not touch, so that every frequency comes twice.
ConstrainedBody twins(int degree) {
    const auto mesh = tests::twice(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {4, 3, 3}), {0.0, 0.0, 0.5});
    const auto body = tests::make_body(mesh, {1060.0, 5000.0, 0.45});
    auto load_case = tests::held(body->mesh);
    return {body, load_case, degree};
}

/// Twenty times as long as wide and constrained at one end.
constexpr double beam_length = 0.2;
constexpr double beam_width = 0.01;
const core::Material beam_material{1000.0, 5000.0, 0.0};

ConstrainedBody cantilever(int degree, int bricks_along, int bricks_across) {
    const auto body = tests::make_body(
        tests::box_mesh({beam_length, beam_width, beam_width}, {bricks_along, bricks_across, bricks_across}),
        beam_material);
    auto load_case = tests::held(body->mesh);
    return {body, load_case, degree};
}

/// A function of the frequency that is zero at those of Timoshenko's cantilever of square cross section. The state
/// (deflection w, rotation phi, moment M, shear force V) goes along the beam as
///   w' = phi + V / (kappa G A),  phi' = M / (E I),  M' = -V - rho I omega^2 phi,  V' = -rho A omega^2 w,
/// from w = phi = 0 to M = V = 0; kappa = 5/6 is Cowper's value for nu = 0 (J. Appl. Mech. 33, 1966).
double timoshenko_determinant(double omega) {
    const double area = beam_width * beam_width;
    const double inertia = area * area / 12.0;
    const double rho = beam_material.density;
    Eigen::Matrix4d rate = Eigen::Matrix4d::Zero();
    rate(0, 1) = 1.0;
    rate(0, 3) = 1.0 / (5.0 / 6.0 * beam_material.shear_modulus() * area);
    rate(1, 2) = 1.0 / (beam_material.young_modulus * inertia);
    rate(2, 3) = -1.0;
    rate(2, 1) = -rho * inertia * omega * omega;
    rate(3, 0) = -rho * area * omega * omega;
    const Eigen::Matrix4d transfer = (rate * beam_length).exp();
    return transfer.block<2, 2>(2, 2).determinant();
}

/// Its root nearest to a guess that is right to 3 %.
double timoshenko_frequency(double guess) {
    double low = 0.97 * guess, high = 1.03 * guess;
    const bool rising = timoshenko_determinant(low) < 0.0;
    EXPECT_NE(rising, timoshenko_determinant(high) < 0.0) << "no root near " << guess;
    while (high - low > 1e-12 * high) {
        const double middle = 0.5 * (low + high);
        ((timoshenko_determinant(middle) < 0.0) == rising ? low : high) = middle;
    }
    return low;
}

/// Number of eigenvalues omega^2 that lie below a square, by Sylvester's law of inertia: as many as K - square M has
/// negative pivots.
int num_modes_below(const ConstrainedBody &constrained, double square) {
    const auto shifted = fem_reference::combine(1.0, constrained.stiffness, -square, constrained.mass);
    std::vector<int> free_index(constrained.prescribed.size(), -1);
    int num_free = 0;
    for (std::size_t i = 0; i < free_index.size(); ++i)
        if (std::isnan(constrained.prescribed[i]))
            free_index[i] = num_free++;
    std::vector<Eigen::Triplet<double>> entries;
    for (int row = 0; row < shifted.num_rows(); ++row)
        for (int k = shifted.row_start[row]; k < shifted.row_start[row + 1]; ++k)
            if (free_index[row] >= 0 && free_index[shifted.column[k]] >= 0)
                entries.emplace_back(free_index[row], free_index[shifted.column[k]], shifted.value[k]);
    Eigen::SparseMatrix<double> matrix(num_free, num_free);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
    EXPECT_EQ(factor.info(), Eigen::Success);
    return static_cast<int>((factor.vectorD().array() < 0.0).count());
}

void expect_agreement_with_arpack(const ConstrainedBody &constrained, int count) {
    const auto pairs = constrained.modes(count);
    const auto other = arpack_frequencies(constrained.stiffness, constrained.mass, constrained.prescribed, count);
    ASSERT_EQ(pairs.angular_frequency.size(), other.size());
    for (int mode = 0; mode < count; ++mode)
        EXPECT_NEAR(pairs.angular_frequency[mode], other[mode], 1e-8 * other[mode]) << "mode " << mode;
}

} // namespace

/// Parameter: degree of the elements.
class FemModes : public testing::TestWithParam<int> {};

TEST_P(FemModes, MassOfATranslationIsThatOfTheBody) {
    const auto constrained = shaken_box(GetParam());
    for (int i = 0; i < 3; ++i) {
        std::vector<double> velocity(constrained.prescribed.size(), 0.0), momentum(velocity.size());
        for (std::size_t dof = i; dof < velocity.size(); dof += 3)
            velocity[dof] = 1.0;
        fem_reference::multiply_mass(constrained.mass, velocity, momentum);
        EXPECT_NEAR(fem_reference::dot(velocity, momentum), 1060.0 * 0.1 * 0.08 * 0.06, 1e-13);
        for (std::size_t node = 0; node < constrained.system.points.size(); ++node)
            EXPECT_NEAR(momentum[3 * node + i], constrained.system.mass_integral[node], 1e-15);
    }
}

TEST_P(FemModes, MassOfARotationIsTheMomentOfInertia) {
    const auto constrained = shaken_box(GetParam());
    std::vector<double> velocity, momentum(constrained.prescribed.size());
    for (const auto &point : constrained.system.points)
        for (const double component : {-point.y(), point.x(), 0.0})
            velocity.push_back(component);
    fem_reference::multiply_mass(constrained.mass, velocity, momentum);
    const double inertia = 1060.0 * 0.1 * 0.08 * 0.06 * (0.1 * 0.1 + 0.08 * 0.08) / 3.0;
    EXPECT_NEAR(fem_reference::dot(velocity, momentum), inertia, 1e-12 * inertia);
}

TEST(FemMass, QuadraticTetrahedronHasTheTabulatedMatrix) {
    // Zienkiewicz & Taylor: 420 M / (rho V) with corners 6, 1; corner to midpoint of its own edges -4, of others -6;
    // midpoints 32, 16 of edges that meet, 8 of opposite ones.
    const auto body = tests::make_body(tests::regular_tetrahedron(0.1), {1000.0, 5000.0, 0.3});
    const auto system = fem_reference::assemble(*body, 2);
    const std::array<std::array<int, 2>, 6> ends{{{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
    for (int a = 0; a < 10; ++a)
        for (int b = 0; b < 10; ++b) {
            double expected = a == b ? 6.0 : 1.0;
            if (a >= 4 && b >= 4) {
                int shared = 0;
                for (const int end : ends[a - 4])
                    shared += static_cast<int>(std::ranges::count(ends[b - 4], end));
                expected = std::array{8.0, 16.0, 32.0}[shared];
            } else if (a >= 4 || b >= 4)
                expected = std::ranges::count(ends[std::max(a, b) - 4], std::min(a, b)) > 0 ? -4.0 : -6.0;
            EXPECT_NEAR(420.0 * system.reference_mass[a * 10 + b], expected, 1e-12) << a << " " << b;
        }
}

TEST_P(FemModes, ShapesSolveTheEquationAndAreOrthonormalInTheMass) {
    const auto constrained = shaken_box(GetParam());
    const int count = 20;
    const auto pairs = constrained.modes(count);
    ASSERT_EQ(pairs.shape.size(), count);
    std::vector<double> force(constrained.prescribed.size()), momentum(constrained.prescribed.size());
    for (int mode = 0; mode < count; ++mode) {
        const auto &shape = pairs.shape[mode];
        const double square = std::pow(pairs.angular_frequency[mode], 2);
        fem_reference::multiply(constrained.stiffness, shape, force);
        fem_reference::multiply_mass(constrained.mass, shape, momentum);
        double residual = 0.0, size = 0.0;
        for (std::size_t i = 0; i < shape.size(); ++i)
            if (std::isnan(constrained.prescribed[i])) {
                residual += std::pow(force[i] - square * momentum[i], 2);
                size += std::pow(square * momentum[i], 2);
            } else
                EXPECT_EQ(shape[i], 0.0);
        EXPECT_LT(std::sqrt(residual / size), 1e-8) << "mode " << mode;
        for (int other = 0; other < count; ++other)
            EXPECT_NEAR(fem_reference::dot(pairs.shape[other], momentum), other == mode ? 1.0 : 0.0, 1e-9);
    }
}

TEST_P(FemModes, NoneIsLeftOut) {
    const auto constrained = shaken_box(GetParam());
    const auto pairs = constrained.modes(21);
    for (const int mode : {1, 10, 20}) {
        const double between = pairs.angular_frequency[mode - 1] * pairs.angular_frequency[mode];
        EXPECT_EQ(num_modes_below(constrained, between), mode);
    }
}

TEST_P(FemModes, AgreeWithArpack) {
    expect_agreement_with_arpack(shaken_box(GetParam()), 20);
}

TEST_P(FemModes, AgreeWithArpackOnASlenderBody) {
    expect_agreement_with_arpack(cantilever(GetParam(), 20, 1), 20);
}

TEST_P(FemModes, RepeatedFrequenciesAreAllFound) {
    const auto constrained = twins(GetParam());
    const auto pairs = constrained.modes(20);
    for (int mode = 0; mode < 20; mode += 2) {
        const double lower = pairs.angular_frequency[mode];
        EXPECT_NEAR(pairs.angular_frequency[mode + 1], lower, 1e-9 * lower);
        EXPECT_EQ(num_modes_below(constrained, std::pow(lower * 0.9999, 2)), mode);
    }
}

TEST(FemBeam, BendsAtTheFrequenciesOfTimoshenko) {
    const auto constrained = cantilever(2, 40, 2);
    const auto pairs = constrained.modes(6);
    const double inertia = std::pow(beam_width, 4) / 12.0;
    const double line_mass = beam_material.density * beam_width * beam_width;
    const double unit = std::sqrt(beam_material.young_modulus * inertia / line_mass) / (beam_length * beam_length);
    const std::array roots{1.8751040687, 4.6940911330, 7.8547574382}; // cos x cosh x = -1: Euler and Bernoulli
    const std::array softening{1.0, 0.99, 0.97};                      // roughly, by shear and rotation
    for (int bending = 0; bending < 3; ++bending) {
        const double euler_bernoulli = roots[bending] * roots[bending] * unit;
        const double expected = timoshenko_frequency(softening[bending] * euler_bernoulli);
        for (const int mode : {2 * bending, 2 * bending + 1})
            EXPECT_NEAR(pairs.angular_frequency[mode], expected, 1e-3 * expected) << "mode " << mode;
        if (bending == 0) {
            EXPECT_NEAR(pairs.angular_frequency[0], euler_bernoulli, 5e-3 * euler_bernoulli);
        }
    }
}

/// With nu = 0 and no motion across, a rod constrained at one end swings along at (2 n - 1) pi / 2 sqrt(E / rho) / L.
double largest_error_of_axial_modes(int degree, int bricks) {
    const auto body =
        tests::make_body(tests::box_mesh({beam_length, beam_width, beam_width}, {bricks, 1, 1}), beam_material);
    auto load_case = tests::held(body->mesh);
    for (const char *side : {"y_min", "y_max", "z_min", "z_max"})
        tests::prescribe(load_case, body->mesh, side, {nan, 0.0, 0.0});
    const ConstrainedBody constrained(body, load_case, degree);
    const auto pairs = constrained.modes(3);
    const double speed = std::sqrt(beam_material.young_modulus / beam_material.density);
    double largest = 0.0;
    for (int mode = 0; mode < 3; ++mode) {
        const double expected = (2 * mode + 1) * std::numbers::pi / 2.0 * speed / beam_length;
        const double error = pairs.angular_frequency[mode] / expected - 1.0;
        EXPECT_GT(error, 0.0) << "with consistent mass, frequencies come from above";
        largest = std::max(largest, error);
    }
    return largest;
}

TEST_P(FemModes, AxialFrequenciesConvergeAtTwiceTheDegree) {
    const double coarse = largest_error_of_axial_modes(GetParam(), 20);
    const double fine = largest_error_of_axial_modes(GetParam(), 40);
    EXPECT_LT(fine, GetParam() == 1 ? 2e-3 : 5e-6);
    EXPECT_NEAR(std::log2(coarse / fine), 2.0 * GetParam(), 0.1 * GetParam());
}

TEST_P(FemModes, AreGivenAtTheNodesOfTheMesh) {
    const auto body = tests::make_body(tests::shaken_box_mesh({0.1, 0.08, 0.06}, {5, 4, 3}), {1060.0, 5000.0, 0.45});
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    tests::prescribe(problem.load_case, body->mesh, "x_min", {0.001, 0.0, 0.0}); // the value does not matter
    const auto modes = fem_reference::lowest_modes(problem, GetParam(), 3);
    const auto constrained = shaken_box(GetParam());
    const auto pairs = constrained.modes(3);
    EXPECT_EQ(modes.angular_frequency, pairs.angular_frequency);
    ASSERT_EQ(modes.shape.size(), 3 * body->mesh.points.size());
    for (int mode = 0; mode < 3; ++mode)
        for (int node = 0; node < body->mesh.num_nodes(); ++node)
            for (int i = 0; i < 3; ++i)
                EXPECT_EQ(modes.shape[mode * body->mesh.num_nodes() + node][i], pairs.shape[mode][3 * node + i]);
}

TEST_P(FemModes, RefuseABodyFreeToMoveAndTooManyModes) {
    const auto body = tests::make_body(tests::box_mesh({0.1, 0.1, 0.1}, {1, 1, 1}), beam_material);
    core::Problem problem{body, tests::empty_load_case(body->mesh)};
    tests::prescribe(problem.load_case, body->mesh, "x_min", {0.0, nan, nan});
    EXPECT_THROW(fem_reference::lowest_modes(problem, GetParam(), 3), support::InputError);
    tests::prescribe(problem.load_case, body->mesh, "y_min", Vector3::Zero());
    EXPECT_NO_THROW(fem_reference::lowest_modes(problem, GetParam(), 3));
    EXPECT_THROW(fem_reference::lowest_modes(problem, GetParam(), 0), support::InputError);
    EXPECT_THROW(fem_reference::lowest_modes(problem, GetParam(), 1000), support::InputError);
}

/// The livers that ship, constrained as in the load case release.
TEST(FemModesOfLivers, AgreeWithArpack) {
    for (const std::string name : {"liver_healthy", "liver_tumours"}) {
        SCOPED_TRACE(name);
        const auto body = std::make_shared<const core::Body>(
            meshes::read_body(std::filesystem::path(LIVERMARK_SOURCE_DIR "/meshes") / (name + ".toml"), {}));
        const auto load_case = load_cases::read_load_case(LIVERMARK_SOURCE_DIR "/load_cases/release.toml", body->mesh);
        expect_agreement_with_arpack(ConstrainedBody(body, load_case, 1), 20);
    }
}

INSTANTIATE_TEST_SUITE_P(Degree, FemModes, testing::Values(1, 2));

} // namespace livermark
