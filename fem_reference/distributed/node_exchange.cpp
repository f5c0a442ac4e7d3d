#include "fem_reference/distributed/node_exchange.hpp"

#include <deal.II/base/mpi.h>

#include <algorithm>
#include <map>
#include <stdexcept>
#include <utility>

#include "support/processes/mpi_session.hpp"

namespace livermark::fem_reference {

namespace {

using Numbers = std::vector<std::int64_t>;

/// What each rank counts before this one, and all together.
std::pair<std::int64_t, std::int64_t> sums_of_ranks(std::int64_t mine) {
    std::int64_t before = 0, all = 0;
    MPI_Exscan(&mine, &before, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    MPI_Allreduce(&mine, &all, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
    return {support::mpi_rank() == 0 ? 0 : before, all};
}

dealii::IndexSet with_components(dealii::IndexSet::size_type size, const Numbers &entries, int components) {
    dealii::IndexSet set(components * size);
    for (const auto entry : entries)
        set.add_range(components * entry, components * (entry + 1));
    set.compress();
    return set;
}

} // namespace

NodeExchange::NodeExchange(std::span<const SharedEntry> entries, int components) : components_(components) {
    const int rank = support::mpi_rank();
    is_owned_.resize(entries.size());
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (is_owned_[i] = entries[i].owner == rank; is_owned_[i])
            owned_.push_back(static_cast<int>(i));
    const auto [before, all] = sums_of_ranks(static_cast<std::int64_t>(owned_.size()));

    std::map<unsigned int, Numbers> questions; // keys, one behind the other
    std::map<unsigned int, std::vector<std::size_t>> asked;
    for (std::size_t i = 0; i < entries.size(); ++i)
        if (!is_owned_[i]) {
            auto &keys = questions[entries[i].owner];
            keys.insert(keys.end(), entries[i].key.begin(), entries[i].key.end());
            asked[entries[i].owner].push_back(i);
        }
    number_.resize(entries.size());
    std::vector<std::pair<std::array<std::int64_t, 2>, std::int64_t>> known;
    for (std::size_t k = 0; k < owned_.size(); ++k) {
        number_[owned_[k]] = before + static_cast<std::int64_t>(k);
        known.emplace_back(entries[owned_[k]].key, number_[owned_[k]]);
    }
    std::ranges::sort(known);
    std::map<unsigned int, Numbers> answers;
    for (const auto &[asking, keys] : dealii::Utilities::MPI::some_to_some(MPI_COMM_WORLD, questions))
        for (std::size_t k = 0; k < keys.size(); k += 2) {
            const std::array key{keys[k], keys[k + 1]};
            const auto found = std::ranges::lower_bound(known, key, {}, [](const auto &entry) { return entry.first; });
            if (found == known.end() || found->first != key)
                throw std::logic_error("a rank was asked for a node that it does not own");
            answers[asking].push_back(found->second);
        }
    Numbers others;
    for (const auto &[owner, numbers] : dealii::Utilities::MPI::some_to_some(MPI_COMM_WORLD, answers))
        for (std::size_t k = 0; k < numbers.size(); ++k) {
            number_[asked.at(owner)[k]] = numbers[k];
            others.push_back(numbers[k]);
        }
    std::ranges::sort(others);

    if (all == 0) { // deal.II divides by it
        partitioner_ = std::make_shared<const dealii::Utilities::MPI::Partitioner>();
        return;
    }
    dealii::IndexSet mine(components * all);
    mine.add_range(components * before, components * (before + static_cast<std::int64_t>(owned_.size())));
    partitioner_ = std::make_shared<const dealii::Utilities::MPI::Partitioner>(
        mine, with_components(all, others, components), MPI_COMM_WORLD);
    for (const auto number : number_)
        place_.push_back(static_cast<int>(partitioner_->global_to_local(components * number)));
}

std::int64_t NodeExchange::num_entries_of_all_ranks() const {
    return static_cast<std::int64_t>(partitioner_->size()) / components_;
}

template <class T> void NodeExchange::read(const Vector &vector, std::span<T> values) const {
    vector.update_ghost_values();
    const double *const from = vector.begin();
    for (std::size_t i = 0; i < place_.size(); ++i)
        for (int c = 0; c < components_; ++c)
            values[components_ * i + c] = static_cast<T>(from[place_[i] + c]);
    vector.zero_out_ghost_values();
}

template <class T> void NodeExchange::write(std::span<const T> values, Vector &vector) const {
    double *const to = vector.begin();
    for (const int i : owned_)
        for (int c = 0; c < components_; ++c)
            to[place_[i] + c] = static_cast<double>(values[components_ * i + c]);
}

template void NodeExchange::read(const Vector &, std::span<double>) const;
template void NodeExchange::read(const Vector &, std::span<float>) const;
template void NodeExchange::write(std::span<const double>, Vector &) const;
template void NodeExchange::write(std::span<const float>, Vector &) const;

void NodeExchange::share(std::span<double> values) const {
    auto whole = vector();
    write<double>(values, whole);
    read<double>(whole, values);
}

} // namespace livermark::fem_reference
