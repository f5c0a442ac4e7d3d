#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "meshes/io/body_reader.hpp"
#include "studies/run/run_options.hpp"

/// Options that several commands have, with the same words.
namespace livermark::cli {

/// Bodies behind the command or behind --body, which is the same everywhere.
/// @param which  the end of the help: what happens where none is named, or what else a command takes
CLI::Option *add_bodies(CLI::App &command, std::vector<std::string> &bodies,
                        const std::string &which = "all that ship if none is named");

/// One body, in the same two ways.
CLI::Option *add_body(CLI::App &command, std::string &body);

/// What the help of every command says of a body.
inline constexpr const char *body_words = "a name as in 'livermark list bodies', or the path of a body .toml, of a "
                                          "mesh, or of a segmentation, which is meshed "
                                          "first: a label image (NIfTI, NRRD, MetaImage, DICOM) or closed surfaces "
                                          "(STL, OBJ, PLY, VTK, VTP), the liver and then "
                                          "its lesions; behind the command or behind --body";

/// --load-case of a command that takes constraints alone.
void add_constraints(CLI::App &command, std::string &load_case);

/// --young and --poisson
void add_materials(CLI::App &command, meshes::MaterialOverride &material);

/// --reference-on-mesh; its old name is refused.
void add_reference_on_mesh(CLI::App &command, bool &reference_on_mesh);

/// What to run, and how: --load-case, --regime, --model, --sweep, --poisson, --reference-on-mesh and --jobs
void add_run_choices(CLI::App &command, const std::shared_ptr<studies::RunOptions> &options);

/// In ascending order, each once.
std::vector<double> sorted_once(std::vector<double> values);

} // namespace livermark::cli
