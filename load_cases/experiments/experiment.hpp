#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/load_case.hpp"
#include "core/problem.hpp"
#include "core/solution.hpp"

namespace livermark::experiments {

/// Motion of a place, as a polynomial of two coordinates along it: the least-squares fit to markers on it. Each
/// component of the displacement is sum c_ab s^a t^b over a + b <= degree, with s and t along the two longest principal
/// axes of the markers, in units of their spread.
class FittedMotion {
  public:
    /// @param positions      of the markers at rest [m]
    /// @param displacements  of the same markers [m]
    /// @param degree         >= 0
    /// @param place          named in messages
    /// @throws support::InputError if the markers do not determine the polynomial
    FittedMotion(std::span<const core::Vector3> positions, std::span<const core::Vector3> displacements, int degree,
                 const std::string &place);

    /// Displacement at a point [m].
    core::Vector3 at(const core::Vector3 &point) const;

    /// Root mean square distance between the polynomial and the markers [m].
    double residual() const { return residual_; }

    /// Centroid of the markers [m].
    const core::Vector3 &middle() const { return middle_; }

  private:
    Eigen::RowVectorXd monomials(const core::Vector3 &point) const;

    int degree_;
    core::Vector3 middle_;
    Eigen::Matrix<double, 2, 3> axes_; ///< divided by the spread along them [1/m]
    Eigen::MatrixX3d coefficients_;    ///< [m]
    double residual_ = 0.0;
};

/// A patch and how it moves.
struct PlaceMotion {
    std::string patch;
    FittedMotion motion;
};

/// Lets a constrained patch move: adds to the displacement of its nodes.
/// @throws support::InputError if the body has no such patch or it is not constrained
void drive(core::LoadCase &load_case, const core::TetraMesh &mesh, const PlaceMotion &place);

/// The displacement that is linear between two places that move: what no mechanics at all gives.
core::Vector3 straight_line(const PlaceMotion &from, const PlaceMotion &to, const core::Vector3 &point);

/// x -> gradient (x - from) + to; a rigid motion where the gradient is a rotation.
struct AffineMotion {
    Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
    core::Vector3 from = core::Vector3::Zero(), to = core::Vector3::Zero(); ///< [m]

    core::Vector3 at(const core::Vector3 &point) const { return gradient * (point - from) + to; }
};

/// Fewest points whose rigid motion says anything: one is met exactly, and two but for their distance.
inline constexpr std::size_t fewest_of_rigid_motion = 3;

/// The rigid motion of least sum |x' - y|^2 over points x that it takes to x' (Kabsch 1976, Acta Cryst. A32).
/// @param points   x, at least one [m]
/// @param targets  y [m]
AffineMotion best_rigid_motion(std::span<const core::Vector3> points, std::span<const core::Vector3> targets);

/// The affine motion of least sum |x' - y|^2, or nothing where points lie in a plane or are fewer than four.
/// @param points, targets  x and y [m]
std::optional<AffineMotion> best_affine_motion(std::span<const core::Vector3> points,
                                               std::span<const core::Vector3> targets);

/// Displacements of markers at equal intervals of time.
struct MarkerMotion {
    double interval = 0.0;                   ///< between two records [s], > 0
    int num_markers = 0;                     ///< K
    std::vector<core::Vector3> displacement; ///< (J, K) all markers of a record behind each other [m]

