#include "tests/peer/calculix.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "core/support/input_error.hpp"
#include "studies/exchange/formats/export_format.hpp"

namespace livermark::tests {

namespace {

using core::Vector3;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

} // namespace

std::vector<Vector3> read_dat(std::istream &in, int num_nodes) {
    std::vector<Vector3> displacement(num_nodes, Vector3::Constant(nan));
    std::string line;
    while (std::getline(in, line)) {
        std::istringstream words(line);
        int node = 0;
        Vector3 value;
        if (words >> node >> value.x() >> value.y() >> value.z() && node >= 1 && node <= num_nodes)
            displacement[node - 1] = value;
    }
    for (int node = 0; node < num_nodes; ++node)
        if (displacement[node].hasNaN())
            throw std::runtime_error(fmt::format("CalculiX gives no displacement for node {}", node + 1));
    return displacement;
}

std::filesystem::path find_ccx() {
    const char *const path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (auto ccx = std::filesystem::path(folder) / "ccx"; std::filesystem::exists(ccx))
            return ccx;
    return {};
}

std::vector<Vector3> solve_with_calculix(const std::filesystem::path &ccx, const core::Problem &problem, int degree,
                                         const std::filesystem::path &folder) {
    std::filesystem::create_directories(folder);
    const auto result = folder / "problem.dat";
    std::filesystem::remove(result); // or a failed run would show what an earlier one found
    {
        std::ofstream input(folder / "problem.inp");
        const auto &format = support::find_named(exchange::all_formats(), "calculix", "format");
        format.files.front().write(input, problem, {.quadratic = degree == 2});
        if (!input.flush())
            throw std::runtime_error(fmt::format("{} cannot be written", (folder / "problem.inp").string()));
    }
    const auto command =
        fmt::format("cd '{}' && OMP_NUM_THREADS=1 '{}' problem > problem.log 2>&1", folder.string(), ccx.string());
    if (const int status = std::system(command.c_str()); status != 0)
        throw std::runtime_error(
            fmt::format("ccx ends with status {}; see {}", status, (folder / "problem.log").string()));
    std::ifstream output(result);
    return read_dat(output, problem.body->mesh.num_nodes());
}

} // namespace livermark::tests
