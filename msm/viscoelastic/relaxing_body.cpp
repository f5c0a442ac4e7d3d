#include "msm/viscoelastic/relaxing_body.hpp"

#include <algorithm>
#include <utility>

namespace livermark::msm {

namespace {

/// The term as one that relaxes; null if it stays elastic.
std::shared_ptr<const RelaxingTerm> as_relaxing(const std::shared_ptr<const ElasticTerm> &term) {
    return std::dynamic_pointer_cast<const RelaxingTerm>(term);
}

} // namespace

ElasticBody relaxed(const ElasticBody &body, double part) {
    const auto of_term = [part](std::shared_ptr<const ElasticTerm> term) {
        if (const auto relaxing = as_relaxing(term))
            term = relaxing->relaxed(part, {});
        return term;
    };
    auto result = body;
    std::ranges::transform(body.terms, result.terms.begin(), of_term);
    result.preconditioner = of_term(body.preconditioner);
    return result;
}

RelaxingBody::RelaxingBody(ElasticBody body, core::PronySeries relaxation)
    : body_(std::move(body)), relaxation_(std::move(relaxation)) {
    for (std::size_t t = 0; t < body_.terms.size(); ++t)
        if (auto term = as_relaxing(body_.terms[t])) {
            auto &part = parts_.emplace_back();
            part.term = t;
            part.remains = term->relaxed(relaxation_.remaining(), {});
            part.compliance = term->relaxing_compliance();
            part.stress = Eigen::VectorXd::Zero(part.compliance.size());
            part.branches.assign(relaxation_.moduli.size(), part.stress);
            part.instant = std::move(term);
        }
}

ElasticBody RelaxingBody::after(double step) const {
    const auto steps = core::branch_steps(relaxation_, step);
    const double instant = core::instant_part(relaxation_, steps);
    auto result = relaxation_.is_elastic() ? body_ : ElasticBody(body_.node_mass, body_.terms);
    if (relaxation_.is_elastic())
        return result;
    for (const auto &part : parts_) {
        Eigen::VectorXd added = Eigen::VectorXd::Zero(part.stress.size());
        for (std::size_t k = 0; k < steps.size(); ++k)
            added += steps[k].fade * part.branches[k] - steps[k].gain * part.stress;
        result.terms[part.term] = part.instant->relaxed(instant, added);
    }
    return result;
}

void RelaxingBody::go_on(const Eigen::VectorXd &x, double step) {
    const auto steps = core::branch_steps(relaxation_, step);
    for (auto &part : parts_) {
        Eigen::VectorXd stress = part.instant->relaxing_stress(x);
        const Eigen::VectorXd change = stress - part.stress;
        for (std::size_t k = 0; k < steps.size(); ++k) {
            auto &branch = part.branches[k];
            const Eigen::VectorXd per_compliance = part.compliance.cwiseProduct(branch);
            dissipated_ += steps[k].dissipated(per_compliance.dot(branch), per_compliance.dot(change),
                                               part.compliance.cwiseProduct(change).dot(change));
            branch = steps[k].fade * branch + steps[k].gain * change;
        }
        part.stress = std::move(stress);
    }
}

void RelaxingBody::add_force(const Eigen::VectorXd &x, const Eigen::VectorXd &v, double beta,
                             Eigen::VectorXd &force) const {
    for (const auto &term : body_.terms)
        term->add_force(x, v, beta, force);
    for (const auto &part : parts_) {
        Eigen::VectorXd faded = (relaxation_.remaining() - 1.0) * part.stress;
        for (const auto &branch : part.branches)
            faded += branch;
        part.instant->add_force_of(x, faded, force);
    }
}

double RelaxingBody::stored_energy(const Eigen::VectorXd &x) const {
    double energy = 0.0;
    for (std::size_t t = 0; t < body_.terms.size(); ++t)
        if (std::ranges::find(parts_, t, &Part::term) == parts_.end())
            energy += body_.terms[t]->energy(x);
    const auto steps = core::branch_steps(relaxation_, 0.0);
    for (const auto &part : parts_) {
        energy += part.remains->energy(x);
        for (std::size_t k = 0; k < steps.size(); ++k)
            energy += steps[k].stored(part.compliance.cwiseProduct(part.branches[k]).dot(part.branches[k]));
    }
    return energy;
}

} // namespace livermark::msm
