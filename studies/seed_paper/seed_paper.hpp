#pragma once

#include <string>
#include <vector>

#include "studies/parameters/body_parameters.hpp"
#include "studies/seed_paper/table_1.hpp"

/// What the seed paper prints in its Table 1, against what is computed.
namespace livermark::studies {

/// A number that a printed one could stand for.
struct Reading {
    std::string meaning;   ///< with its unit
    double printed = 0.0;  ///< the printed number, read in that unit [SI]
    double computed = 0.0; ///< what the body has [SI]

    double ratio() const { return printed / computed; }
};

/// A printed number beside all that it could stand for, and a sentence if it does not follow.
struct Claim {
    const PrintedQuantity *quantity;
    double printed = 0.0; ///< in the unit of the quantity
    std::vector<Reading> readings;
    std::string objection; ///< empty if it follows
};

/// The rows of the paper's table, compared with a body: the column with tumours for a body that has some.
std::vector<Claim> compare_with_paper(const BodyParameters &body);

} // namespace livermark::studies
