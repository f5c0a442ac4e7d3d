#include "results/tables/studies/cut_table.hpp"

#include <algorithm>

#include "core/units.hpp"

namespace livermark::results {

namespace {

constexpr double square_centimetres = 1e4, millijoules = 1e3;

double difference_in_percent(double value, double reference) {
    return core::percent * (value / reference - 1.0);
}

double middle_of(std::vector<double> values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

} // namespace

Layout cut_table(const CutFile &file) {
    Layout table{{{"blade at [mm]", true},
                  {"cut [cm^2]", true},
                  {"opening [mm]", true},
                  {"stored [mJ]", true},
                  {"released [mJ]", true},
                  {"over area [J/m^2]", true},
                  {"left to the blade [mJ]", true},
                  {"time of the cut [ms]", true}},
                 {}};
    const auto &run = file.runs.front();
    double by_blade = 0.0;
    for (std::size_t k = 0; k < file.num_records(); ++k) {
        if (k > 0)
            by_blade += std::max(0.0, file.tearing(k) - file.tearing(k - 1) - run.released(k) + run.released(k - 1));
        table.rows.push_back({fixed(core::millimetres * file.depth[k], 1), fixed(square_centimetres * file.area[k], 2),
                              fixed(core::millimetres * run.opening[k], 3), fixed(millijoules * run.stored[k], 3),
                              fixed(millijoules * run.released(k), 3), fixed(file.release_rate(run, k), 3),
                              fixed(millijoules * by_blade, 2), fixed(core::milliseconds * file.cut_seconds[k], 0)});
    }
    return table;
}

Layout cut_models_table(const CutFile &file) {
    Layout table{{{"model"},
                  {"opening [mm]", true},
                  {"off by [%]", true},
                  {"released [mJ]", true},
                  {"off by [%]", true},
                  {"over area [J/m^2]", true},
                  {"time of an equilibrium [ms]", true}},
                 {}};
    const auto last = file.num_records() - 1;
    const auto &judge = file.runs.front();
    for (const auto &run : file.runs) {
        const bool judges = &run == &judge;
        table.rows.push_back({judges ? run.model + " (reference)" : run.model,
                              fixed(core::millimetres * run.opening[last], 3),
                              judges ? "-" : fixed(difference_in_percent(run.opening[last], judge.opening[last]), 1),
                              fixed(millijoules * run.released(last), 3),
                              judges ? "-" : fixed(difference_in_percent(run.released(last), judge.released(last)), 1),
                              fixed(run.released(last) / file.area[last], 3),
                              fixed(core::milliseconds * middle_of(run.solve_seconds), 0)});
    }
    return table;
}

} // namespace livermark::results
