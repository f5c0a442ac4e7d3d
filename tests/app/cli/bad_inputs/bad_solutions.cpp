#include <fmt/format.h>

#include "tests/app/cli/bad_inputs/bad_inputs.hpp"
#include "tests/samples/test_meshes.hpp"

namespace livermark::tests {

namespace {

BadInput solution(std::string name, std::string what, const std::string &file, std::string text, std::string place,
                  std::string remedy) {
    return {.name = std::move(name),
            .what = std::move(what),
            .arguments = "score bar.toml case.toml " + file + " --reference-on-mesh --output scores",
            .file = file + ":",
            .place = std::move(place),
            .remedy = std::move(remedy),
            .files = {{"case.toml", good_case}, {file, std::move(text)}},
            .prepare = write_bar};
}

/// No displacement at the nodes of the bar, in a unit of so many per metre.
std::string csv(double per_metre) {
    std::string text = "x,y,z,ux,uy,uz\n";
    for (const auto &point : box_mesh({0.09, 0.03, 0.03}, {3, 1, 1}).points)
        text += fmt::format("{},{},{},0,0,0\n", per_metre * point.x(), per_metre * point.y(), per_metre * point.z());
    return text;
}

} // namespace

std::vector<BadInput> bad_solutions() {
    const std::string header = "x,y,z,ux,uy,uz\n";
    auto moving = solution("LoadCaseInMotion", "a solution of a load case in motion", "solution.csv", csv(1.0),
                           "load case case depends on time", "score its static start");
    moving.file = "";
    moving.files["case.toml"] = good_release;
    auto missing =
        solution("MissingSolution", "a solution that is not there", "solution.csv", "", "", "check the path");
    missing.files.erase("solution.csv");
    return {
        std::move(missing),
        solution("EmptySolution", "an empty solution file", "solution.csv", "", "", "save it again"),
        solution("RandomBytes", "random bytes as a solution", "solution.csv", random_bytes(),
                 ":1:", "the first line has to be x,y,z,ux,uy,uz"),
        solution("NoHeader", "a solution without its first line", "solution.csv", "0,0,0,0,0,0\n", ":1:", "add it"),
        solution("FiveNumbers", "five numbers for a node", "solution.csv", header + "0,0,0,0,0\n",
                 ":2:", "correct the line"),
        solution("NanDisplacement", "NaN as a displacement", "solution.csv", header + "0,0,0,0,nan,0\n",
                 ":2:", "six finite numbers"),
        solution("Millimetres", "a solution in millimetres", "solution.csv", csv(1000.0), "node 1 at", "give metres"),
        solution("AnotherMesh", "a solution on another mesh", "solution.csv", csv(1.5), "node 1 at",
                 "take the one of `livermark export`"),
        solution("NodeTwice", "two displacements for one node", "solution.csv", csv(1.0) + "0,0,0,1,1,1\n",
                 "the node at (0, 0, 0) m", "keep one"),
        solution("DamagedHdf5", "random bytes as a solution in HDF5", "solution.h5", random_bytes(), "",
                 "give CSV, HDF5 or VTU"),
        std::move(moving),
    };
}

} // namespace livermark::tests
