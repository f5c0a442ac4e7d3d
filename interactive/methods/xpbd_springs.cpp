#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "interactive/elements/constraint_set.hpp"
#include "interactive/elements/position_based.hpp"
#include "interactive/elements/spring_body.hpp"
#include "interactive/method.hpp"

namespace livermark::interactive::methods {

namespace {

/// C = |x_a - x_b| - l, alpha = 1 / k.
struct Distance {
    static constexpr int num_nodes = 2, num_constraints = 1;
    static constexpr auto constraint = kernels::Constraint::distance;
    std::array<int, 2> nodes;
    Eigen::Matrix<double, 1, 1> compliance; ///< [m/N]
    double rest_length;

    void evaluate(const Field &x, Eigen::Matrix<double, 1, 1> &c, Eigen::Matrix<double, 6, 1> &g) const {
        const core::Vector3 d = x.col(nodes[0]) - x.col(nodes[1]);
        const double length = d.norm();
        c[0] = length - rest_length;
        g << d / length, -d / length;
    }

    std::array<double, 5> numbers(const Field &rest) const {
        const core::Vector3 d = rest.col(nodes[0]) - rest.col(nodes[1]);
        return {d.x(), d.y(), d.z(), rest_length, compliance[0]};
    }
};

/// C = J - 1, alpha = 1 / (V k) with k of VolumeBesideSprings.
struct Volume {
    static constexpr int num_nodes = 4, num_constraints = 1;
    static constexpr auto constraint = kernels::Constraint::volume;
    std::array<int, 4> nodes;
    Eigen::Matrix<double, 1, 1> compliance; ///< [1/J]
    double rest_six_volumes;

    void evaluate(const Field &x, Eigen::Matrix<double, 1, 1> &c, Eigen::Matrix<double, 12, 1> &g) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.col(e) = x.col(nodes[e + 1]) - x.col(nodes[0]);
        const Matrix3 slopes = cofactors(edges) / rest_six_volumes;
        c[0] = edges.determinant() / rest_six_volumes - 1.0;
        g << -slopes.rowwise().sum(), slopes.col(0), slopes.col(1), slopes.col(2);
    }

    std::array<double, 10> numbers(const Field &rest) const {
        Matrix3 edges;
        for (int e = 0; e < 3; ++e)
            edges.row(e) = rest.col(nodes[e + 1]) - rest.col(nodes[0]);
        const Matrix3 gradients = edges.inverse(); // by columns
        std::array<double, 10> numbers{};
        *std::copy_n(gradients.data(), gradients.size(), numbers.begin()) = compliance[0];
        return numbers;
    }
};

class XpbdSprings : public PositionBased {
  public:
    explicit XpbdSprings(Scene given)
        : PositionBased(std::move(given)), edges_(edges_of(scene())), energy_(*scene().body, edges_),
          distances_(distances(), static_cast<int>(positions().cols()),
                     scene().orders ? scene().orders->edge_colour : std::vector<int>{}),
          volumes_(volumes(), static_cast<int>(positions().cols()), colours_of_volumes()) {
        if (is_in_single_precision())
            use_vectors({distances_.rows(positions()), volumes_.rows(positions())});
    }

    const Energy &energy() const override { return energy_; }
    Orders orders() const override {
        Orders orders;
        orders.edges = edges_;
        orders.edge_colour = distances_.colours();
        auto colour = volumes_.colours().begin();
        for (const auto &t : energy_.tetrahedra())
            orders.tetrahedron_colour.push_back(has_volume(t) ? *colour++ : -1);
        return orders;
    }

  protected:
    void clear_multipliers() override {
        distances_.clear();
        volumes_.clear();
    }
    void project(Field &x, const std::vector<double> &inverse_mass, double time_step) override {
        distances_.project(x, inverse_mass, time_step);
        volumes_.project(x, inverse_mass, time_step);
    }
    void add_constraint_forces(const Field &x, double time_step, std::span<const kernels::ConstraintRows> sets,
                               Field &f) const override {
        distances_.add_forces(x, time_step, f, sets.empty() ? nullptr : &sets[0]);
        volumes_.add_forces(x, time_step, f, sets.empty() ? nullptr : &sets[1]);
    }
    std::size_t bytes_of_constraints() const override { return distances_.bytes() + volumes_.bytes(); }

  private:
    static core::EdgeTable edges_of(const Scene &scene) {
        return scene.orders && !scene.orders->edges.edges.empty() ? scene.orders->edges
                                                                  : core::edge_table(scene.body->mesh.tetrahedra);
    }

    std::vector<Distance> distances() const {
        std::vector<Distance> result;
        const auto &springs = energy_.springs();
        result.reserve(springs.edges.size());
        for (std::size_t s = 0; s < springs.edges.size(); ++s)
            result.push_back({.nodes = springs.edges[s],
                              .compliance = Eigen::Matrix<double, 1, 1>(1.0 / springs.stiffness[s]),
                              .rest_length = springs.rest_length[s]});
        return result;
    }

    static double volume_modulus(const Tetrahedron &t) {
        return densities::VolumeBesideSprings{t.mu, t.lambda}.modulus();
    }
    static bool has_volume(const Tetrahedron &t) { return volume_modulus(t) > 0.0; }

    std::vector<Volume> volumes() const {
        std::vector<Volume> result;
        result.reserve(energy_.tetrahedra().size());
        for (const auto &t : energy_.tetrahedra())
            if (has_volume(t))
                result.push_back({.nodes = t.nodes,
                                  .compliance = Eigen::Matrix<double, 1, 1>(1.0 / (t.volume * volume_modulus(t))),
                                  .rest_six_volumes = 6.0 * t.volume});
        return result;
    }

    /// As the scene knows them.
    std::vector<int> colours_of_volumes() const {
        std::vector<int> result;
        if (scene().orders)
            for (const int colour : scene().orders->tetrahedron_colour)
                if (colour >= 0)
                    result.push_back(colour);
        return result;
    }

    core::EdgeTable edges_;
    SpringAndVolumeEnergy energy_;
    ConstraintSet<Distance> distances_;
    ConstraintSet<Volume> volumes_;
};

} // namespace

/// What games call soft bodies, with compliances of the material: springs on edges, and the volume of each tetrahedron.
Method xpbd_springs() {
    return {.name = {},
            .summary = "extended position-based dynamics: springs on edges and volumes of tetrahedra as constraints",
            .source = "Macklin, Mueller, Chentanez 2016, XPBD: position-based simulation of compliant constrained "
                      "dynamics, MIG",
            .energy = "k / 2 (|x_a - x_b| - l)^2 on edges by Lloyd's formula for mu, (lambda - mu) / 2 (J - 1)^2",
            .converges_to = "the step of backward Euler, up to turns of constraint gradients during a step, which "
                            "vanish with h",
            .objection =
                "One step with many iterations is less effective than as many small steps with one each (Macklin et "
                "al. 2019, Small steps, SCA): 'livermark arena --mesh 1 --iterations 1 3 10 30 100 --method "
                "xpbd_springs' has both. Its iterations stall on fine meshes of stiff materials (Li et al. 2025, "
                "MGPBD, SIGGRAPH): --mesh 1 3 in the same command. Programs that do not keep its multipliers get "
                "stiffer with each iteration (newton-physics/newton#2933); here they are kept.",
            .implementation = "vector units over constraints of one colour, single precision",
            .in_double = "plain loop over constraints in the order of colours, double",
            .time_step = frame_time,
            .iterations = 10,
            .knows_contact = true,
            .prepare = [](const Scene &scene) { return std::make_unique<XpbdSprings>(scene); }};
}

} // namespace livermark::interactive::methods
