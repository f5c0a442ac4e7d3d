#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <span>
#include <vector>

namespace livermark::msm {

/// Room for as much and what some cuts add. Memory is not touched before it is needed.
constexpr std::size_t with_room(std::size_t size) {
    return size + size / 4;
}

/// Lists of numbers behind each other, of each node its tetrahedra, say. A list that becomes another one goes to the
/// end, so that to change a few costs no more than these.
class NumberLists {
  public:
    NumberLists() = default;

    /// Of each number, the things that have it, ascending.
    /// @param numbers  shape (things), of each thing the numbers that it has, below count
    template <std::size_t n> NumberLists(const std::vector<std::array<int, n>> &numbers, std::size_t count) {
        start_.assign(count, 0);
        size_.assign(count, 0);
        for (const auto &of_thing : numbers)
            for (const int number : of_thing)
                ++size_[number];
        for (std::size_t i = 1; i < count; ++i)
            start_[i] = start_[i - 1] + size_[i - 1];
        entries_.resize(n * numbers.size());
        auto next = start_;
        for (std::size_t thing = 0; thing < numbers.size(); ++thing)
            for (const int number : numbers[thing])
                entries_[next[number]++] = static_cast<int>(thing);
    }

    std::size_t size() const { return start_.size(); } ///< how many lists there are
    std::span<const int> of(int number) const { return std::span(entries_).subspan(start_[number], size_[number]); }

    /// @param list  not a part of these lists, unless it is no longer than the one that it replaces
    void set(int number, std::span<const int> list) {
        if (list.size() > size_[number]) {
            start_[number] = entries_.size();
            entries_.insert(entries_.end(), list.begin(), list.end());
        } else {
            std::copy(list.begin(), list.end(), entries_.begin() + static_cast<std::ptrdiff_t>(start_[number]));
        }
        size_[number] = list.size();
    }

    /// Room for lists that become others, without moving those that are there.
    void leave_room() { entries_.reserve(with_room(entries_.size())); }

    /// Adds empty lists until there are so many.
    void resize(std::size_t count) {
        start_.resize(count, 0);
        size_.resize(count, 0);
    }

  private:
    std::vector<std::size_t> start_, size_;
    std::vector<int> entries_;
};

/// Lists of new things, which get their entries in turn.
class NewLists {
  public:
    void add(int number, int entry) { of_[number].push_back(entry); }
    void put_into(NumberLists &lists) const {
        for (const auto &[number, list] : of_)
            lists.set(number, list);
    }

  private:
    std::map<int, std::vector<int>> of_;
};

/// Leaves those things in a list that still have its number.
/// @param numbers  shape (things), of each thing the numbers that it has
template <std::size_t n>
void leave_owners(int number, const std::vector<std::array<int, n>> &numbers, NumberLists &lists) {
    std::vector<int> left;
    for (const int thing : lists.of(number))
        if (std::ranges::find(numbers[thing], number) != numbers[thing].end())
            left.push_back(thing);
    lists.set(number, left);
}

/// Numbers of what a cut has changed, as in StepParts, each ascending and once.
struct CutChanges {
    std::vector<int> tetrahedra; ///< that are gone
    std::vector<int> nodes;      ///< corners of these: their masses
    std::vector<int> springs;    ///< edges of these: their stiffness
    std::vector<int> volumes;    ///< control volumes that have lost some of their volume
    std::vector<int> edge_parts; ///< means around edges that have lost tetrahedra
};

/// What a blade without thickness does: all tetrahedra stay, and some have other nodes, which are in the places of
/// those before.
struct Parting {
    std::vector<int> tetrahedra;           ///< that have other nodes, ascending
    std::vector<std::array<int, 4>> nodes; ///< all nodes of these from now on; new ones are numbered from N on
    std::vector<int> parent_node;          ///< of each new node, the one before from which it is parted
};

/// Numbers of what a parting has changed, as in StepParts, each ascending and once. What is new is numbered behind what
/// was there.
struct PartingChanges {
    std::vector<int> tetrahedra;   ///< that have other nodes
    std::vector<int> parent_node;  ///< of each new node
    std::vector<int> nodes;        ///< parents, and new nodes: their masses
    std::vector<int> springs;      ///< edges that have lost tetrahedra, and new ones; of laws that look at the whole
                                   ///< body, all
    std::vector<int> gone_springs; ///< of these, those that have lost the last one
    int first_new_spring = 0;
    std::vector<int> volumes;    ///< control volumes around a node of these tetrahedra, before or now
    std::vector<int> edge_parts; ///< means around an edge of these tetrahedra, before or now
    /// Of each new part around an edge, the one before whose tetrahedra it has
    std::vector<int> parent_edge_part;
};

} // namespace livermark::msm
