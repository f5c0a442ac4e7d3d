#include <algorithm>
#include <array>

#include "msm/kernels/layout/parting/parting.hpp"

namespace livermark::msm {

template <class T> void ForceSums<T>::finish(SlicedBody<T> &body) const {
    const int end_of_chunks = body.chunk_start.back();
    const auto num_pulls = static_cast<int>(body.mean_node.size());
    const int pulls_by = 4 * (body.first_pull - first_pull_), middles_by = pulls_by + 4 * (num_pulls - num_pulls_);
    const auto moved = [&](std::int32_t place) -> std::int32_t {
        if (place < 4 * end_of_chunks_)
            return place;
        if (place == 4 * end_of_chunks_)
            return 4 * end_of_chunks; // filling
        return place + (place < 4 * (first_pull_ + num_pulls_) ? pulls_by : middles_by);
    };
    std::vector<char> is_left_out; // of the places of control volumes before
    if (num_pulls_ > 0) {
        is_left_out.assign(static_cast<std::size_t>(num_pulls_) + body.volume_row.size(), 0);
        for (const int number : left_out_) {
            const int slice = number / slice_size, lane = number % slice_size;
            for (int line = body.mean_start[slice]; line < body.mean_start[slice + 1]; ++line)
                is_left_out[line * slice_size + lane] = 1;
            is_left_out[num_pulls_ + number] = 1;
        }
    }
    const auto stays = [&](std::int32_t place) {
        return place != 4 * end_of_chunks_ &&
               (is_left_out.empty() || place < 4 * first_pull_ || is_left_out[place / 4 - first_pull_] == 0);
    };
    auto added = added_;
    std::ranges::sort(added, {}, &std::pair<int, int>::first);
    std::vector<char> is_touched(static_cast<std::size_t>(body.num_slices), 0);
    for (const auto &[row, place] : added)
        is_touched[row / slice_size] = 1;
    for (const int row : looked_at_)
        is_touched[row / slice_size] = 1;
    std::vector<int> start{0};
    start.reserve(static_cast<std::size_t>(body.num_slices) + 1);
    Aligned<std::int32_t> sum;
    sum.reserve(body.sum.size() + slice_size * added.size() / 2);
    auto next = added.begin();
    std::array<std::vector<std::int32_t>, slice_size> lists;
    const auto num_before = static_cast<int>(body.sum_start.size()) - 1;
    for (int slice = 0; slice < body.num_slices; ++slice) {
        const bool is_old = slice < num_before;
        const auto first = is_old ? static_cast<std::size_t>(body.sum_start[slice]) * slice_size : 0;
        const auto end = is_old ? static_cast<std::size_t>(body.sum_start[slice + 1]) * slice_size : 0;
        if (is_touched[slice] == 0) {
            const std::size_t to = sum.size();
            sum.resize(to + end - first);
            std::transform(body.sum.begin() + static_cast<std::ptrdiff_t>(first),
                           body.sum.begin() + static_cast<std::ptrdiff_t>(end),
                           sum.begin() + static_cast<std::ptrdiff_t>(to), moved);
            start.push_back(static_cast<int>(sum.size()) / slice_size);
            continue;
        }
        std::size_t longest = 0;
        for (std::size_t lane = 0; lane < slice_size; ++lane) {
            auto &list = lists[lane];
            list.clear();
            for (std::size_t at = first + lane; at < end; at += slice_size)
                if (stays(body.sum[at]))
                    list.push_back(moved(body.sum[at]));
            for (const int row = slice * slice_size + static_cast<int>(lane); next != added.end() && next->first == row;
                 ++next)
                list.push_back(next->second);
            longest = std::max(longest, list.size());
        }
        const std::size_t at = sum.size();
        sum.resize(at + longest * slice_size, 4 * end_of_chunks);
        for (std::size_t lane = 0; lane < slice_size; ++lane)
            for (std::size_t k = 0; k < lists[lane].size(); ++k)
                sum[at + k * slice_size + lane] = lists[lane][k];
        start.push_back(static_cast<int>(sum.size()) / slice_size);
    }
    body.sum = std::move(sum);
    body.sum_start = std::move(start);
}

template class ForceSums<float>;
template class ForceSums<double>;

} // namespace livermark::msm
