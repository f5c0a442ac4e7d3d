#include "results/tables/studies/modes_table.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numbers>

namespace livermark::results {

Layout modes_table(const Result &result, std::string_view reference) {
    const auto measure = std::ranges::find(result.modes, reference, &ModelModes::name);
    const auto is_compared = [&](const ModelModes &model) {
        return measure != result.modes.end() && model.name != measure->name;
    };
    Layout layout;
    layout.columns = {{"mode", true}};
    for (const auto &model : result.modes) {
        layout.columns.push_back({model.name + " [Hz]", true});
        if (is_compared(model)) {
            layout.columns.push_back({"error [%]", true});
            layout.columns.push_back({"MAC", true});
        }
    }
    for (int mode = 0; mode < result.modes.front().modes.count(); ++mode) {
        std::vector<std::string> row{std::to_string(mode + 1)};
        for (const auto &model : result.modes) {
            const double omega = model.modes.angular_frequency[mode];
            row.push_back(fixed(omega / (2.0 * std::numbers::pi), 4));
            if (is_compared(model)) {
                row.push_back(fixed(100.0 * (omega / measure->modes.angular_frequency[mode] - 1.0), 2));
                row.push_back(fixed(core::modal_assurance(result.problem.body->mesh, model.modes.shape_of(mode),
                                                          measure->modes.shape_of(mode)),
                                    3));
            }
        }
        layout.rows.push_back(std::move(row));
    }
    std::vector<std::string> seconds{"seconds"};
    for (const auto &model : result.modes) {
        seconds.push_back(fixed(model.modes.seconds, 2));
        if (is_compared(model))
            seconds.insert(seconds.end(), {"-", "-"});
    }
    layout.rows.push_back(std::move(seconds));
    return layout;
}

} // namespace livermark::results
