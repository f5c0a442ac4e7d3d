#include "msm/implicit_integrators.hpp"

#include <algorithm>

namespace livermark::msm {

const std::vector<Integrator> &known_integrators() {
    static const auto all = [] {
        const auto explicit_ones = all_integrators(), implicit_ones = all_implicit_integrators();
        std::vector<Integrator> both(explicit_ones.begin(), explicit_ones.end());
        both.insert(both.end(), implicit_ones.begin(), implicit_ones.end());
        std::ranges::sort(both, {}, &Integrator::name);
        return both;
    }();
    return all;
}

const Integrator &find_known_integrator(const std::string &name) {
    return find_integrator(name, known_integrators());
}

} // namespace livermark::msm
