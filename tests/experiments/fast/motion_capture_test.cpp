#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <string>

#include "experiments/motion_capture.hpp"
#include "support/whole_file.hpp"
#include "tests/bad_input.hpp"
#include "tests/result_folder.hpp"

namespace livermark::experiments {
namespace {

struct C3dFile : tests::ResultFolder {
    static constexpr int num_markers = 3, num_frames = 4;
    std::filesystem::path file_;
    std::string bytes_ = std::string(2 * 512, '\0');

    template <class T> void put(std::size_t offset, T value) { std::memcpy(bytes_.data() + offset, &value, sizeof(T)); }
    void SetUp() override {
        ResultFolder::SetUp();
        file_ = directory_ / "motion.c3d";
        bytes_[0] = 2; // the parameters are in the second block
        bytes_[1] = 0x50;
        put<std::uint16_t>(2, num_markers);
        put<std::uint16_t>(6, 11); // first and last frame
        put<std::uint16_t>(8, 10 + num_frames);
        put<float>(12, -0.01F);
        put<std::uint16_t>(16, 3);
        put<float>(20, 100.0F);
        bytes_[512 + 3] = 84;
        for (int value = 0; value < num_markers * num_frames; ++value)
            for (const float number : {1.0F * value, 0.5F, -2.0F, 0.001F}) {
                bytes_.append(sizeof(float), '\0');
                put(bytes_.size() - sizeof(float), number);
            }
    }
    MotionCapture read() {
        support::write_whole(file_, bytes_);
        return read_motion_capture(file_);
    }
    void expect_refused(const std::string &fault) {
        tests::expect_input_error([&] { read(); }, {file_.string(), fault, "export"});
    }
};

TEST_F(C3dFile, HasPointsFrameByFrame) {
    const auto capture = read();
    EXPECT_EQ(capture.num_markers, num_markers);
    EXPECT_EQ(capture.num_frames(), num_frames);
    EXPECT_EQ(capture.frame_rate, 100.0);
    for (int f = 0; f < num_frames; ++f)
        for (int k = 0; k < num_markers; ++k)
            EXPECT_EQ(capture.at(f, k), core::Vector3(f * num_markers + k, 0.5, -2.0));
}

TEST_F(C3dFile, IsRefusedWhereItIsNone) {
    bytes_[1] = 'P' + 1;
    expect_refused("no C3D file");
    bytes_ = "frame,marker,x,y,z\n";
    expect_refused("no C3D file");
}

TEST_F(C3dFile, OfAnotherKindIsRefused) {
    const auto good = bytes_;
    bytes_[512 + 3] = 85;
    expect_refused("Intel");
    bytes_ = good;
    put<float>(12, 0.01F);
    expect_refused("integers");
    bytes_ = good;
    put<std::uint16_t>(4, 8);
    expect_refused("analog");
}

TEST_F(C3dFile, ThatIsDamagedIsRefused) {
    const auto good = bytes_;
    bytes_.resize(bytes_.size() - 1);
    expect_refused("ends before");
    bytes_ = good;
    put<std::uint16_t>(8, 65535);
    expect_refused("ends before");
    bytes_ = good;
    put<std::uint16_t>(8, 3); // before the first frame
    expect_refused("no frames");
    bytes_ = good;
    put<std::uint16_t>(16, 0);
    expect_refused("ends before");
    bytes_ = good;
    put<std::uint16_t>(2, 0);
    expect_refused("no points");
    bytes_ = good;
    bytes_[0] = 0;
    expect_refused("Intel");
    bytes_ = good;
    put<float>(20, std::numeric_limits<float>::quiet_NaN());
    expect_refused("rate");
}

TEST_F(C3dFile, WithAMarkerThatWasNotSeenIsRefused) {
    const auto good = bytes_;
    put<float>(2 * 512 + 16 * 4, std::numeric_limits<float>::quiet_NaN());
    expect_refused("point 1 was not seen in frame 1");
    bytes_ = good;
    put<float>(2 * 512 + 16 * 5 + 12, -1.0F); // how cameras say it
    expect_refused("point 2 was not seen in frame 1");
}

} // namespace
} // namespace livermark::experiments
