#pragma once

#include <string>
#include <vector>

#include "meshes/generators/liver/liver_shape.hpp"

namespace livermark::meshes {

/// The liver of another person, which the generator can mesh.
struct LiverVariant {
    int number = 0;
    LiverShape shape;
    std::vector<Lesion> lesions;  ///< largest first
    double volume = 1.5e-3;       ///< [m^3]
    double body_surface = 0.0;    ///< of the person [m^2]
    double left_part = 0.0;       ///< of the volume, to the left of the falciform ligament
    bool has_riedel_lobe = false; ///< a tongue of the right lobe below the costal margin
    double front_to_back = 1.0;   ///< how thick it is, relative to the liver that ships at the same volume
};

/// Draws a liver by its number: the same number gives the same liver everywhere. What varies, and how far:
///   volume        a person's body surface of 1.8 +- 0.2 m^2 gives 1267 cm^3/m^2 S - 794 cm^3 (Vauthey 2002, Liver
///                 Transplantation 8(3)), +- 200 cm^3 for the rest; drawn again outside 0.9 to 2.2 L
///   left lobe     0.72 to 1.15 of the length and 0.85 to 1.2 of the thickness of the one that ships; the lateral
///   section
///                 has 5 to 27 % of the volume of livers (Abdalla 2004, Surgery 135(4))
///   height        of the right lobe, 0.92 to 1.12 (standard deviation of the height in the midclavicular line: 12 %;
///                 Kratzer 2003, Journal of Ultrasound in Medicine 22(11))
///   thickness     from front to back, 0.86 to 1.16, and of the visceral side; the impression of the stomach
///   Riedel's lobe every sixth, 20 to 60 mm long; found in 3 to 31 % of people (Gillard 1998, Clinical Anatomy 11(1))
///   lesions       0 to 8, 11 to 50 mm across, most of them small, at random places 9 mm or more below the capsule and
///                 14 mm or more from each other
/// Ranges of shape are an assumption that stays inside what the sources report; the numbers of lesions are drawn alike,
/// which is no patients' distribution.
/// @param number  >= 1
/// @throws support::InputError for another number
LiverVariant draw_liver(int number);

/// What was drawn, in one line.
std::string to_text(const LiverVariant &variant);

} // namespace livermark::meshes
