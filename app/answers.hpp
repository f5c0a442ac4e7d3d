#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/answer_folder.hpp"
#include "app/work_plan.hpp"

namespace livermark::app {

/// Lets models answer the problems of an item, and leaves the answers. What fails has none: the contest tries again,
/// and tells.
/// @param starting  called with the name of each model and what it is about to solve
void answer(const WorkItem &item, const std::vector<core::Model> &models, const std::vector<core::Problem> &problems,
            const AnswerFolder &folder,
            const std::function<void(const std::string &model, const std::string &about)> &starting);

/// Models that first look whether there is an answer to a problem.
/// @param number   of the problem that they will be asked for
/// @param folder   where answers are, nullptr if there are none
/// @param solving  called with the name of each model that has none, before it solves
std::vector<core::Model> with_answers(std::vector<core::Model> models, std::size_t number, const AnswerFolder *folder,
                                      const std::function<void(const std::string &)> &solving);

} // namespace livermark::app
