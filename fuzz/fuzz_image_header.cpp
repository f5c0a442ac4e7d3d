#include <array>

#include "fuzz/scratch_file.hpp"
#include "segmentation/images/image_bytes.hpp"
#include "segmentation/images/nifti_header.hpp"
#include "support/input_error.hpp"

/// What is looked at in an image before and after ITK reads it. The first byte says what the file is called.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size) {
    using namespace livermark::segmentation;
    if (size == 0)
        return 0;
    constexpr std::array endings{".nii", ".nii.gz", ".mha", ".mhd", ".nrrd", ".dcm"};
    const auto file = livermark::fuzz::as_file(data + 1, size - 1, endings.at(data[0] % endings.size()));
    constexpr double num_voxels = 64.0;
    try {
        check_text_of_header(file);
        if (const auto header = read_nifti_header(file)) {
            doubts_about_forms(*header);
            off_right_angles(header->sform);
        }
        check_all_there(file, num_voxels, num_voxels);
        check_dicom_pixels(file, static_cast<std::size_t>(num_voxels));
    } catch (const livermark::support::InputError &) { // what bad input has to come to
    }
    return 0;
}
