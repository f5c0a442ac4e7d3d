#include "core/model.hpp"

#include <utility>

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

} // namespace livermark::core
