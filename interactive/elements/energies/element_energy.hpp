#pragma once

#include <utility>

#include "interactive/elements/energies/densities.hpp"
#include "interactive/energy.hpp"

namespace livermark::interactive {

/// Adds V dN : dP/dF : dN of a tetrahedron.
void add_tangent(const Tetrahedron &tetrahedron, const densities::Tangent &tangent, Energy::Triplets &triplets);

/// W = sum over the tetrahedra of V times a density of densities.hpp.
template <class Density> class ElementEnergy : public Energy {
  public:
    explicit ElementEnergy(std::vector<Tetrahedron> tetrahedra) : tetrahedra_(std::move(tetrahedra)) {}

    double value(const Field &x) const override {
        double value = 0.0;
        for (const auto &t : tetrahedra_)
            value += t.volume * Density{t.mu, t.lambda}.value(t.gradient(x));
        return value;
    }

    void add_forces(const Field &x, Field &f) const override {
        for (const auto &t : tetrahedra_)
            t.add_forces(Density{t.mu, t.lambda}.stress(t.gradient(x)), f);
    }

    void add_hessian(const Field &x, bool is_projected, Triplets &triplets) const override {
        triplets.reserve(triplets.size() + 144 * tetrahedra_.size());
        for (const auto &t : tetrahedra_) {
            const densities::Tangent tangent = Density{t.mu, t.lambda}.tangent(t.gradient(x));
            add_tangent(t, is_projected ? densities::semi_definite_part(tangent) : tangent, triplets);
        }
    }

    const std::vector<Tetrahedron> &tetrahedra() const { return tetrahedra_; }

  private:
    std::vector<Tetrahedron> tetrahedra_;
};

} // namespace livermark::interactive
