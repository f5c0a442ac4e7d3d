#include "core/load_case.hpp"

namespace livermark::core {

LoadCase without_tractions(LoadCase load_case) {
    for (auto &condition : load_case.condition)
        if (condition == FacetCondition::traction)
            condition = FacetCondition::free;
    return load_case;
}

} // namespace livermark::core
