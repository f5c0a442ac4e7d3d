#pragma once

#include "results/hdf5_io.hpp"
#include "results/result.hpp"

/// What every file that Livermark writes has in common. Internal to results/.
namespace livermark::results::hdf5 {

/// The attributes of the root that say where a file comes from.
void write_provenance(OutputFile &file, const Provenance &provenance);

} // namespace livermark::results::hdf5
