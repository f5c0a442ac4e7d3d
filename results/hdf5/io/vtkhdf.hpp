#pragma once

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/records/result.hpp"

namespace livermark::results {

/// Adds the group /VTKHDF, in which ParaView and VTK (>= 9.1) see the file as an unstructured grid with the
/// displacement and the error of every model. Where models moved, ParaView >= 5.12 and VTK >= 9.3 see the frames of
/// their motion as steps in time, and older ones the first. Points and fields are hard links to the datasets that are
/// in the file already. Format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/index.html, version
/// 1.0, with steps 2.0
void write_vtkhdf(hdf5::OutputFile &file, const Result &result);

} // namespace livermark::results
