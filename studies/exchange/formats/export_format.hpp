#pragma once

#include <filesystem>
#include <iosfwd>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"
#include "core/problem.hpp"

/// Problems as other programs read them. Node i of the mesh is node i + 1 in each format that counts from 1, and
/// tetrahedron t is element t + 1; lengths are metres, forces newtons.
namespace livermark::exchange {

/// Choices of an export that not every format has.
struct ExportChoices {
    bool quadratic = false; ///< quadratic tetrahedra with straight edges
};

/// One file of a format: its ending, and the text of a problem.
struct ExportedFile {
    const char *ending; ///< with its dot
    void (*write)(std::ostream &, const core::Problem &, const ExportChoices &);
};

/// Kind of a part of a problem that no nodal forces can say.
enum class FurtherKind {
    plain_ball, ///< see is_plain_ball()
    foundation, ///< of the load case
    capsule,    ///< of the body
    vessels,    ///< of the body
    map,        ///< moduli of tetrahedra, see core::Body::modulus_factor
    other       ///< which no job knows
};

/// Elements of a job, and how far they go.
struct JobKind {
    core::Regime regime = core::Regime::small;
    bool quadratic = false;

    bool operator==(const JobKind &) const = default;
};

/// A format in which `livermark export` writes problems at rest. One file each in formats/, named as the format.
struct ExportFormat {
    std::string name; ///< the file stem; set by the table
    const char *summary;
    std::vector<ExportedFile> files;
    bool only_when_named = false;
    /// Whether a job of a program has a part; files that are a job are left out where one cannot say all that acts on
    /// the body. Null where it is no job: what is more than a mesh, prescribed displacements and nodal forces is left
    /// to the .problem.h5.
    bool (*job_has)(FurtherKind, const JobKind &) = nullptr;
    const char *capsule_in_job = nullptr; ///< what a job has in place of a membrane, for a note; null where it has one
};

/// Whether a tool is one ball that presses without friction and does not slide.
inline bool is_plain_ball(const core::TouchingTool &tool) {
    return !tool.shape.is_plate() && !tool.between && tool.friction == 0.0 && tool.slide.isZero(0.0);
}

/// Every format of formats/, in alphabetical order.
std::span<const ExportFormat> all_formats();

/// Nodes of elements and facets in the order of CalculiX and Abaqus, counted from 0: those of the mesh, then the
/// middles of the edges of core::edge_table.
struct Discretisation {
    std::vector<core::Vector3> points;      ///< (n) [m]
    std::vector<std::vector<int>> elements; ///< (M) 4 or 10 nodes
    std::vector<std::vector<int>> facets;   ///< (T) 3 corners, then 3 midpoints
};

/// @param degree  1 or 2
Discretisation discretise(const core::TetraMesh &mesh, int degree);

/// The value that each component of each node is constrained at, NaN where it is free. Where constraints meet, the one
/// of lowest index wins, as it does for every model.
/// @return shape (n) [m]
std::vector<core::Vector3> prescribed_displacement(const core::LoadCase &load_case, const Discretisation &fem);

/// A constant traction on a straight triangle acts in thirds on the corners of linear elements; of quadratic ones the
/// corners' shape functions have no mean over a face, and the midpoints get a third each. Where a place presses, these
/// are the forces of one newton of it.
/// @return shape (n) [N]
std::vector<core::Vector3> traction_forces(const core::TetraMesh &mesh, const core::LoadCase &load_case,
                                           const Discretisation &fem);

/// These and the acceleration on linear tetrahedra, whose weight acts in quarters on their corners.
/// @return shape (n) [N]
std::vector<core::Vector3> nodal_forces(const core::Problem &problem, const Discretisation &fem);

} // namespace livermark::exchange

namespace livermark::studies {

/// The solution of a static problem by a model outside of this suite: where its nodes are, and how far they move.
struct OutsideSolution {
    std::vector<core::Vector3> points;       ///< (K) at rest [m]
    std::vector<core::Vector3> displacement; ///< (K) [m]
};

/// Reads a solution: CSV with the header x,y,z,ux,uy,uz and a line for each node [m]; or, after
/// scripts/convert_solution, HDF5 with the datasets points and displacement, or VTU and what else meshio reads, with
/// the point data displacement.
/// @throws support::InputError with file, line and remedy
OutsideSolution read_outside_solution(const std::filesystem::path &file);

/// The same from the text of a CSV. The name is for messages.
OutsideSolution parse_outside_solution(const std::string &text, const std::string &file);

/// The displacement of each node of a mesh, whatever the order of the solution. Points that are no nodes, such as edge
/// midpoints, are passed over.
/// @param file  named in messages
/// @return shape (N) [m]
/// @throws support::InputError if a node is not among the points, or with two displacements: the solution belongs to
///   another problem, or is in another unit, which is named if it is plain
std::vector<core::Vector3> displacement_at_nodes(const OutsideSolution &solution, const core::TetraMesh &mesh,
                                                 const std::string &file);

} // namespace livermark::studies
