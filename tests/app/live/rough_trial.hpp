#pragma once

#include <cstdint>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "app/live/scene.hpp"

/// Acts of a reckless user on a body of the live page, at random and the same every time.
namespace livermark::live {

/// A body, and what of its boundary is constrained: a shipped liver by palpation; `beam` at its end x = 0;
/// `small_beam`, a box of 120 x 40 x 40 mm and 63 nodes, `lump`, one of 60 x 30 x 30 mm with a hard middle, and
/// `covered`, one with a capsule, a vessel and a map of stiffness, at the same end.
struct TrialBody {
    core::Body body;
    std::vector<bool> is_constrained; ///< (T)
};

/// @throws support::InputError for another name
TrialBody trial_body(const std::string &name);

struct BackToRest {};
struct Keep {};
struct Undo {};
/// A tool that does the same for some time.
struct Handle {
    Tool tool;
    double seconds = 0.0;
};
using Act = std::variant<Settings, Handle, BackToRest, Keep, Undo>;

/// Steps of a trial. Each is one thing that is done to the body, as tools that jump to where they are led: a poke up to
/// 40 mm deep; a pull by 60 mm; a tool that is led about; three nodes that are pulled by up to 300 m and then by 4 mm;
/// other springs and another material while a tool is held; a pull and back to rest; a poke and undo. Then the tool is
/// let go for up to 60 ms, and somewhere a finger of 12 mm pokes 2 mm deep.
class RoughTrial {
  public:
    /// @param lowest_poisson_ratio  of the materials; the highest is 0.49
    RoughTrial(const TrialBody &body, std::uint32_t seed, double lowest_poisson_ratio);

    /// Acts of the next step, in order. The finger's poke comes last.
    std::vector<Act> next();

  private:
    struct Place {
        int node = 0;
        core::Vector3 point, normal; ///< of the surface, outwards
    };
    double number(double least, double most);
    double magnitude(double least, double most);
    core::Vector3 within(double largest);
    bool is_one_in(unsigned int count) { return random_() % count == 0; }
    const Place &place() { return places_[random_() % places_.size()]; }
    Tool poke(double deepest);
    Tool pull(double furthest);
    Settings other_settings();
    void lead_about(std::vector<Act> &acts);
    void tear(std::vector<Act> &acts);
    void do_something(std::vector<Act> &acts);

    std::vector<Place> places_;
    std::mt19937 random_;
    double lowest_poisson_ratio_;
};

/// Outcome of a trial.
struct TrialOutcome {
    int num_steps = 0, num_tools = 0, num_choices = 0;
    int num_restarts = 0;         ///< motions that were lost, and set back to rest
    int num_small_lost = 0;       ///< of these in a finger's poke
    int num_not_finite = 0;       ///< frames with a number that is none
    double strongest = 0.0;       ///< force on a tool [N]
    double furthest = 0.0;        ///< displacement of a node [m]
    double smallest_volume = 1.0; ///< on the way
    bool is_fresh = false;        ///< whether at the end, after back to rest, it moves to the last bit as a fresh scene
    /// The same as messages: the body, and then those of live::reply().
    std::vector<std::vector<double>> messages;
};

/// Takes steps of a trial, with the picture asked for each 1/60 s.
/// @param lowest_poisson_ratio  in [0, 0.49]
TrialOutcome take_trial(const std::string &body, int num_steps, std::uint32_t seed, double lowest_poisson_ratio = 0.25);

} // namespace livermark::live
