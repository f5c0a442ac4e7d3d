#include "studies/exchange/formats/export_format.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "tests/bad_input.hpp"
#include "tests/livermark_command.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

const core::TetraMesh solution_mesh = tests::box_mesh({0.1, 0.08, 0.06}, {2, 2, 1});

Vector3 field(const Vector3 &x) {
    return {0.01 * x.y(), -0.02 * x.z(), 0.03 * x.x() + 1e-4};
}

/// The field at the nodes from the last to the first, after a line that is no node.
std::string csv(double per_metre = 1.0) {
    std::string text = "x, y, z, ux, uy, uz\n0.033,0.0123,0.05,9,9,9\n";
    for (auto point = solution_mesh.points.rbegin(); point != solution_mesh.points.rend(); ++point) {
        const Vector3 x = per_metre * *point, u = per_metre * field(*point);
        text += fmt::format("{},{},{},{},{},{}\r\n", x.x(), x.y(), x.z(), u.x(), u.y(), u.z());
    }
    return text + "\n";
}

void expect_field(const studies::OutsideSolution &solution) {
    const auto u = studies::displacement_at_nodes(solution, solution_mesh, "solution");
    ASSERT_EQ(u.size(), solution_mesh.points.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_LT((u[i] - field(solution_mesh.points[i])).norm(), 1e-15) << i;
}

TEST(OutsideSolution, IsFoundAtTheNodesInAnyOrder) {
    expect_field(studies::parse_outside_solution(csv(), "solution.csv"));
}

/// As spreadsheets and other programs write them.
TEST(OutsideSolution, MayHavePlusSignsAndSixDigits) {
    std::string signs = "x,y,z,ux,uy,uz\n", digits = signs;
    const core::Vector3 off{0.0333333, 0.0777777, 0.0111111};
    auto mesh = solution_mesh;
    for (auto &point : mesh.points) {
        const auto u = field(point);
        signs += fmt::format("{:+.17e},{:+.17e},{:+.17e},{:+.17e},{:+.17e},{:+.17e}\n", point.x(), point.y(), point.z(),
                             u.x(), u.y(), u.z());
        const core::Vector3 moved = point + off;
        digits += fmt::format("{:.6g},{:.6g},{:.6g},{:.17g},{:.17g},{:.17g}\n", moved.x(), moved.y(), moved.z(), u.x(),
                              u.y(), u.z());
    }
    expect_field(studies::parse_outside_solution(signs, "solution.csv"));
    for (auto &point : mesh.points)
        point += off;
    const auto u =
        studies::displacement_at_nodes(studies::parse_outside_solution(digits, "solution.csv"), mesh, "file");
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_LT((u[i] - field(solution_mesh.points[i])).norm(), 1e-15) << i;
    tests::expect_input_error([&] { studies::parse_outside_solution("x,y,z,ux,uy,uz\n+-1,0,0,0,0,0\n", "file"); },
                              {"is not six finite numbers"});
}

TEST(OutsideSolution, IsReadFromHdf5AndVtu) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "livermark_outside_solution";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "solution.csv") << csv();
    const auto python = [&](const std::string &program) {
        const auto outcome = tests::run_command(fmt::format("cd '{}' && /usr/bin/python3 -c \"import numpy, h5py, "
                                                            "meshio; a = numpy.loadtxt('solution.csv', delimiter=',', "
                                                            "skiprows=1); {}\"",
                                                            folder.string(), program));
        ASSERT_EQ(outcome.status, 0) << outcome.output;
    };
    python("f = h5py.File('solution.h5', 'w'); f['points'] = a[:, :3]; f['displacement'] = a[:, 3:]; f.close()");
    python("meshio.Mesh(a[:, :3], [('vertex', numpy.arange(len(a))[:, None])], "
           "point_data={'displacement': a[:, 3:]}).write('solution.vtu')");
    python("f = h5py.File('empty.h5', 'w'); f['points'] = a[:, :3]; f.close()");
    for (const auto *name : {"solution.csv", "solution.h5", "solution.vtu"})
        expect_field(studies::read_outside_solution(folder / name));
    tests::expect_input_error([&] { studies::read_outside_solution(folder / "empty.h5"); },
                              {"there is no dataset displacement"});
    tests::expect_input_error([&] { studies::read_outside_solution(folder / "nowhere.csv"); }, {"check the path"});
    std::ofstream(folder / "noise.vtu") << "noise";
    tests::expect_input_error([&] { studies::read_outside_solution(folder / "noise.vtu"); }, {"cannot be converted"});
}

TEST(OutsideSolution, OfAnotherProblemIsRefused) {
    const auto find = [](const std::string &text) {
        studies::displacement_at_nodes(studies::parse_outside_solution(text, "solution.csv"), solution_mesh,
                                       "solution.csv");
    };
    tests::expect_input_error([&] { find(csv(1000.0)); }, {"it seems to be in millimetres; give metres"});
    tests::expect_input_error([&] { find(csv(1.5)); }, {"it belongs to another mesh"});
    tests::expect_input_error([&] { find(csv() + "0,0,0,1,1,1\n"); },
                              {"two displacements for the node at (0, 0, 0) m"});
}

TEST(OutsideSolution, ThatIsWrittenWronglyIsRefusedWithItsLine) {
    for (const auto &[text, part] : std::initializer_list<std::pair<const char *, const char *>>{
             {"", "solution.csv:1: the first line has to be x,y,z,ux,uy,uz"},
             {"0,0,0,0,0,0\n", "solution.csv:1: the first line"},
             {"x,y,z,ux,uy,uz\n", "no nodes in it"},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0\n", "solution.csv:2: '0,0,0,0,0' is not six"},
             {"x,y,z,ux,uy,uz\n\n0,0,0,0,0,0,0\n", "solution.csv:3: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,nan\n", "solution.csv:2: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,1e999\n", "solution.csv:2: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,one\n", "solution.csv:2: "},
             {"x,y,z,ux,uy,uz\n0;0;0;0;0;0\n", "solution.csv:2: "}})
        tests::expect_input_error([&] { studies::parse_outside_solution(text, "solution.csv"); }, {part});
}

} // namespace
} // namespace livermark