    int num_records() const { return static_cast<int>(displacement.size()) / num_markers; }
    const core::Vector3 &at(int record, int marker) const { return displacement[record * num_markers + marker]; }
};

/// Ringing of a real body after it was let go: it is at rest at t = 0, away from its equilibrium.
struct RingDown {
    std::string state;                 ///< one word or more, as of a MeasuredState
    std::vector<MarkerMotion> repeats; ///< of the same motion, at least one, all with the same records
    /// The body, with what hangs at it, at about this length of edges [m].
    std::function<core::Body(double edge_length)> body;
    /// Supports, acceleration, and one place with a traction: what holds the body at t = 0 and is let go. Its size is
    /// of the right order, and each model finds that with which its markers start where they were seen.
    std::function<core::LoadCase(const core::TetraMesh &)> load_case;
};

/// The mean of all repeats.
MarkerMotion mean_motion(std::span<const MarkerMotion> repeats);

/// A body with a mass that moves with it, spread evenly over the tetrahedra whose middle is in a box: they become a
/// region of their own that is denser. So it has its weight and its inertia in every model.
/// @param mass       [kg], >= 0
/// @param low, high  corners of the box [m]
/// @throws support::InputError if no tetrahedron is there, or they are of several regions
core::Body with_added_mass(core::Body body, double mass, const core::Vector3 &low, const core::Vector3 &high);

/// A point of a real body whose position was measured.
struct Marker {
    std::string name;
    core::Vector3 position = core::Vector3::Zero(); ///< at rest, in the frame of the body [m]
    std::string drives; ///< the patch that moves as this marker was measured; empty of a marker that is compared
};

/// Force on a place that was measured while it was pressed or pulled, in one test or several.
struct MeasuredForce {
    std::string place;       ///< whose force it is: a constraint of the load case
    std::vector<double> way; ///< (J) by which what was measured was pressed or pulled [m], ascending, > 0; the last one
                             ///< at the whole load. A modulus is fitted at the first, the others are compared
    std::vector<double> force;     ///< (J) mean of the tests [N], > 0
    std::vector<double> deviation; ///< (J) standard deviation of the tests [N], >= 0; 0 of one test
    double parts = 1.0;            ///< of which the body is one: 4 where it is a quarter of what was measured
    double length = 0.0; ///< of a uniform body along the way [m], which has the same stress everywhere; 0 where
                         ///< it is none
};

/// Means and deviations at some ways, linear between the lines of a table:
///
///     way,force,deviation
///     0.0,0.0,0.0
///     1.5,0.92,0.02
///
/// with the way in a unit of lengths and the others in newton.
/// @param at               ways [m]
/// @param metres_per_unit  of the table
/// @throws support::InputError with file, line and remedy: another header, a cell that is no number, ways that do not
///   ascend or do not reach as far as asked for
MeasuredForce read_force_table(const std::filesystem::path &file, double metres_per_unit, std::vector<double> at);

/// Forces of a model at the ways of a measurement.
/// @param problem  with the place
/// @return shape (J) [N], along the way, of all parts; NaN beyond the end of the solution's path
std::vector<double> force_along_way(const MeasuredForce &measured, const core::LoadCase &load_case,
                                    const core::Solution &solution);

/// Refuses what no measurement of a force can be: a place without a force, ways that do not ascend, forces that are not
/// positive.
/// @param place  named in messages
/// @throws support::InputError
void check_force(const MeasuredForce &measured, const core::LoadCase &load_case, const std::string &place);

/// Force of a uniform incompressible neo-Hookean body of Young's modulus 1 Pa and cross-section 1 m^2 that is pressed
/// or pulled to a part l of its length: |l^-2 - l| / 3. What is known without a mesh.
/// @return shape (J) [N]; empty where the body is not uniform
std::vector<double> uniform_force(const MeasuredForce &measured, const core::LoadCase &load_case,
                                  const core::TetraMesh &mesh);

/// A real body under one load, at rest.
struct MeasuredState {
    std::string name;
    /// Supports and loads on a mesh of the body; places that markers drive are held at zero.
    std::function<core::LoadCase(const core::TetraMesh &)> load_case;
    std::vector<core::Vector3> displacement; ///< (K) of each marker [m]; NaN where it was not seen
    double noise = 0.0; ///< root mean square length of the error of a marker's displacement [m]; 0 where unknown
    std::optional<MeasuredForce> force{}; ///< the load case then has its points as its path
};

/// Experiment of others on a real body, and what has to be assumed to compute it.
struct Experiment {
    std::string name, title;
    std::string source;                   ///< of the data: publication, and where the public file is
    std::vector<std::string> assumptions; ///< sentences on what the source does not say
    /// The body at about this length of edges [m]. A body of a mesh file has the edges of the file.
    std::function<core::Body(double edge_length)> body;
    /// Approximate number of tetrahedra of that body; empty of a mesh file.
    std::function<double(double edge_length)> expected_tetrahedra{};
    /// The body on a mesh of its own that is finer and as near to its true shape as it can be: of a body with curved
    /// sides. Empty where cutting each tetrahedron into eight keeps the shape.
    std::function<core::Body(double edge_length)> finer_body{};
    double edge_length = 0.0;    ///< that models are compared at [m]; 0 of a mesh file
    int fit_degree = 2;          ///< of the polynomials that driven places move by
    std::vector<Marker> markers; ///< (K)
    std::vector<MeasuredState> states;
    std::vector<RingDown> ring_downs{}; ///< of some states; damping is fitted on that of `damping_from` alone
    std::string damping_from{};         ///< the state of one of them; empty where there are none
};

/// A file of public data.
struct PublicFile {
    std::string path;   ///< of a file below a folder of data_folders(), or of a folder of files
    std::string sha256; ///< digest of what its owners publish, 64 hexadecimal digits; of a folder that of its files
                        ///< behind each other, in the order of their names
};

/// An experiment whose data are public; python/livermark/studies/public_data.py reads them.
struct PublicExperiment {
    std::string name;
    std::string title; ///< one line
    std::string data;  ///< see public_data()
    std::string source;
    std::string licence;
    std::vector<PublicFile> files; ///< that are read
};

/// Every public experiment, in alphabetical order.
std::span<const PublicExperiment> all_public_data();

/// Folders in which public data are looked for, the first before the others: the one that is given, the one that the
/// environment variable LIVERMARK_EXPERIMENTS names, and livermark/experiments in the data directory of the user, which
/// is $XDG_DATA_HOME, or ~/.local/share where that is not set (XDG Base Directory Specification 0.8).
/// @param given  empty if none is
std::vector<std::filesystem::path> data_folders(const std::filesystem::path &given = {});

/// Place of public data in the first of data_folders() that has them.
/// @param data  a file or a folder there
/// @return nothing if none has them
std::optional<std::filesystem::path> public_data(const std::string &data, const std::filesystem::path &given = {});

/// End of a sentence on public data that are not there: "put <data> into <folder>, or ...".
std::string where_to_put(const std::string &data);

/// The sentence for an experiment whose data are not there: where to get them, and where to put them.
std::string where_to_get(const PublicExperiment &experiment);

/// Reads and checks the data of a public experiment. A file with another digest than the published one is named in the
/// assumptions.
/// @param given  see data_folders()
/// @throws support::InputError if they are not there, with where to get them and where to put them; for a fault of them
Experiment read_public(const PublicExperiment &experiment, const std::filesystem::path &given = {});

/// Refuses what no experiment can be: markers outside the body by more than half of its thickness or displacements
/// larger than it, as of another unit or frame; two markers in one place; numbers that are not finite where they are
/// needed; no marker to compare. The thickness is the smaller of the thinnest side of the box around the body and of
/// its mean chord 4 V / S.
/// @param place  named in messages
/// @throws support::InputError
void check(const Experiment &experiment, const std::string &place);

/// A sentence with the markers that are outside a body by more than a tenth of its thickness, and by how much.
/// @param outside  (K) distance of each marker from the body [m]; 0 inside
std::vector<std::string> doubts_about_markers(std::span<const Marker> markers, const core::TetraMesh &mesh,
                                              std::span<const double> outside);

/// The motion of each place that markers drive in a state.
/// @return by patch, in the order in which the markers name them
/// @throws support::InputError for fewer markers than the polynomial has coefficients
std::vector<PlaceMotion> driven_places(const Experiment &experiment, const MeasuredState &state);

/// A state on a body, with its driven places in motion.
core::Problem problem_of(const Experiment &experiment, const MeasuredState &state,
                         const std::shared_ptr<const core::Body> &body);

/// A damped oscillation.
struct Ringing {
    double frequency = std::numeric_limits<double>::quiet_NaN(); ///< of the damped oscillation [Hz]
    double ratio = std::numeric_limits<double>::quiet_NaN();     ///< zeta, of the decay exp(-2 pi f zeta t)
};

/// Records from one to before another.
struct Window {
    int first = 0, end = 0;
};

/// The damped oscillation that fits displacements best, in the mean square over all components of the markers:
///     u(t) = a + b t + exp(-2 pi f zeta t) (c cos 2 pi f t + d sin 2 pi f t),
/// with a, b, c and d of each component by linear least squares and one f and one zeta for all (variable projection:
/// Golub and Pereyra 1973, SIAM J. Numer. Anal. 10(2)). The line a + b t takes up a body that creeps while it rings.
/// @param markers  that count
/// @return NaN where displacements are not finite or the window has less than eight records
Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers, const Window &window);

