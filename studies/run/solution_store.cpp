#include "studies/run/solution_store.hpp"

#include <cstdlib>
#include <fmt/format.h>
#include <system_error>

#include "results/hdf5/result_file.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

SolutionStore::SolutionStore() {
    std::error_code fault;
    const auto parent = std::filesystem::temp_directory_path(fault);
    auto name = (parent / "livermark-XXXXXX").string();
    if (fault || !mkdtemp(name.data()))
        throw support::InputError("no folder can be made for temporary files; set TMPDIR to one that can be written");
    path_ = name;
}

SolutionStore::~SolutionStore() {
    std::error_code nobody_cares;
    std::filesystem::remove_all(path_, nobody_cares);
}

void SolutionStore::leave(std::size_t number, const std::string &model, const core::Solution &solution,
                          const core::Problem &problem) const {
    results::write_solution(file(number, model), solution, problem.load_case);
}

std::optional<core::Solution> SolutionStore::find(std::size_t number, const std::string &model,
                                                  const core::Problem &problem) const {
    const auto path = file(number, model);
    if (!std::filesystem::exists(path))
        return std::nullopt;
    auto solution = results::read_solution(path, problem);
    std::filesystem::remove(path);
    return solution;
}

std::filesystem::path SolutionStore::file(std::size_t number, const std::string &model) const {
    return path_ / fmt::format("{}.{}.h5", number, model);
}

} // namespace livermark::studies
