#pragma once

#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <string>
#include <unistd.h>

#include "core/problem.hpp"
#include "core/support/input_error.hpp"
#include "core/tool/needle/needle.hpp"
#include "load_cases/readers/load_case_reader.hpp"
#include "meshes/io/body_reader.hpp"

namespace livermark::tests {

/// Needles from anywhere on the surface of a body that ships to somewhere inside, as one would write them.
class RandomNeedles {
  public:
    struct One {
        core::Problem problem;
        core::Needle needle;
    };

    /// @param body  name of its file
    /// @param held  the patch that is held
    RandomNeedles(const std::string &body, std::string held, unsigned seed)
        : body_(std::make_shared<const core::Body>(meshes::read_body(std::filesystem::path(LIVERMARK_SOURCE_DIR) /
                                                                     "meshes" / fmt::format("{}.toml", body)))),
          held_(std::move(held)), random_(seed),
          file_(std::filesystem::path(testing::TempDir()) /
                fmt::format("random_needles_{}_{}_{}.toml", body, seed, getpid())) {}
    ~RandomNeedles() { std::filesystem::remove(file_); }
    RandomNeedles(const RandomNeedles &) = delete;
    RandomNeedles &operator=(const RandomNeedles &) = delete;

    /// The next that is not refused: others would leave the body, or begin where that is held.
    One next() {
        while (true) {
            std::ofstream(file_)
                << "title = \"Some needle\"\ntarget_peak_displacement = 0.01\n[[condition]]\npatch = \"" << held_
                << "\"\ndisplacement = [0.0, 0.0, 0.0]\n"
                << text();
            try {
                core::Problem problem{body_, load_cases::read_load_case(file_, body_->mesh)};
                auto needle = load_cases::read_needles(file_, *body_, problem.load_case).front();
                return {std::move(problem), std::move(needle)};
            } catch (const support::InputError &) {
                ++num_refused_;
            }
        }
    }

    int num_refused() const { return num_refused_; }
    double part() { return std::uniform_real_distribution<double>()(random_); }

  private:
    std::string text() {
        const auto &mesh = body_->mesh;
        std::uniform_int_distribution<int> facet(0, mesh.num_boundary_triangles() - 1);
        const auto &nodes = mesh.boundary_triangles[facet(random_)];
        const core::Vector3 entry = (mesh.points[nodes[0]] + mesh.points[nodes[1]] + mesh.points[nodes[2]]) / 3.0;
        const core::Vector3 normal = (mesh.points[nodes[1]] - mesh.points[nodes[0]])
                                         .cross(mesh.points[nodes[2]] - mesh.points[nodes[0]])
                                         .normalized();
        const core::Vector3 aside = normal.unitOrthogonal();
        const double depth = 0.012 + 0.04 * part();
        const core::Vector3 target = entry - depth * (normal + 0.5 * part() * aside);
        const double diameter = 5e-4 + 1.5e-3 * part(), toughness = 50.0 + 150.0 * part();
        const bool has_nick = part() < 0.5;
        const double surface = (has_nick ? 1.0 : 1.0 + 3.0 * part()) * diameter * toughness;
        return fmt::format("[[needle]]\nname = \"some\"\nentry = [{}, {}, {}]\ntarget = [{}, {}, {}]\ndiameter = {}\n"
                           "spread = {}\ntoughness = {}\nfriction = {}\npuncture_force = {}\nstep = 0.00025\n",
                           entry.x(), entry.y(), entry.z(), target.x(), target.y(), target.z(), diameter,
                           0.006 + 0.004 * part(), toughness, part() < 0.2 ? 0.0 : 20.0 * part(),
                           surface * (1.0 + 1e-9));
    }

    std::shared_ptr<const core::Body> body_;
    std::string held_;
    std::mt19937 random_;
    std::filesystem::path file_;
    int num_refused_ = 0;
};

} // namespace livermark::tests
