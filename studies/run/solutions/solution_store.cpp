#include "studies/run/solutions/solution_store.hpp"

#include <fmt/format.h>

#include "results/hdf5/result_file.hpp"

namespace livermark::studies {

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
    return folder_.path / fmt::format("{}.{}.h5", number, model);
}

} // namespace livermark::studies
