#include "fem_reference/solvers/two_level.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Epetra_CrsMatrix.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>
#include <Teuchos_ParameterList.hpp>
#include <algorithm>
#include <ml_MultiLevelPreconditioner.h>
#include <stdexcept>
#include <vector>

#ifdef HAVE_MPI // as Trilinos was built
#include <Epetra_MpiComm.h>
#else
#include <Epetra_SerialComm.h>
#endif

#include "core/mesh/tetra_mesh.hpp"
#include "core/support/processes/mpi_session.hpp"

namespace livermark::fem_reference {

namespace {

using Six = Eigen::Matrix<double, RigidModes::count, 1>;
using Gram = Eigen::Matrix<double, RigidModes::count, RigidModes::count>;

/// Z^T K Z, or what is the same of a body that nothing bears, R_h^T K_hh R_h: see balance().
Gram stiffness_of_motion(const ElasticSystem &system, const RigidModes &modes, const std::vector<bool> &is_free) {
    const auto &[rows, below, diagonal] = system.stiffness;
    const auto counts = [&](int dof) { return is_free[dof] == system.is_borne; };
    /// R_a^T K_ab R_b of what counts of two nodes
    const auto gram_of_block = [&](int a, int b, const Block<double> &block) -> Gram {
        const auto counted = [&](int node) {
            auto at_node = modes.at(system.points[node]);
            for (int i = 0; i < 3; ++i)
                if (!counts(3 * node + i))
                    at_node.row(i).setZero();
            return at_node;
        };
        return counted(a).transpose() * Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Map(block.data()) * counted(b);
    };
    const auto node_counts = [&](int node) { return counts(3 * node) || counts(3 * node + 1) || counts(3 * node + 2); };
    Gram gram = Gram::Zero();
    for (int node = 0; node < system.num_nodes(); ++node) {
        if (!node_counts(node))
            continue;
        gram += gram_of_block(node, node, diagonal[node]);
        for (int k = rows.row_start[node]; k < rows.row_start[node + 1]; ++k)
            if (node_counts(rows.column[k])) {
                const Gram part = gram_of_block(node, rows.column[k], below[k]);
                gram += part + part.transpose();
            }
    }
    return gram;
}

} // namespace

RigidModes::RigidModes(std::span<const core::Vector3> points) {
    const auto box = core::bounding_box(points);
    middle_ = box.center();
    size_ = box.diagonal().norm();
}

Eigen::Matrix<double, 3, RigidModes::count> RigidModes::at(const core::Vector3 &point) const {
    const core::Vector3 arm = (point - middle_) / size_;
    Eigen::Matrix<double, 3, count> modes;
    modes.leftCols<3>().setIdentity();
    for (int axis = 0; axis < 3; ++axis)
        modes.col(3 + axis) = core::Vector3::Unit(axis).cross(arm);
    return modes;
}

void balance(const ElasticSystem &system, const FreeUnknowns &free, std::span<const double> residual,
             std::span<double> u) {
    const RigidModes modes(system.points);
    const auto lanes = static_cast<std::size_t>(free.lanes());
    std::vector<Six> motion(lanes, Six::Zero()); // first what is out of balance
    for (std::size_t node = 0; node < system.points.size(); ++node) {
        const auto at_node = modes.at(system.points[node]);
        for (int i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < lanes; ++c)
                motion[c] += residual[lanes * (3 * node + i) + c] * at_node.row(i).transpose();
    }
    std::vector<Eigen::LDLT<Gram>> factors;
    for (const auto &set : free.sets)
        factors.emplace_back(stiffness_of_motion(system, modes, set));
    for (std::size_t c = 0; c < lanes; ++c)
        motion[c] = factors[free.set[c]].solve(motion[c]);
    for (std::size_t node = 0; node < system.points.size(); ++node) {
        const auto at_node = modes.at(system.points[node]);
        for (int i = 0; i < 3; ++i)
            for (std::size_t c = 0; c < lanes; ++c)
                if (free.sets[free.set[c]][3 * node + i])
                    u[lanes * (3 * node + i) + c] += at_node.row(i).dot(motion[c]);
    }
}

Teuchos::ParameterList multigrid_settings(std::vector<double> &modes) {
    Teuchos::ParameterList list;
    ML_Epetra::SetDefaults("SA", list);
    list.set("ML output", 0);
    list.set("PDE equations", 3);
    list.set("null space: type", "pre-computed");
    list.set("null space: dimension", RigidModes::count);
    list.set("null space: vectors", modes.data());
    list.set("aggregation: type", "Uncoupled");
    list.set("aggregation: threshold", 1e-4);
    list.set("smoother: type", "symmetric Gauss-Seidel");
    list.set("smoother: sweeps", 1);
    list.set("smoother: pre or post", "both");
    list.set("coarse: type", "Amesos-KLU");
    list.set("coarse: max size", 2000);
    return list;
}

namespace {

/// @return shape (6, 3 n)
std::vector<double> rigid_modes(const std::vector<core::Vector3> &points) {
    const RigidModes rigid(points);
    const std::size_t size = 3 * points.size();
    std::vector<double> modes(RigidModes::count * size);
    for (std::size_t node = 0; node < points.size(); ++node) {
        const auto at_node = rigid.at(points[node]);
        for (int m = 0; m < RigidModes::count; ++m)
            for (int i = 0; i < 3; ++i)
                modes[m * size + 3 * node + i] = at_node(i, m);
    }
    return modes;
}

/// Numbers the parts of a body that hang together, by the pattern of its matrix.
/// @return shape (n) part of each node
std::vector<int> connected_parts(const LowerRows &rows, int &num_parts) {
    const auto matrix = zero_of_blocks(rows);
    std::vector<int> part(rows.num_nodes(), -1);
    std::vector<int> todo;
    num_parts = 0;
    for (std::size_t seed = 0; seed < part.size(); ++seed) {
        if (part[seed] >= 0)
            continue;
        part[seed] = num_parts;
        todo.push_back(static_cast<int>(seed));
        while (!todo.empty()) {
            const int node = todo.back();
            todo.pop_back();
            for (int k = matrix.row_start[node]; k < matrix.row_start[node + 1]; ++k)
                if (int &other = part[matrix.column[k]]; other < 0) {
                    other = num_parts;
                    todo.push_back(matrix.column[k]);
                }
        }
        ++num_parts;
    }
    return part;
}

/// Whether no part of the body can move as a rigid body: no combination of the modes is zero at all that is
/// constrained.
bool is_constrained(const ElasticSystem &system, const std::vector<double> &modes, const std::vector<bool> &is_free) {
    constexpr double least_hold = 1e-12;
    int num_parts = 0;
    const auto part = connected_parts(system.stiffness.rows, num_parts);
    using Gram = Eigen::Matrix<double, RigidModes::count, RigidModes::count>;
    std::vector<Gram> constrained(num_parts, Gram::Zero());
    const std::size_t size = is_free.size();
    for (std::size_t dof = 0; dof < size; ++dof) {
        if (is_free[dof])
            continue;
        Eigen::Matrix<double, RigidModes::count, 1> row;
        for (int m = 0; m < RigidModes::count; ++m)
            row[m] = modes[m * size + dof];
        constrained[part[dof / 3]] += row * row.transpose();
    }
    return std::ranges::all_of(constrained, [](const Gram &gram) {
        const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Gram>(gram, Eigen::EigenvaluesOnly).eigenvalues();
        return eigenvalues[0] > least_hold * eigenvalues[RigidModes::count - 1];
    });
}

#ifdef HAVE_MPI
Epetra_MpiComm communicator() {
    support::start_mpi_in_one_process(); // ML runs on an MPI communicator only
    return Epetra_MpiComm(MPI_COMM_SELF);
}
#else
Epetra_SerialComm communicator() {
    return {};
}
#endif

class AlgebraicMultigrid : public Preconditioner {
  public:
    explicit AlgebraicMultigrid(const ElasticSystem &system) : system_(system) {}

