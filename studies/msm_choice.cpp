#include "studies/msm_choice.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <span>

#include "msm/implicit_integrators.hpp"
#include "studies/catalogue.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

namespace {

template <class Entry> const Entry &find(std::span<const Entry> table, const std::string &name, const char *word) {
    const auto found = std::ranges::find(table, name, &Entry::name);
    if (found != table.end())
        return *found;
    std::vector<std::string> known;
    for (const auto &entry : table)
        known.push_back(entry.name);
    throw support::InputError(unknown_name(word, name, known));
}

} // namespace

msm::SpringLaw find_spring_law(const std::string &name) {
    return find(msm::all_spring_laws(), name, "spring law");
}

std::vector<msm::Integrator> find_integrators(const std::vector<std::string> &names) {
    const std::span<const msm::Integrator> all = msm::known_integrators();
    std::vector<msm::Integrator> chosen;
    for (const auto &name : names) {
        if (std::ranges::find(chosen, name, &msm::Integrator::name) != chosen.end())
            throw support::InputError(fmt::format("integrator '{}' is asked for twice; name it once", name));
        chosen.push_back(find(all, name, "integrator"));
    }
    return names.empty() ? std::vector<msm::Integrator>(all.begin(), all.end()) : chosen;
}

} // namespace livermark::studies
