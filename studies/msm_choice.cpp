#include "studies/msm_choice.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <span>

#include "msm/implicit_integrators.hpp"
#include "support/input_error.hpp"
#include "support/known_names.hpp"

namespace livermark::studies {

msm::SpringLaw find_spring_law(const std::string &name) {
    return support::find_named(msm::all_spring_laws(), name, "spring law");
}

std::vector<msm::Integrator> find_integrators(const std::vector<std::string> &names) {
    const std::span<const msm::Integrator> all = msm::known_integrators();
    std::vector<msm::Integrator> chosen;
    for (const auto &name : names) {
        if (std::ranges::find(chosen, name, &msm::Integrator::name) != chosen.end())
            throw support::InputError(fmt::format("integrator '{}' is asked for twice; name it once", name));
        chosen.push_back(support::find_named(all, name, "integrator"));
    }
    return names.empty() ? std::vector<msm::Integrator>(all.begin(), all.end()) : chosen;
}

} // namespace livermark::studies
