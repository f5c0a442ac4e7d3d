#include <filesystem>

#include "cli/segment.hpp"
#include "support/input_error.hpp"

namespace livermark::cli {

namespace {

[[noreturn]] void refuse() {
    throw support::InputError("this build has no ITK or no CGAL, which bodies of images and surfaces need; install "
                              "libinsighttoolkit5-dev and libcgal-dev, then configure and build again");
}

} // namespace

int make_body_of_labels(const SegmentCommand & /*command*/) {
    refuse();
}

int make_body_of_surfaces(const SegmentCommand & /*command*/) {
    refuse();
}

bool is_surface(const std::string &file) {
    const auto ending = std::filesystem::path(file).extension();
    return ending == ".stl" || ending == ".obj" || ending == ".ply" || ending == ".off" || ending == ".vtp";
}

std::string figures_of_labels(const std::string & /*file*/) {
    refuse();
}

std::string figures_of_surface(const std::string & /*file*/) {
    refuse();
}

int make_phantom(const PhantomCommand & /*command*/) {
    refuse();
}

} // namespace livermark::cli
