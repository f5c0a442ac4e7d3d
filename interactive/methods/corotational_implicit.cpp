#include <memory>

#include "interactive/elements/implicit_elements.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

/// The method of SOFA's demo of a liver, with rotations of polar decompositions in place of QR.
Method corotational_implicit() {
    return {
        .summary = "co-rotational linear tetrahedra, one linearised step of backward Euler by conjugate gradients",
        .source = "Mueller, Gross 2004, Interactive virtual materials, Graphics Interface; Baraff, Witkin 1998, Large "
                  "steps in cloth simulation, SIGGRAPH; Faure et al. 2012, SOFA, Springer",
        .energy = "mu |F - R|^2 + lambda / 2 tr(R^T F - 1)^2",
        .converges_to = "the linearised step of backward Euler; at rest the equilibrium of the energy",
        .objection = "The accuracy of conjugate gradients depends on iterations, tolerance and conditioning (manual of "
                     "SOFA, CGLinearSolver): 'livermark arena --mesh 1 --iterations 5 25 100 --method "
                     "corotational_implicit' shows how. A factor of an earlier step is a preconditioner that serves "
                     "non-homogeneous bodies (Courtecuisse et al. 2010, Asynchronous preconditioners, VRIPHYS); here "
                     "blocks of nodes are, add --body liver_tumours. Linear tetrahedra are too stiff near "
                     "incompressibility (sofa-framework/sofa#5751): 'livermark run --load-case palpation --model "
                     "corotational_implicit fem_p2 --poisson 0.3 0.49' shows it.",
        .implementation = "matrix-free, blocks of nodes as preconditioner, vector units, single precision",
        .iterations = 25, // the default of SOFA's CGLinearSolver
        .knows_contact = true,
        .prepare = [](const Scene &scene) { return std::make_unique<CorotationalTetrahedra>(scene); }};
}

} // namespace livermark::interactive::methods
