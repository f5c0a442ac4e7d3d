#include "studies/exchange/formats/outside_solution.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>

#include "support/input_error.hpp"
#include "tests/livermark_command.hpp"
#include "tests/test_meshes.hpp"

namespace livermark {
namespace {

using core::Vector3;

const core::TetraMesh answer_mesh = tests::box_mesh({0.1, 0.08, 0.06}, {2, 2, 1});

Vector3 field(const Vector3 &x) {
    return {0.01 * x.y(), -0.02 * x.z(), 0.03 * x.x() + 1e-4};
}

/// The field at the nodes from the last to the first, after a line that is no node.
std::string csv(double per_metre = 1.0) {
    std::string text = "x, y, z, ux, uy, uz\n0.033,0.0123,0.05,9,9,9\n";
    for (auto point = answer_mesh.points.rbegin(); point != answer_mesh.points.rend(); ++point) {
        const Vector3 x = per_metre * *point, u = per_metre * field(*point);
        text += fmt::format("{},{},{},{},{},{}\r\n", x.x(), x.y(), x.z(), u.x(), u.y(), u.z());
    }
    return text + "\n";
}

void expect_field(const studies::Answer &answer) {
    const auto u = studies::displacement_at_nodes(answer, answer_mesh, "answer");
    ASSERT_EQ(u.size(), answer_mesh.points.size());
    for (std::size_t i = 0; i < u.size(); ++i)
        EXPECT_LT((u[i] - field(answer_mesh.points[i])).norm(), 1e-15) << i;
}

template <class Action> void expect_refusal(Action action, const std::string &part) {
    try {
        action();
        FAIL() << part;
    } catch (const support::InputError &error) {
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(Answer, IsFoundAtTheNodesInAnyOrder) {
    expect_field(studies::parse_outside_solution(csv(), "answer.csv"));
}

TEST(Answer, IsReadFromHdf5AndVtu) {
    const auto folder = std::filesystem::path(testing::TempDir()) / "livermark_answer";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "answer.csv") << csv();
    const auto python = [&](const std::string &program) {
        const auto outcome = tests::run_command(fmt::format("cd '{}' && /usr/bin/python3 -c \"import numpy, h5py, "
                                                            "meshio; a = numpy.loadtxt('answer.csv', delimiter=',', "
                                                            "skiprows=1); {}\"",
                                                            folder.string(), program));
        ASSERT_EQ(outcome.status, 0) << outcome.output;
    };
    python("f = h5py.File('answer.h5', 'w'); f['points'] = a[:, :3]; f['displacement'] = a[:, 3:]; f.close()");
    python("meshio.Mesh(a[:, :3], [('vertex', numpy.arange(len(a))[:, None])], "
           "point_data={'displacement': a[:, 3:]}).write('answer.vtu')");
    python("f = h5py.File('empty.h5', 'w'); f['points'] = a[:, :3]; f.close()");
    for (const auto *name : {"answer.csv", "answer.h5", "answer.vtu"})
        expect_field(studies::read_outside_solution(folder / name));
    expect_refusal([&] { studies::read_outside_solution(folder / "empty.h5"); }, "there is no dataset displacement");
    expect_refusal([&] { studies::read_outside_solution(folder / "nowhere.csv"); }, "check the path");
    std::ofstream(folder / "noise.vtu") << "noise";
    expect_refusal([&] { studies::read_outside_solution(folder / "noise.vtu"); }, "cannot be converted");
}

TEST(Answer, OfAnotherProblemIsRefused) {
    const auto find = [](const std::string &text) {
        studies::displacement_at_nodes(studies::parse_outside_solution(text, "answer.csv"), answer_mesh, "answer.csv");
    };
    expect_refusal([&] { find(csv(1000.0)); }, "it seems to be in millimetres; give metres");
    expect_refusal([&] { find(csv(1.5)); }, "it belongs to another mesh");
    expect_refusal([&] { find(csv() + "0,0,0,1,1,1\n"); }, "two displacements for the node at (0, 0, 0) m");
}

TEST(Answer, ThatIsWrittenWronglyIsRefusedWithItsLine) {
    for (const auto &[text, part] : std::initializer_list<std::pair<const char *, const char *>>{
             {"", "answer.csv:1: the first line has to be x,y,z,ux,uy,uz"},
             {"0,0,0,0,0,0\n", "answer.csv:1: the first line"},
             {"x,y,z,ux,uy,uz\n", "no nodes in it"},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0\n", "answer.csv:2: '0,0,0,0,0' is not six"},
             {"x,y,z,ux,uy,uz\n\n0,0,0,0,0,0,0\n", "answer.csv:3: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,nan\n", "answer.csv:2: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,1e999\n", "answer.csv:2: "},
             {"x,y,z,ux,uy,uz\n0,0,0,0,0,one\n", "answer.csv:2: "},
             {"x,y,z,ux,uy,uz\n0;0;0;0;0;0\n", "answer.csv:2: "}})
        expect_refusal([&] { studies::parse_outside_solution(text, "answer.csv"); }, part);
}

} // namespace
} // namespace livermark
