#include <memory>

#include "interactive/elements/corotational_tetrahedra.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// SOFA's default for soft tissue.
Method corotational_implicit() {
    return {.name = {},
            .summary = "co-rotational linear tetrahedra, one linearised step of backward Euler by conjugate gradients",
            .source =
                "Mueller, Gross 2004, Interactive virtual materials, Graphics Interface; Baraff, Witkin 1998, Large "
                "steps in cloth simulation, SIGGRAPH; Faure et al. 2012, SOFA, Springer",
            .energy = "mu |F - R|^2 + lambda / 2 tr(R^T F - 1)^2",
            .converges_to = "the linearised step of backward Euler; at rest the equilibrium of the energy",
            .objection = "Users of SOFA would end conjugate gradients at a tolerance, and precondition them with a "
                         "factor that is renewed now and then, which serves hard inclusions better than blocks of "
                         "nodes.",
            .implementation = "matrix-free, blocks of nodes as preconditioner, vector units, single precision",
            .in_double = "plain loop over tetrahedra, matrix-free, blocks of nodes as preconditioner, double",
            .time_step = frame_time,
            .iterations = 25, // the default of SOFA's CGLinearSolver
            .knows_contact = true,
            .prepare = [](const Scene &scene) {
                return std::make_unique<CorotationalTetrahedra>(scene, Preconditioner::blocks);
            }};
}

} // namespace livermark::interactive::methods
