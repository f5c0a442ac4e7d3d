#include <algorithm>
#include <cmath>

#include "results/hdf5/io/hdf5_io.hpp"
#include "results/hdf5/io/schema.hpp"
#include "results/hdf5/solution_group.hpp"

namespace livermark::results {

namespace {

void write_history(hdf5::OutputFile &file, const std::string &model, const core::History &history,
                   const core::Release &release) {
    const std::string group = history_group(model);
    file.group(group);
    file.number(group, "setup_seconds", history.setup_seconds);
    file.number(group, "solve_seconds", history.solve_seconds);
    file.text(group, "integrator", history.integrator);
    file.text(group, "kernel", history.kernel);
    file.integer(group, "forces_per_step", history.forces_per_step);
    file.number(group, "time_step", history.time_step);
    file.number(group, "critical_time_step", history.critical_time_step);
    file.number(group, "diverged_at", history.diverged_at);
    if (const auto &error = history.observed_error) {
        file.number(group, "observed_order", error->order);
        file.number(group, "observed_difference", error->difference);
        file.number(group, "observed_l2", error->relative_l2);
    }
    file.dataset(group + "/time", history.time, "s");
    file.blocks(group + "/displacement", history.displacement, release.probes.size(), "m");
    file.dataset(group + "/kinetic_energy", history.kinetic_energy, "J");
    file.dataset(group + "/strain_energy", history.strain_energy, "J");
    if (!history.frames.empty())
        file.dataset(frames_of(model), history.frames, "m");
}

void write_path(hdf5::OutputFile &file, const std::string &model, const std::vector<core::PathPoint> &path,
                bool is_slow) {
    const std::string group = path_group(model);
    std::vector<Eigen::Vector3f> displacement;
    std::vector<core::Vector3> reaction;
    std::vector<double> strain_energy, work, dissipated;
    for (const auto &point : path) {
        displacement.insert(displacement.end(), point.displacement.begin(), point.displacement.end());
        reaction.insert(reaction.end(), point.reaction.begin(), point.reaction.end());
        strain_energy.push_back(point.strain_energy);
        work.push_back(point.work);
        dissipated.push_back(point.dissipated_energy);
    }
    file.group(group);
    file.dataset(group + "/displacement", displacement, "m");
    file.blocks(group + "/reaction", reaction, path.front().reaction.size(), "N");
    file.dataset(group + "/strain_energy", strain_energy, "J");
    if (!is_slow)
        return;
    file.dataset(group + "/work", work, "J");
    file.dataset(group + "/dissipated_energy", dissipated, "J");
}

/// The springs of models are often the same in all but one field: what an earlier model has gets a second name.
template <class Rows>
void write_spring_field(hdf5::OutputFile &file, const NamedSprings &model, std::span<const NamedSprings> earlier,
                        Rows core::SpringNetwork::*field, const std::string &name, const std::string &units) {
    const Rows &rows = model.springs->*field;
    const auto same = std::ranges::find_if(earlier, [&](const auto &other) { return other.springs->*field == rows; });
    if (same != earlier.end())
        file.hard_link(same->group + name, model.group + name);
    else
        file.dataset(model.group + name, rows, units);
}

} // namespace

void write_springs(hdf5::OutputFile &file, const NamedSprings &model, std::span<const NamedSprings> earlier) {
    using Springs = core::SpringNetwork;
    write_spring_field(file, model, earlier, &Springs::node_mass, "/node_mass", "kg");
    write_spring_field(file, model, earlier, &Springs::edges, "/edges", "");
    write_spring_field(file, model, earlier, &Springs::stiffness, "/stiffness", "N/m");
    write_spring_field(file, model, earlier, &Springs::rest_length, "/rest_length", "m");
}

void write_solution_group(hdf5::OutputFile &file, const std::string &model, const core::Solution &solution,
                          const core::LoadCase &load_case) {
    const std::string group = solution_group(model);
    file.group(group);
    file.text(group, "status", core::to_string(solution.status));
    file.text(group, "message", solution.message);
    file.text(group, "solver", solution.solver);
    file.integer(group, "degrees_of_freedom", solution.degrees_of_freedom);
    file.number(group, "setup_seconds", solution.setup_seconds);
    file.number(group, "solve_seconds", solution.solve_seconds);
    file.number(group, "strain_energy", solution.strain_energy);
    if (!std::isnan(solution.load_work))
        file.number(group, "load_work", solution.load_work);
    file.number(group, "nonlinearity", solution.nonlinearity);
    if (const auto &steps = solution.explicit_steps) {
        file.number(group, "critical_time_step", steps->critical_time_step);
        file.number(group, "seconds_per_step", steps->seconds_per_step);
        file.text(group, "kernel", steps->kernel);
    }
    if (const auto &error = solution.observed_error) {
        file.number(group, "observed_order", error->order);
        file.number(group, "observed_difference", error->difference);
        file.number(group, "observed_l2", error->relative_l2);
        file.number(group, "observed_energy", error->energy);
        file.number(group, "observed_reaction", error->reaction);
        file.number(group, "observed_load_fraction", error->load_fraction);
        if (error->stiffness)
            file.number(group, "observed_stiffness", *error->stiffness);
    }
    file.dataset(group + "/displacement", solution.displacement, "m");
    file.dataset(group + "/reaction", solution.reaction, "N");
    file.texts(group + "/reaction", "patches", load_case.constraint_names());
    if (!solution.path.empty())
        write_path(file, model, solution.path, load_case.slow_history.has_value());
    if (solution.history)
        write_history(file, model, *solution.history, load_case.release.value());
}

} // namespace livermark::results
