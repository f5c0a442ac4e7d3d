// bad_input_table, which scripts/golden calls for docs/studies/bad_input.md: runs livermark on every bad input and
// prints what it says, in Markdown.
#include <fmt/format.h>
#include <string>

#include "core/support/processes/child_process.hpp"
#include "tests/app/cli/bad_inputs/bad_inputs.hpp"

int main() {
    using namespace livermark::tests;
    std::size_t num_rows = 0;
    const auto groups = all_bad_inputs();
    for (const auto &group : groups)
        num_rows += group.rows.size();
    fmt::print(
        "# Bad input and its error messages\n\n"
        "This page lists {} wrong inputs and the message that `livermark` prints for each. In every case the program\n"
        "ends with exit status 2, prints one sentence on standard error (`livermark: ` stands before it) and leaves "
        "no\n"
        "new file. The tests `BadInputs` compare with this page to the letter. `scripts/golden` writes it.\n",
        num_rows);
    for (const auto &group : groups) {
        fmt::print("\n## {}\n\n| input | message |\n| --- | --- |\n", group.title);
        for (const auto &row : group.rows) {
            const livermark::support::ScratchFolder scratch;
            std::filesystem::permissions(scratch.path, std::filesystem::perms::others_all,
                                         std::filesystem::perm_options::add);
            prepare_bad_input(row, scratch.path);
            const auto end = try_bad_input(row, scratch.path);
            const auto lines = message_lines(end.errors);
            if (end.status != 2 || lines.size() != 1) {
                fmt::print(stderr, "bad_input_table: {} ends with status {}: {}\n", row.what, end.status, end.errors);
                return 1;
            }
            fmt::print("| {} | {} |\n", row.what, as_documented(lines[0], scratch.path));
        }
    }
    return 0;
}
