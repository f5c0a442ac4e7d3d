#include "fem_reference/solvers/two_level.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "fem_reference/solvers/matrices.hpp"

namespace livermark::fem_reference {

namespace {

constexpr int num_children = 8;
constexpr int nodes_of_linear = 4;
constexpr int nodes_of_quadratic = 10;
constexpr const char *no_pair =
    "the fine system is not the quadratic one of the same body or of parts of its tetrahedra";

/// Nodes of the fine system lie at quarters of the edges: rounding makes the coordinates exact.
/// @param inverse  of the matrix of the edge vectors from the first corner
Eigen::Vector4d barycentric(const Eigen::Matrix3d &inverse, const core::Vector3 &from_first_corner) {
    constexpr double parts = 4.0;
    constexpr double largest_rounding = 1e-6;
    const core::Vector3 exact = parts * (inverse * from_first_corner);
    const core::Vector3 rounded = exact.array().round();
    if (!((exact - rounded).cwiseAbs().maxCoeff() < largest_rounding) || rounded.minCoeff() < 0.0 ||
        rounded.sum() > parts)
        throw std::invalid_argument(no_pair);
    const core::Vector3 others = rounded / parts;
    return {1.0 - others.sum(), others[0], others[1], others[2]};
}

template <class T> void add(const Prolongation &p, std::span<const T> coarse, std::span<T> fine) {
    with_lanes(static_cast<int>(coarse.size() / (3 * p.fine_node.size())), [&]<int lanes>() {
        constexpr std::size_t width = 3 * lanes;
        for (std::size_t node = 0; node + 1 < p.row_start.size(); ++node)
            for (int k = p.row_start[node]; k < p.row_start[node + 1]; ++k)
                for (std::size_t i = 0; i < width; ++i)
                    fine[width * node + i] += static_cast<T>(p.weight[k]) * coarse[width * p.coarse_node[k] + i];
    });
}

template <class T> void gather(const Prolongation &p, std::span<const T> fine, std::span<T> coarse) {
    std::ranges::fill(coarse, T(0));
    with_lanes(static_cast<int>(coarse.size() / (3 * p.fine_node.size())), [&]<int lanes>() {
        constexpr std::size_t width = 3 * lanes;
        for (std::size_t node = 0; node + 1 < p.row_start.size(); ++node)
            for (int k = p.row_start[node]; k < p.row_start[node + 1]; ++k)
                for (std::size_t i = 0; i < width; ++i)
                    coarse[width * p.coarse_node[k] + i] += static_cast<T>(p.weight[k]) * fine[width * node + i];
    });
}

} // namespace

std::array<double, 10> shape_functions(const Eigen::Vector4d &bary, int nodes_per_cell) {
    std::array<double, nodes_of_quadratic> shape{};
    if (nodes_per_cell == nodes_of_linear) {
        std::copy_n(bary.data(), nodes_of_linear, shape.data());
        return shape;
    }
    for (int v = 0; v < nodes_of_linear; ++v)
        shape[v] = bary[v] * (2.0 * bary[v] - 1.0);
    for (std::size_t e = 0; e < edges_of_quadratic.size(); ++e)
        shape[nodes_of_linear + e] = 4.0 * bary[edges_of_quadratic[e][0]] * bary[edges_of_quadratic[e][1]];
    return shape;
}

namespace {

/// The parents of prolongation() where they are not given.
/// @throws std::invalid_argument if the fine system has neither as many tetrahedra nor eight times as many
std::vector<int> parents_by_number(const ElasticSystem &coarse, const ElasticSystem &fine) {
    const int children = coarse.nodes_per_cell == nodes_of_linear ? 1 : num_children;
    const auto num_coarse = coarse.cell_nodes.size() / coarse.nodes_per_cell;
    std::vector<int> parent(fine.cell_nodes.size() / fine.nodes_per_cell);
    if (parent.size() != children * num_coarse)
        throw std::invalid_argument(no_pair);
    for (std::size_t child = 0; child < parent.size(); ++child)
        parent[child] = static_cast<int>(child) / children;
    return parent;
}

} // namespace

Prolongation prolongation(const ElasticSystem &coarse, const ElasticSystem &fine, std::span<const int> parent) {
    const int nodes_per_cell = coarse.nodes_per_cell;
    const auto by_number = parent.empty() ? parents_by_number(coarse, fine) : std::vector<int>{};
    if (parent.empty())
        parent = by_number;
    if (fine.nodes_per_cell != nodes_of_quadratic || fine.cell_nodes.size() != parent.size() * nodes_of_quadratic)
        throw std::invalid_argument(no_pair);
    std::vector<std::array<double, nodes_of_quadratic>> shape(fine.points.size());
    std::vector<int> cell(fine.points.size(), -1);
    for (std::size_t child = 0; child < parent.size(); ++child) {
        const int *const corners = coarse.cell_nodes.data() + static_cast<std::size_t>(parent[child]) * nodes_per_cell;
        const auto &origin = coarse.points[corners[0]];
        Eigen::Matrix3d edges;
        for (int d = 0; d < 3; ++d)
            edges.col(d) = coarse.points[corners[d + 1]] - origin;
        const Eigen::Matrix3d inverse = edges.inverse();
        for (int k = 0; k < nodes_of_quadratic; ++k) {
            const int node = fine.cell_nodes[child * nodes_of_quadratic + k];
            if (cell[node] >= 0)
                continue;
            cell[node] = parent[child];
            shape[node] = shape_functions(barycentric(inverse, fine.points[node] - origin), nodes_per_cell);
        }
    }

    Prolongation result;
    result.fine_node.assign(coarse.points.size(), -1);
    result.row_start.push_back(0);
    for (std::size_t node = 0; node < shape.size(); ++node) {
        for (int a = 0; a < nodes_per_cell; ++a) {
            const double weight = shape[node][a];
            if (weight == 0.0)
                continue;
            const int coarse_node = coarse.cell_nodes[cell[node] * nodes_per_cell + a];
            result.coarse_node.push_back(coarse_node);
            result.weight.push_back(weight);
            if (weight == 1.0)
                result.fine_node[coarse_node] = static_cast<int>(node);
        }
        result.row_start.push_back(static_cast<int>(result.weight.size()));
    }
    if (std::ranges::count(result.fine_node, -1) > 0)
        throw std::invalid_argument(no_pair);
    return result;
}

void Prolongation::add_prolonged(std::span<const double> coarse, std::span<double> fine) const {
    add(*this, coarse, fine);
}

void Prolongation::add_prolonged(std::span<const float> coarse, std::span<float> fine) const {
    add(*this, coarse, fine);
}

void Prolongation::restrict_to(std::span<const double> fine, std::span<double> coarse) const {
    gather(*this, fine, coarse);
}

void Prolongation::restrict_to(std::span<const float> fine, std::span<float> coarse) const {
    gather(*this, fine, coarse);
}

namespace {

using FloatBlock = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

Block<float> rounded(const Eigen::Matrix3d &block) {
    Block<float> result;
    FloatBlock::Map(result.data()) = block.cast<float>();
    return result;
}

/// Inverse of the free rows and columns of a block, zero elsewhere.
Eigen::Matrix3d inverse_of_free(const Block<float> &block, const Eigen::Array3d &is_free) {
    const Eigen::Matrix3d chosen = is_free.matrix() * is_free.matrix().transpose();
    const Eigen::Matrix3d free_part = FloatBlock::Map(block.data()).cast<double>().cwiseProduct(chosen);
    return (free_part + (1.0 - is_free).matrix().asDiagonal().toDenseMatrix()).inverse().cwiseProduct(chosen);
}

} // namespace

BlockGaussSeidel::BlockGaussSeidel(const SymmetricBlocks<float> &matrix) : matrix_(matrix) {
    const Eigen::Array3d all_free = Eigen::Array3d::Ones();
    for (const auto &block : matrix_.diagonal)
        inverse_diagonal_.push_back(rounded(inverse_of_free(block, all_free)));
}

void BlockGaussSeidel::set_up(const FreeUnknowns &free) {
    lanes_ = free.lanes();
    taken_.assign(3 * lanes_ * matrix_.rows.num_nodes(), 0.0F);
    constrained_.assign(matrix_.rows.num_nodes(), -1);
    constrained_inverse_.clear();
    is_free_.clear();
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        std::vector<Eigen::Array3d> by_set;
        for (const auto &set : free.sets) {
            auto &is_free = by_set.emplace_back();
            for (int i = 0; i < 3; ++i)
                is_free[i] = set[3 * at + i] ? 1.0 : 0.0;
        }
        if (std::ranges::all_of(by_set, [](const auto &is_free) { return is_free.minCoeff() > 0.0; }))
            continue;
        constrained_[at] = static_cast<int>(is_free_.size()) / (3 * lanes_);
        std::vector<Eigen::Matrix3d> inverse;
        for (const auto &is_free : by_set)
            inverse.push_back(inverse_of_free(matrix_.diagonal[at], is_free));
        for (int entry = 0; entry < 9; ++entry)
            for (const int set : free.set)
                constrained_inverse_.push_back(static_cast<float>(inverse[set](entry / 3, entry % 3)));
        for (int i = 0; i < 3; ++i)
            for (const int set : free.set)
                is_free_.push_back(static_cast<float>(by_set[set][i]));
    }
}