/// The same of all records.
Ringing fit_ringing(const MarkerMotion &motion, std::span<const int> markers);

/// Measured quantity, and its uncertainty.
struct MeasuredRinging {
    Ringing value;                      ///< mean over repeats, of all markers and records
    double frequency_uncertainty = 0.0; ///< half the range over repeats, single markers and windows [Hz]
    double ratio_uncertainty = 0.0;     ///< the same
};

/// Windows are all records, those without the first period, and the first half.
MeasuredRinging measured_ringing(std::span<const MarkerMotion> repeats, std::span<const int> markers);

/// Swings of a body from each turning point to the next, from t = 0 on: half of the change of the mean
/// displacement of the markers, along the direction in which they move most at first. Turning points are looked for
/// within a quarter of a period around multiples of half a period.
/// @param frequency  of the motion [Hz]
/// @return shape (count) [m]; NaN beyond the last record
std::vector<double> swings(const MarkerMotion &motion, std::span<const int> markers, double frequency, int count);

/// Reads an experiment of a .toml file and a table of markers beside it (see read_markers()):
///
///     title = "A cylinder of gelatine under its own weight"
///     source = "who measured it, and where the data are"
///     assumptions = ["the base does not slide"]  # sentences on what was not measured; may be left out
///     markers = "markers.csv"
///     unit = "mm"                                # of the markers: "m", "cm", "mm" or a number of metres
///     noise = 0.0003                             # [m], root mean square length of the error of the displacement of a
///                                                # marker; may be left out
///     fit_degree = 2                             # of the polynomials that driven places move by; may be left out
///     [body]                                     # one of
///     box = { size = [0.08, 0.08, 0.06], edge_length = 0.01, corner = [0.0, 0.0, 0.0] }
///     cylinder = { radius = 0.03, height = 0.08, edge_length = 0.008, base = [0.0, 0.0, 0.0], quarter = false } #
///     along
///                                                # z; a quarter is between the planes through base across x and y
///     sphere = { radius = 0.03, edge_length = 0.008, centre = [0.0, 0.0, 0.0] }
///     file = "body.toml"                         # or a mesh, as livermark run takes them; has its own materials
///     finer = "finer.toml"                       # beside file, the same surface with more triangles: the reference is
///                                                # solved on it too, which tells the error of the shape
///     [material]                                 # of a box or cylinder
///     density = 1000.0                           # [kg/m^3]
///     young_modulus = 5000.0                     # [Pa]
///     poisson_ratio = 0.49
///     source = "where they are from"
///     laws = { yeoh = [0.05, 0.05] }             # dimensionless constants of hyperelastic laws; may be left out
///     [[state]]                                  # one or more, with the keys of a load case and
///     name = "standing"                          # the state of the table of markers
///     acceleration = [0.0, 0.0, -9.81]
///     [[state.condition]]
///     patch = "z_min"
///     displacement = [0.0, 0.0, 0.0]
///     [state.force]                              # how hard the body was pressed; markers may then be left out
///     table = "force.csv"                        # see read_force_table()
///     place = "z_max"                            # whose force it is; "touch" where a tool touches
///     fit_at = 0.0015                            # [m], where a modulus is fitted
///     compare_at = [0.003, 0.006]                # [m], the last one at the whole load
///     parts = 4                                  # the body is a quarter of what was measured; 1 if it is left out
///     length = 0.03                              # [m] of a uniform body along the way; may be left out
///     [state.ring_down]                          # how the body rang after it was let go; may be left out
///     motions = ["a.csv", "b.csv"]               # one or more of the same, see read_motion()
///     held = { patch = "z_max", force = [0.1, 0.0, 0.0] } # what held it: a condition of a load case with a force or a
///                                                # traction about as large
///     added_mass = { mass = 0.05, low = [-0.01, -0.01, 0.07], high = [0.01, 0.01, 0.08] } # of what hangs at it, in
///                                                # the tetrahedra whose middle is in this box; may be left out
///     damping_from = true                        # damping is fitted on this one; on the first if it stands nowhere
///
/// The regime of a state is "large" if it says nothing.
/// @param say  is told how many tetrahedra are expected before any is made; may be empty
/// @throws support::InputError with file, line and remedy
Experiment read_experiment(const std::filesystem::path &toml_file,
                           const std::function<void(const std::string &)> &say = {});

} // namespace livermark::experiments
