#pragma once

#include <gmsh.h>

namespace livermark::meshes {

/// gmsh from start to end of a scope, silent and repeatable. After a meshing exception gmsh yields empty meshes until
/// it is finalised, so every mesh gets a session of its own. gmsh is global: one session at a time, in one thread.
struct GmshSession {
    GmshSession() {
        gmsh::initialize();
        gmsh::option::setNumber("General.Terminal", 0);
        gmsh::option::setNumber("General.NumThreads", 1); // more threads: another mesh at every run
        gmsh::option::setNumber("Mesh.Algorithm3D", 1);   // Delaunay, the one that is repeatable
        gmsh::model::add("body");
    }
    ~GmshSession() { gmsh::finalize(); }
    GmshSession(const GmshSession &) = delete;
    GmshSession &operator=(const GmshSession &) = delete;
};

} // namespace livermark::meshes