/// The rows of one sweep.
template <int lanes> class BlockGaussSeidel::Sweep {
  public:
    static constexpr std::size_t width = 3 * lanes;
    using Vector = Triple<float, lanes>;

    Sweep(BlockGaussSeidel &smoother, std::span<float> u) : of(smoother), now(u) { std::ranges::fill(of.taken_, 0.0F); }

    /// Solves the row of a node for it.
    /// @param others  what the other nodes take
    [[gnu::always_inline]] void solve(std::size_t at, const float *right_hand_side, const Vector &others) {
        Vector left(right_hand_side), solved;
        left.x -= others.x;
        left.y -= others.y;
        left.z -= others.z;
        if (of.constrained_[at] < 0) {
            add_product(of.inverse_diagonal_[at], left, solved);
        } else {
            const float *const inverse = &of.constrained_inverse_[3 * width * of.constrained_[at]];
            const Vector first(inverse), second(inverse + width), third(inverse + 2 * width);
            solved.x = first.x * left.x + first.y * left.y + first.z * left.z;
            solved.y = second.x * left.x + second.y * left.y + second.z * left.z;
            solved.z = third.x * left.x + third.y * left.y + third.z * left.z;
        }
        solved.put(&now[width * at]);
    }

    /// Products that the nodes before one take from its row, and the other way round.
    [[gnu::always_inline]] void take(int k, Vector &sum) {
        add_product(of.matrix_.below[k], Vector(&now[width * of.matrix_.rows.column[k]]), sum);
    }
    [[gnu::always_inline]] void give(int k, const Vector &here) {
        float *const place = &of.taken_[width * of.matrix_.rows.column[k]];
        Vector there(place);
        add_transposed(of.matrix_.below[k], here, there);
        there.put(place);
    }

    BlockGaussSeidel &of;
    std::span<float> now; ///< (n, 3, lanes)
};

