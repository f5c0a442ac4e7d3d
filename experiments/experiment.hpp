#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "experiments/fitted_motion.hpp"
#include "experiments/ring_down.hpp"

namespace livermark::experiments {

/// A point of a real body whose position was measured.
struct Marker {
    std::string name;
    core::Vector3 position = core::Vector3::Zero(); ///< at rest, in the frame of the body [m]
    std::string drives; ///< the patch that moves as this marker was measured; empty of a marker that is compared
};

/// A real body under one load, at rest.
struct MeasuredState {
    std::string name;
    /// Supports and loads on a mesh of the body; places that markers drive are held at zero.
    std::function<core::LoadCase(const core::TetraMesh &)> load_case;
    std::vector<core::Vector3> displacement; ///< (K) of each marker [m]; NaN where it was not seen
    double noise = 0.0; ///< root mean square length of the error of a marker's displacement [m]; 0 where unknown
};

/// What somebody did to a real body and measured, and what has to be assumed to compute it.
struct Experiment {
    std::string name, title;
    std::string source;                   ///< of the data: publication, and where the public file is
    std::vector<std::string> assumptions; ///< sentences on what the source does not say
    /// The body at about this length of edges [m]. A body of a mesh file has the edges of the file.
    std::function<core::Body(double edge_length)> body;
    /// How many tetrahedra that body has, about; empty of a mesh file.
    std::function<double(double edge_length)> expected_tetrahedra{};
    double edge_length = 0.0;    ///< that models are compared at [m]; 0 of a mesh file
    int fit_degree = 2;          ///< of the polynomials that driven places move by
    std::vector<Marker> markers; ///< (K)
    std::vector<MeasuredState> states;
    std::vector<RingDown> ring_downs{}; ///< of some states; damping is fitted on that of `damping_from` alone
    std::string damping_from{};         ///< the state of one of them; empty where there are none
};

/// An experiment whose data are public; python/livermark/studies/public_data.py reads them.
struct PublicExperiment {
    std::string name;
    std::string title; ///< one line
    std::string data;  ///< what has to be below data_folder(), a file or a folder
    std::string source;
};

/// Every public experiment, in alphabetical order.
std::span<const PublicExperiment> all_public_data();

/// Where the data are: the environment variable LIVERMARK_EXPERIMENTS, or ../shared/experiments beside the project.
std::filesystem::path data_folder();

/// Whether the data of an experiment are there.
bool has_data(const PublicExperiment &experiment);

/// Reads and checks the data of a public experiment.
/// @throws support::InputError if they are not there, with where to get them and where to put them; for a fault of them
Experiment read_public(const PublicExperiment &experiment);

/// Refuses what no experiment can be: markers outside the body by more than half of its thinnest side or displacements
/// larger than it, as of another unit or frame; numbers that are not finite where they are needed; fewer than three
/// markers to compare.
/// @param place  named in messages
/// @throws support::InputError
void check(const Experiment &experiment, const std::string &place);

/// The motion of each place that markers drive in a state.
/// @return by patch, in the order in which the markers name them
/// @throws support::InputError for fewer markers than the polynomial has coefficients
std::vector<PlaceMotion> driven_places(const Experiment &experiment, const MeasuredState &state);

/// A state on a body, with its driven places in motion.
core::Problem problem_of(const Experiment &experiment, const MeasuredState &state,
                         const std::shared_ptr<const core::Body> &body);

} // namespace livermark::experiments
