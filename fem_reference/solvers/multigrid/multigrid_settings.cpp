#include "fem_reference/solvers/multigrid/multigrid_settings.hpp"

#include <ml_MultiLevelPreconditioner.h>

#include "fem_reference/solvers/multigrid/rigid_modes.hpp"

namespace livermark::fem_reference {

Teuchos::ParameterList multigrid_settings(std::vector<double> &modes) {
    Teuchos::ParameterList list;
    ML_Epetra::SetDefaults("SA", list);
    list.set("ML output", 0);
    list.set("PDE equations", 3);
    list.set("null space: type", "pre-computed");
    list.set("null space: dimension", RigidModes::count);
    list.set("null space: vectors", modes.data());
    list.set("aggregation: type", "Uncoupled");
    list.set("aggregation: threshold", 1e-4);
    list.set("smoother: type", "symmetric Gauss-Seidel");
    list.set("smoother: sweeps", 1);
    list.set("smoother: pre or post", "both");
    list.set("coarse: type", "Amesos-KLU");
    list.set("coarse: max size", 2000);
    return list;
}

} // namespace livermark::fem_reference
