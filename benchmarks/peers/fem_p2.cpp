#include "benchmarks/peers/newmark_method.hpp"

namespace livermark::benchmarks::peers {

Competitor fem_p2() {
    return {.summary =
                "linear elasticity, quadratic tetrahedra, a step of Newmark's with a factor that is kept (CHOLMOD)",
            .source = "fem_reference/, with deal.II and SuiteSparse",
            .methods = {newmark_method(2, 0)}};
}

} // namespace livermark::benchmarks::peers
