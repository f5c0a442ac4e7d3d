#include <utility>

#include "msm/spring_law.hpp"

namespace livermark::msm {

SpringLaw law_of_tetrahedra(std::string summary, std::string source,
                            std::array<double, 6> (*of_tetrahedron)(const core::Body &, std::size_t)) {
    return {.name = {},
            .summary = std::move(summary),
            .source = std::move(source),
            .stiffness =
                [=](const core::Body &body, const core::EdgeTable &table) {
                    std::vector<double> stiffness(table.edges.size(), 0.0);
                    for (std::size_t t = 0; t < table.tetrahedron_edge.size(); ++t) {
                        const auto added = of_tetrahedron(body, t);
                        for (std::size_t e = 0; e < 6; ++e)
                            stiffness[table.tetrahedron_edge[t][e]] += added[e];
                    }
                    return stiffness;
                },
            .of_tetrahedron = of_tetrahedron};
}

} // namespace livermark::msm
