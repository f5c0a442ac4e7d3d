#include <fmt/format.h>
#include <limits>
#include <span>

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/node_numbers.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/solution_group.hpp"

namespace livermark::results {

namespace {

using hdf5::InputFile;

core::SolutionStatus read_status(const InputFile &file, const std::string &group) {
    const std::string word = file.text(group, "status");
    using enum core::SolutionStatus;
    for (const auto status : {ok, diverged, not_converged})
        if (word == core::to_string(status))
            return status;
    file.refuse(group, fmt::format("attribute status is '{}', which is none of ok, diverged, not_converged", word));
}

core::History read_history(const InputFile &file, const std::string &model, const core::Problem &problem) {
    const std::string group = history_group(model);
    const auto &load_case = problem.load_case;
    if (!load_case.release)
        file.refuse(group, "is there, and /load_case/release is not");
    core::History history;
    const std::size_t num_records = static_cast<std::size_t>(load_case.release->num_steps) + 1;
    history.setup_seconds = file.number(group, "setup_seconds");
    history.solve_seconds = file.number(group, "solve_seconds");
    history.integrator = file.text(group, "integrator");
    history.kernel = file.text(group, "kernel");
    if (file.has_attribute(group, "forces_per_step")) { // files of earlier versions have none
        const auto forces = file.integer(group, "forces_per_step");
        if (forces < 0 || forces > std::numeric_limits<int>::max())
            file.refuse(group, fmt::format("attribute forces_per_step is {}", forces));
        history.forces_per_step = static_cast<int>(forces);
    }
    history.time_step = file.number(group, "time_step");
    history.critical_time_step = file.number(group, "critical_time_step");
    history.diverged_at = file.number(group, "diverged_at");
    if (file.has_attribute(group, "observed_order"))
        history.observed_error = {.order = file.number(group, "observed_order"),
                                  .difference = file.number(group, "observed_difference"),
                                  .relative_l2 = file.number(group, "observed_l2")};
    history.time = file.dataset<double>(group + "/time", num_records);
    history.displacement =
        file.blocks<core::Vector3>(group + "/displacement", num_records, load_case.release->probes.size());
    history.kinetic_energy = file.dataset<double>(group + "/kinetic_energy", num_records);
    history.strain_energy = file.dataset<double>(group + "/strain_energy", num_records);
    if (file.has(frames_of(model))) // references that are kept have none
        history.frames = file.dataset<Eigen::Vector3f>(frames_of(model), num_frame_rows(problem));
    return history;
}

std::vector<core::PathPoint> read_path(const InputFile &file, const std::string &model, const core::Problem &problem) {
    const std::string group = path_group(model);
    const auto num_nodes = problem.body->mesh.points.size();
    const auto num_constraints = problem.load_case.num_constraints();
    const auto energy = file.dataset<double>(group + "/strain_energy");
    if (energy.empty() || energy.size() > problem.load_case.num_path_points())
        file.refuse(group, fmt::format("has {} points, and /load_case/path or /load_case/slow_history {}",
                                       energy.size(), problem.load_case.num_path_points()));
    const auto displacement = file.dataset<Eigen::Vector3f>(group + "/displacement", energy.size() * num_nodes);
    const auto reaction = file.blocks<core::Vector3>(group + "/reaction", energy.size(), num_constraints);
    const bool is_slow = problem.load_case.slow_history.has_value();
    std::vector<double> work, dissipated;
    if (is_slow) {
        work = file.dataset<double>(group + "/work", energy.size());
        dissipated = file.dataset<double>(group + "/dissipated_energy", energy.size());
    }
    std::vector<core::PathPoint> path;
    for (std::size_t k = 0; k < energy.size(); ++k) {
        const auto from = std::span(displacement).subspan(k * num_nodes, num_nodes);
        const auto held = std::span(reaction).subspan(k * num_constraints, num_constraints);
        path.push_back({{from.begin(), from.end()}, {held.begin(), held.end()}, energy[k]});
        if (is_slow) {
            path.back().work = work[k];
            path.back().dissipated_energy = dissipated[k];
        }
    }
    return path;
}

} // namespace

std::size_t num_frame_rows(const core::Problem &problem) {
    return static_cast<std::size_t>(problem.load_case.release->num_frames()) * problem.body->mesh.points.size();
}

core::Solution read_solution_group(const InputFile &file, const std::string &model, const core::Problem &problem) {
    const std::string group = solution_group(model);
    const std::size_t num_nodes = problem.body->mesh.points.size();
    core::Solution solution;
    solution.status = read_status(file, group);
    solution.message = file.text(group, "message");
    if (file.has_attribute(group, "solver")) // files of earlier versions have none
        solution.solver = file.text(group, "solver");
    solution.degrees_of_freedom = file.integer(group, "degrees_of_freedom");
    solution.setup_seconds = file.number(group, "setup_seconds");
    solution.solve_seconds = file.number(group, "solve_seconds");
    solution.strain_energy = file.number(group, "strain_energy");
    if (file.has_attribute(group, "load_work"))
        solution.load_work = file.number(group, "load_work");
    solution.nonlinearity = file.number(group, "nonlinearity");
    if (file.has_attribute(group, "critical_time_step"))
        solution.explicit_steps = {file.number(group, "critical_time_step"), file.number(group, "seconds_per_step"),
                                   file.text(group, "kernel")};
    if (file.has_attribute(group, "observed_order"))
        solution.observed_error = {.order = file.number(group, "observed_order"),
                                   .difference = file.number(group, "observed_difference"),
                                   .relative_l2 = file.number(group, "observed_l2"),
                                   .energy = file.number(group, "observed_energy"),
                                   .reaction = file.number(group, "observed_reaction")};
    if (file.has_attribute(group, "observed_load_fraction")) // files of earlier versions have none
        solution.observed_error.value().load_fraction = file.number(group, "observed_load_fraction");
    if (solution.observed_error && file.has_attribute(group, "observed_stiffness"))
        solution.observed_error->stiffness = file.number(group, "observed_stiffness");
    solution.displacement = file.dataset<core::Vector3>(group + "/displacement", num_nodes);
    solution.reaction = file.dataset<core::Vector3>(group + "/reaction", problem.load_case.num_constraints());
    if (file.texts(group + "/reaction", "patches") != problem.load_case.constraint_names())
        file.refuse(group + "/reaction", "attribute patches differs from the names of /load_case/constraint");
    if (file.has(group + "/edges")) {
        core::SpringNetwork &springs = solution.springs.emplace();
        springs.node_mass = file.dataset<double>(group + "/node_mass", num_nodes);
        springs.edges = hdf5::node_numbers<2>(file, group + "/edges", num_nodes);
        springs.stiffness = file.dataset<double>(group + "/stiffness", springs.edges.size());
        springs.rest_length = file.dataset<double>(group + "/rest_length", springs.edges.size());
    }
    if (file.has(path_group(model)))
        solution.path = read_path(file, model, problem);
    if (file.has(group + "/history"))
        solution.history = read_history(file, model, problem);
    return solution;
}

} // namespace livermark::results
