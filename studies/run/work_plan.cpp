#include "studies/run/work_plan.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <utility>

namespace livermark::studies {

namespace {

std::vector<CaseGroup> with_the_same_solution(std::span<const core::Problem> problems) {
    std::vector<CaseGroup> case_groups;
    for (std::size_t p = 0; p < problems.size(); ++p) {
        const auto &problem = problems[p];
        const auto same = std::ranges::find_if(case_groups, [&](const CaseGroup &case_group) {
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

using IsWanted = std::function<bool(std::size_t)>;

std::vector<CaseGroup> wanted_of(std::span<const CaseGroup> case_groups, const IsWanted &is_wanted) {
    std::vector<CaseGroup> wanted;
    for (const auto &case_group : case_groups) {
        CaseGroup some;
        std::ranges::copy_if(case_group, std::back_inserter(some), is_wanted);
        if (!some.empty())
            wanted.push_back(std::move(some));
    }
    return wanted;
}

/// Items of all bodies, body by body.
class Plan {
  public:
    /// As many case groups at once as models take less time for together: the same ones whatever of them is left to do.
    void add_solves(const std::vector<std::size_t> &models, std::span<const CaseGroup> case_groups,
                    std::size_t most_at_once, const IsWanted &is_wanted) {
        const int group = new_group();
        for (std::size_t first = 0; first < case_groups.size(); first += most_at_once) {
            const auto some = case_groups.subspan(first, std::min(most_at_once, case_groups.size() - first));
            if (auto wanted = wanted_of(some, is_wanted); !wanted.empty())
                items.push_back({models, std::move(wanted), group});
        }
    }

    /// Evaluations wait for what solves their problem.
    void add_evaluations(std::span<const CaseGroup> case_groups) {
        const int group = new_group(), num_solves = static_cast<int>(items.size());
        for (const auto &case_group : case_groups)
            for (const auto problem : case_group) {
                auto &added = items.emplace_back(WorkItem{{}, {{problem}}, group});
                for (int item = 0; item < num_solves; ++item)
                    if (!items[item].is_evaluation() && std::ranges::any_of(items[item].case_groups, [&](auto &solved) {
                            return std::ranges::count(solved, problem) > 0;
                        }))
                        added.waits_for.push_back(item);
            }
    }

    std::vector<WorkItem> items;

  private:
    int new_group() const { return items.empty() ? 0 : items.back().group + 1; }
};

} // namespace

std::vector<CaseGroup> case_groups_of(std::span<const core::Problem> problems) {
    const auto all = with_the_same_solution(problems);
    const auto first_alike = [&](std::size_t case_group) {
        const auto &problem = problems[all[case_group].front()];
        return std::ranges::find_if(all, [&](const CaseGroup &candidate) {
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
    std::vector<CaseGroup> ordered;
    for (const auto case_group : order)
        ordered.push_back(all[case_group]);
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

std::vector<WorkItem> plan_work(std::span<const core::Problem> problems, std::span<const core::Model> models,
                                const std::function<bool(std::size_t)> &is_wanted) {
    std::vector<std::size_t> together, others;
    std::size_t most_together = 1;
    for (std::size_t m = 0; m < models.size(); ++m)
        if (models[m].most_together > 1) {
            together.push_back(m);
            most_together = std::max(most_together, models[m].most_together);
        } else {
            others.push_back(m);
        }
    auto left = case_groups_of(problems);
    Plan plan;
    while (!left.empty()) {
        const auto body = problems[left.front().front()].body;
        const auto end_of_body = std::stable_partition(left.begin(), left.end(), [&](const CaseGroup &case_group) {
            return problems[case_group.front()].body == body;
        });
        const std::vector same_body(left.begin(), end_of_body);
        left.erase(left.begin(), end_of_body);
        if (!together.empty())
            plan.add_solves(together, same_body, most_together, is_wanted);
        for (const auto model : others)
            plan.add_solves({model}, same_body, 1, is_wanted);
        plan.add_evaluations(wanted_of(same_body, is_wanted));
    }
    return std::move(plan.items);
}

} // namespace livermark::studies
