#pragma once

#include <optional>
#include <string>
#include <vector>

#include "models/model_table.hpp"

namespace livermark::studies {

/// What `livermark run` was asked for.
struct RunOptions {
    std::vector<std::string> bodies;
    std::vector<std::string> load_cases;
    std::vector<core::Regime> regimes{core::Regime::small}; ///< where load cases are not asked for by name
    bool has_asked_for_regime = false; ///< then load cases that are asked for by name have to be of these regimes
    std::vector<std::string> models;
    std::vector<double> amplitudes; ///< of the loads; as they are if there are none
    std::optional<double> young_modulus;
    std::vector<double> poisson_ratios; ///< of every region; as the bodies say if there are none
    std::string calibration;            ///< a file; none if empty
    std::string output;
    bool reference_on_mesh = false;
    bool solve_reference = false; ///< also where a solution is stored
    bool only_static = false;
    bool resume = false;
    bool may_leave_out = false; ///< also load case files of the user's own that do not fit a body
    std::optional<int> jobs; ///< load cases side by side, >= 1; as many as there are cores and memory for if not given
    models::ModelOptions model_options;
};

} // namespace livermark::studies
