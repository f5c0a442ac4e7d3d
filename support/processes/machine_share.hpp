#pragma once

#include <filesystem>

namespace livermark::support {

/// What this process may use of the machine.
struct MachineShare {
    int cores = 1;      ///< >= 1
    double bytes = 0.0; ///< of memory that new processes could have [byte]; infinite where the system does not say
};

/// The cores and the memory that are left to this process: of the machine, and of the control groups of Linux that it
/// is in, in which containers, batch systems and systemd put limits (cgroup v1 and v2). A group and those above it
/// count. Memory that a group has only as a cache of files is left.
/// @param root  where proc/ and the mounted control groups are: "/", or for a test a folder
MachineShare share_of_machine(const std::filesystem::path &root = "/");

} // namespace livermark::support