template <int lanes>
[[gnu::always_inline]] inline void BlockGaussSeidel::forward(std::span<const float> right_hand_side, std::span<float> u,
                                                             std::span<float> residual) {
    constexpr auto width = Sweep<lanes>::width;
    Sweep<lanes> sweep(*this, u);
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        const auto place = width * at;
        Triple<float, lanes> before;
        for (int k = matrix_.rows.row_start[at]; k < matrix_.rows.row_start[at + 1]; ++k) {
            ask_ahead(&matrix_.below[k], 1);
            sweep.take(k, before);
        }
        sweep.solve(at, &right_hand_side[place], before);
        const Triple<float, lanes> here(&u[place]);
        for (int k = matrix_.rows.row_start[at]; k < matrix_.rows.row_start[at + 1]; ++k)
            sweep.give(k, here);
    }
    // A sweep leaves of each row only what lies behind the diagonal.
    for (std::size_t at = 0; at < matrix_.rows.num_nodes(); ++at) {
        const auto place = width * at;
        const float *const is_free = constrained_[at] < 0 ? nullptr : &is_free_[width * constrained_[at]];
        for (std::size_t i = 0; i < width; ++i)
            residual[place + i] = is_free ? -taken_[place + i] * is_free[i] : -taken_[place + i];
    }
}

