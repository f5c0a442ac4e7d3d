#pragma once

#include <deal.II/base/partitioner.h>
#include <deal.II/lac/la_parallel_vector.h>

#include <memory>
#include <span>
#include <vector>

#include "fem_reference/distributed/part.hpp"

namespace livermark::fem_reference {

/// Between the numbers of a part, in the order of its system, and vectors of all ranks, in which each rank has those
/// that it owns. The components of an entry stand together in both.
class NodeExchange {
  public:
    using Vector = dealii::LinearAlgebra::distributed::Vector<double>;

    /// Collective: numbers what each rank owns, and asks for the numbers of the rest.
    /// @param entries  (n) of this rank's part
    NodeExchange(std::span<const SharedEntry> entries, int components);

    /// (n) of each entry among those of all ranks
    const std::vector<std::int64_t> &numbers() const { return number_; }
    /// Of this part that this rank owns.
    const std::vector<int> &owned() const { return owned_; }
    bool owns(std::size_t entry) const { return is_owned_[entry]; }
    std::int64_t num_entries_of_all_ranks() const;
    /// Of this part that other ranks own: as many come with every exchange.
    std::size_t num_received() const { return number_.size() - owned_.size(); }

    /// Zero.
    Vector vector() const { return Vector(partitioner_); }
    const std::shared_ptr<const dealii::Utilities::MPI::Partitioner> &partitioner() const { return partitioner_; }

    /// Collective. What is owned here and elsewhere, where the part has it.
    /// @param values  shape (components n)
    template <class T> void read(const Vector &vector, std::span<T> values) const;
    /// What is owned here.
    template <class T> void write(std::span<const T> values, Vector &vector) const;

    /// Collective. Overwrites what others own with what they have.
    /// @param values  shape (components n)
    void share(std::span<double> values) const;

  private:
    int components_;
    std::vector<std::int64_t> number_;
    std::vector<int> owned_;     ///< entries, in ascending order
    std::vector<bool> is_owned_; ///< (n)
    std::vector<int> place_;     ///< (n) in the vectors of this rank
    std::shared_ptr<const dealii::Utilities::MPI::Partitioner> partitioner_;
};

} // namespace livermark::fem_reference
