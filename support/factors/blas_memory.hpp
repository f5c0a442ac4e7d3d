#pragma once

namespace livermark::support {

/// Lets BLAS take its memory now if it has none yet in this process. OpenBLAS takes 128 MiB when it is called first,
/// and tries again for ever where it gets none.
/// @throws std::bad_alloc if there is not so much
void reserve_blas_memory();

} // namespace livermark::support