    bool set_up(const FreeUnknowns &free) override {
        const auto &is_free = free.sets.front(); // one column
        if (is_free == is_free_)
            return levels_ != nullptr;
        is_free_ = is_free; // what follows may throw, and then there are no levels
        levels_.reset();
        matrix_.reset();
        modes_ = rigid_modes(system_.points);
        if (!is_constrained(system_, modes_, is_free))
            return false;
        const auto size = is_free.size();
        for (std::size_t k = 0; k < modes_.size(); ++k)
            if (!is_free[k % size])
                modes_[k] = 0.0;
        copy_matrix();

        auto list = multigrid_settings(modes_);
        auto levels = std::make_unique<ML_Epetra::MultiLevelPreconditioner>(*matrix_, list, true);
        if (!levels->IsPreconditionerComputed())
            throw std::runtime_error("Trilinos ML failed to make its levels");
        levels_ = std::move(levels);
        return true;
    }

    void apply(std::span<const float> residual, std::span<float> correction) override {
        const auto &map = matrix_->OperatorDomainMap();
        Epetra_Vector from(map, false), to(map, false);
        std::ranges::copy(residual, from.Values());
        if (levels_->ApplyInverse(from, to) != 0)
            throw std::runtime_error("Trilinos ML failed to apply its preconditioner");
        std::transform(to.Values(), to.Values() + to.MyLength(), correction.begin(),
                       [](double value) { return static_cast<float>(value); });
    }

    std::string name() const override { return "ML, rigid body modes"; }

  private:
    void copy_matrix() {
        const auto stiffness = compressed_rows(system_.stiffness);
        const int size = stiffness.num_rows();
        const Epetra_Map map(size, 0, communicator());
        std::vector<int> length(size);
        for (int row = 0; row < size; ++row)
            length[row] = stiffness.row_start[row + 1] - stiffness.row_start[row];
        matrix_ = std::make_unique<Epetra_CrsMatrix>(Copy, map, map, length.data(), true);
        std::vector<double> values;
        for (int row = 0; row < size; ++row) {
            const int begin = stiffness.row_start[row];
            values.assign(stiffness.value.begin() + begin, stiffness.value.begin() + begin + length[row]);
            for (int k = 0; k < length[row]; ++k) {
                const int column = stiffness.column[begin + k];
                if (column != row && (!is_free_[row] || !is_free_[column]))
                    values[k] = 0.0;
            }
            if (matrix_->InsertMyValues(row, length[row], values.data(), stiffness.column.data() + begin) < 0)
                throw std::runtime_error("Trilinos refuses a row of the stiffness matrix");
        }
        matrix_->FillComplete();
        matrix_->OptimizeStorage();
    }

    const ElasticSystem &system_;
    std::vector<bool> is_free_;
    std::vector<double> modes_;
    std::unique_ptr<Epetra_CrsMatrix> matrix_;
    std::unique_ptr<ML_Epetra::MultiLevelPreconditioner> levels_;
};

} // namespace

std::unique_ptr<Preconditioner> algebraic_multigrid(const ElasticSystem &system) {
    return std::make_unique<AlgebraicMultigrid>(system);
}

} // namespace livermark::fem_reference
