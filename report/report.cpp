#include "report/report.hpp"

#include "report/html.hpp"
#include "report/style.hpp"

namespace livermark::report {

std::string make_report(const ReportData &data, const std::vector<PaperTable> &paper, const std::string &command_line) {
    return page("Livermark report", style_sheet,
                head(data) + errors_section(data) + large_section(data) + cohort_section(data) +
                    pictures_section(data) + cost_section(data) + poisson_section(data) + refinement_section(data) +
                    steps_section(data) + timings_section(data) + paper_section(data, paper) +
                    appendix(data, command_line));
}

} // namespace livermark::report