template <int lanes>
[[gnu::always_inline]] inline void BlockGaussSeidel::backward(std::span<const float> right_hand_side,
                                                              std::span<float> u) {
    constexpr auto width = Sweep<lanes>::width;
    Sweep<lanes> sweep(*this, u);
    for (std::size_t at = matrix_.rows.num_nodes(); at-- > 0;) {
        const auto place = width * at;
        Triple<float, lanes> others(&taken_[place]);
        for (int k = matrix_.rows.row_start[at + 1] - 1; k >= matrix_.rows.row_start[at]; --k) {
            ask_ahead(&matrix_.below[k], -1);
            sweep.take(k, others);
        }
        sweep.solve(at, &right_hand_side[place], others);
        const Triple<float, lanes> here(&u[place]);
        for (int k = matrix_.rows.row_start[at + 1] - 1; k >= matrix_.rows.row_start[at]; --k)
            sweep.give(k, here);
    }
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_forward_from_zero(std::span<const float> right_hand_side, std::span<float> u,
                                               std::span<float> residual) {
    switch (lanes_) { // a lambda would be compiled for one processor
    case 1:
        return forward<1>(right_hand_side, u, residual);
    case 4:
        return forward<4>(right_hand_side, u, residual);
    default:
        return forward<most_lanes>(right_hand_side, u, residual);
    }
}

LIVERMARK_WIDE_CLONES
void BlockGaussSeidel::sweep_backward(std::span<const float> right_hand_side, std::span<float> u) {
    switch (lanes_) {
    case 1:
        return backward<1>(right_hand_side, u);
    case 4:
        return backward<4>(right_hand_side, u);
    default:
        return backward<most_lanes>(right_hand_side, u);
    }
}

namespace {

class TwoLevel : public Preconditioner {
  public:
    TwoLevel(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine, Preconditioner &coarse_solver)
        : coarse_solver_(coarse_solver), prolongation_(std::move(prolongation)), smoother_(rounded_fine),
          num_fine_(3 * rounded_fine.diagonal.size()), num_coarse_(3 * prolongation_.fine_node.size()) {}

    bool set_up(const FreeUnknowns &free) override {
        // A facet that is constrained is constrained at its coarse nodes too, and a coarse function that is zero there
        // is zero on the whole facet: the free coarse functions are free fine ones. The coarse solver may have been set
        // up for others in between, so it is asked every time.
        FreeUnknowns coarse_free{{}, free.set};
        for (const auto &set : free.sets) {
            auto &is_free = coarse_free.sets.emplace_back(num_coarse_);
            for (std::size_t dof = 0; dof < num_coarse_; ++dof)
                is_free[dof] = set[3 * prolongation_.fine_node[dof / 3] + dof % 3];
        }
        if (!coarse_solver_.set_up(coarse_free))
            return false;
        if (free == free_)
            return true;
        smoother_.set_up(free);
        coarse_constrained_ = constrained_entries(coarse_free);
        const auto lanes = static_cast<std::size_t>(free.lanes());
        fine_residual_.resize(num_fine_ * lanes);
        coarse_residual_.resize(num_coarse_ * lanes);
        coarse_correction_.resize(num_coarse_ * lanes);
        free_ = free;
        return true;
    }

    void apply(std::span<const float> residual, std::span<float> correction) override {
        smoother_.sweep_forward_from_zero(residual, correction, fine_residual_);
        prolongation_.restrict_to(fine_residual_, coarse_residual_);
        zero(coarse_constrained_, coarse_residual_);
        coarse_solver_.apply(coarse_residual_, coarse_correction_);
        prolongation_.add_prolonged(coarse_correction_, correction);
        smoother_.sweep_backward(residual, correction);
    }

    std::size_t max_columns() const override { return coarse_solver_.max_columns(); }
    std::string name() const override { return "two levels over " + coarse_solver_.name(); }

  private:
    Preconditioner &coarse_solver_;
    Prolongation prolongation_;
    BlockGaussSeidel smoother_;
    std::size_t num_fine_;
    std::size_t num_coarse_;
    FreeUnknowns free_;
    std::vector<std::size_t> coarse_constrained_;
    std::vector<float> fine_residual_;
    std::vector<float> coarse_residual_;
    std::vector<float> coarse_correction_;
};

} // namespace

std::unique_ptr<Preconditioner> two_level(Prolongation prolongation, const SymmetricBlocks<float> &rounded_fine,
                                          Preconditioner &coarse_solver) {
    return std::make_unique<TwoLevel>(std::move(prolongation), rounded_fine, coarse_solver);
}

SymmetricBlocks<double> galerkin(const Prolongation &prolongation, const SymmetricBlocks<double> &stiffness,
                                 const LowerRows &coarse_rows) {
    SymmetricBlocks<double> coarse{coarse_rows, {}, {}};
    coarse.below.assign(coarse_rows.column.size(), {});
    coarse.diagonal.assign(coarse_rows.num_nodes(), {});
    // Adds to the block of two coarse nodes, of which the first is not before the second.
    const auto add = [&](int row, int column, double weight, const Block<double> &block, bool is_transposed) {
        const auto first = coarse_rows.column.begin() + coarse_rows.row_start[row],
                   last = coarse_rows.column.begin() + coarse_rows.row_start[row + 1];
        auto &to = row == column ? coarse.diagonal[row]
                                 : coarse.below[std::lower_bound(first, last, column) - coarse_rows.column.begin()];
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                to[3 * i + j] += weight * block[is_transposed ? 3 * j + i : 3 * i + j];
    };
    const auto for_each_pair = [&](std::size_t a, std::size_t b, const auto &action) {
        for (int k = prolongation.row_start[a]; k < prolongation.row_start[a + 1]; ++k)
            for (int l = prolongation.row_start[b]; l < prolongation.row_start[b + 1]; ++l)
                action(prolongation.coarse_node[k], prolongation.coarse_node[l],
                       prolongation.weight[k] * prolongation.weight[l]);
    };
    const auto &rows = stiffness.rows;
    for (std::size_t a = 0; a < rows.num_nodes(); ++a) {
        for_each_pair(a, a, [&](int i, int j, double weight) {
            if (i >= j)
                add(i, j, weight, stiffness.diagonal[a], false);
        });
        for (int k = rows.row_start[a]; k < rows.row_start[a + 1]; ++k)
            for_each_pair(a, rows.column[k], [&](int i, int j, double weight) {
                if (i >= j)
                    add(i, j, weight, stiffness.below[k], false);
                if (j >= i)
                    add(j, i, weight, stiffness.below[k], true);
            });
    }
    return coarse;
}

namespace {

/// The corners of the fine mesh are the corners of the coarse one, where pressures are the same, and the midpoints of
/// its edges, where they are the mean of both ends.
SparseRows pressure_prolongation(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 const Prolongation &displacement, std::span<const int> parent) {
    std::vector<int> coarse_node(fine.points.size(), -1);
    for (std::size_t node = 0; node < displacement.fine_node.size(); ++node)
        coarse_node[displacement.fine_node[node]] = static_cast<int>(node);
    std::vector<std::vector<int>> ends(fine_pressure.num_pressures()); // one or two pressures
    for (std::size_t child = 0; child < fine_pressure.cell_pressures.size(); ++child) {
        const auto t = static_cast<std::size_t>(parent[child]);
        const auto &pressures = coarse_pressure.cell_pressures[t];
        if (pressures.front() < 0)
            continue;
        const auto nodes = std::span(coarse.cell_nodes).subspan(t * coarse.nodes_per_cell, coarse.nodes_per_cell);
        for (int corner = 0; corner < nodes_of_linear; ++corner) {
            auto &ends_of_corner = ends[fine_pressure.cell_pressures[child][corner]];
            if (!ends_of_corner.empty())
                continue;
            const int node = coarse_node[fine.cell_nodes[child * fine.nodes_per_cell + corner]];
            const auto local = static_cast<int>(std::ranges::find(nodes, node) - nodes.begin());
            if (local < nodes_of_linear) {
                ends_of_corner = {pressures[local]};
            } else {
                const auto [a, b] = edges_of_quadratic[local - nodes_of_linear];
                ends_of_corner = {pressures[a], pressures[b]};
            }
        }
    }
    SparseRows result;
    result.row_start.push_back(0);
    for (const auto &ends_of_corner : ends) {
        for (const int pressure : ends_of_corner) {
            result.column.push_back(pressure);
            result.value.push_back(1.0 / static_cast<double>(ends_of_corner.size()));
        }
        result.row_start.push_back(static_cast<int>(result.column.size()));
    }
    return result;
}

} // namespace

std::vector<double> NestedIteration::prolonged_pressure(std::span<const double> coarse, int lanes) const {
    const std::size_t num_rows = pressure.row_start.size() - 1;
    std::vector<double> fine(lanes * num_rows, 0.0);
    for (std::size_t row = 0; row < num_rows; ++row)
        for (int k = pressure.row_start[row]; k < pressure.row_start[row + 1]; ++k)
            for (int c = 0; c < lanes; ++c)
                fine[lanes * row + c] +=
                    pressure.value[k] * coarse[static_cast<std::size_t>(lanes) * pressure.column[k] + c];
    return fine;
}

NestedIteration nested_iteration(const ElasticSystem &coarse, const PressureSystem &coarse_pressure,
                                 const ElasticSystem &fine, const PressureSystem &fine_pressure,
                                 std::span<const int> parent) {
    auto displacement = prolongation(coarse, fine, parent);
    const auto by_number = parent.empty() ? parents_by_number(coarse, fine) : std::vector<int>{};
    auto pressure = pressure_prolongation(coarse, coarse_pressure, fine, fine_pressure, displacement,
                                          parent.empty() ? by_number : parent);
    return {std::move(displacement), std::move(pressure)};
}

} // namespace livermark::fem_reference
