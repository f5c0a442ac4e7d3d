#include "studies/run/work/case_groups.hpp"

#include <algorithm>
#include <numeric>

namespace livermark::studies {

namespace {

std::vector<std::vector<std::size_t>> with_the_same_solution(std::span<const core::Problem> problems) {
    std::vector<std::vector<std::size_t>> case_groups;
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const auto &problem = problems[p];
        const auto same = std::ranges::find_if(case_groups, [&](const auto &case_group) {
            const auto &first = problems[case_group.front()];
            return first.body == problem.body && core::are_statically_equal(first.load_case, problem.load_case);
        });
        if (same != case_groups.end())
            same->push_back(p);
        else
            case_groups.push_back({p});
    }
    return case_groups;
}

} // namespace

CaseGroups case_groups_of(std::span<const core::Problem> problems) {
    const auto all = with_the_same_solution(problems);
    const auto first_alike = [&](std::size_t case_group) {
        const auto &problem = problems[all[case_group].front()];
        return std::ranges::find_if(all, [&](const auto &candidate) {
            const auto &other = problems[candidate.front()];
            return other.body == problem.body && core::constrain_the_same(other.load_case, problem.load_case);
        });
    };
    std::vector<std::size_t> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, {}, first_alike);
    std::ranges::stable_sort(order, std::ranges::greater(), [&](std::size_t case_group) {
        return problems[all[case_group].front()].body->mesh.tetrahedra.size();
    });
    CaseGroups ordered;
    std::vector<const core::Body *> bodies; // in the order in which they come
    for (const auto case_group : order) {
        const auto *const body = problems[all[case_group].front()].body.get();
        const auto number = std::ranges::find(bodies, body) - bodies.begin();
        if (number == std::ssize(bodies))
            bodies.push_back(body);
        ordered.problems.push_back(all[case_group]);
        ordered.body.push_back(static_cast<int>(number));
    }
    return ordered;
}

std::vector<core::Problem> most_shared(std::span<const core::Problem> problems) {
    struct Candidate {
        const core::Problem *problem;
        std::ptrdiff_t num_sharing; ///< problems that constrain as much or more
    };
    std::vector<Candidate> best; // of each body
    for (const auto &problem : problems) {
        const auto is_of_body = [&](const auto &other) { return other.body == problem.body; };
        const auto constrains_as_much = [&](const auto &other) {
            return is_of_body(other) && core::constrains_all_of(other.load_case, problem.load_case);
        };
        const bool gains = std::ranges::any_of(problems, [&](const auto &other) {
            return constrains_as_much(other) && !core::constrain_the_same(other.load_case, problem.load_case);
        });
        if (!gains)
            continue;
        const Candidate candidate{&problem, std::ranges::count_if(problems, constrains_as_much)};
        const auto known = std::ranges::find_if(best, [&](const auto &other) { return is_of_body(*other.problem); });
        if (known == best.end())
            best.push_back(candidate);
        else if (candidate.num_sharing > known->num_sharing)
            *known = candidate;
    }
    std::vector<core::Problem> shared;
    for (const auto &candidate : best)
        shared.push_back(*candidate.problem);
    return shared;
}

} // namespace livermark::studies
