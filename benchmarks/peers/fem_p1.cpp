#include "benchmarks/peers/newmark_method.hpp"

namespace livermark::benchmarks::peers {

Competitor fem_p1() {
    return {.summary = "linear elasticity, linear tetrahedra, a step of Newmark's with a factor that is kept (CHOLMOD)",
            .source = "fem_reference/, with deal.II and SuiteSparse",
            .methods = {newmark_method(1, 1)}};
}

} // namespace livermark::benchmarks::peers
