#include "cli/segment.hpp"
#include "support/input_error.hpp"

namespace livermark::cli {

namespace {

[[noreturn]] int refuse() {
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

int make_phantom(const PhantomCommand & /*command*/) {
    refuse();
}

} // namespace livermark::cli
