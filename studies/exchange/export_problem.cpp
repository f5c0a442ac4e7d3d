#include "studies/exchange/export_problem.hpp"

#include <fmt/format.h>
#include <sstream>
#include <type_traits>

#include "results/hdf5/result_file.hpp"
#include "results/provenance.hpp"
#include "studies/exchange/formats/calculix_input.hpp"
#include "studies/exchange/formats/vtu_output.hpp"
#include "studies/files.hpp"
#include "studies/run/problems.hpp"
#include "support/files.hpp"
#include "support/input_error.hpp"

namespace livermark::studies {

ExportedProblem export_problem(const ExportOptions &options, const std::string &command_line) {
    auto [problems, notes, left_out] = read_scaled_problems({options.body}, options.load_case, {});
    const auto &problem = problems.front();
    core::for_each_event(problem.load_case, [&](const auto &event) {
        using Kind = std::decay_t<decltype(event)>;
        if constexpr (!Kind::in_time)
            throw support::InputError(fmt::format("load case {} has {}, which the exported files cannot describe; "
                                                  "choose one without a [{}]",
                                                  problem.load_case.name, Kind::noun, Kind::key));
    });
    const OutputFolder folder(std::filesystem::path(options.output) / problem.body->name);
    ExportedProblem exported{{}, std::move(notes)};
    const auto file = [&](const char *extension) {
        return exported.files.emplace_back(folder.path() / (problem.load_case.name + extension));
    };

    results::Result result;
    result.provenance = results::current_provenance(command_line);
    result.problem = problem;
    results::write_result(file(".problem.h5"), result);
    std::ostringstream inp, vtu;
    write_inp(inp, problem, options.quadratic ? 2 : 1);
    support::write_whole(file(".inp"), inp.str());
    write_vtu(vtu, problem);
    support::write_whole(file(".vtu"), vtu.str());
    return exported;
}

} // namespace livermark::studies
