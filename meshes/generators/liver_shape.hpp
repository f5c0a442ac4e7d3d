#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/mesh/tetra_mesh.hpp"

namespace livermark::meshes {

/// Axes of all liver functions: LPS as in DICOM, x to the patient's left, y posterior, z superior [m]; the origin is
/// near the centroid.

/// Shape parameters that vary from one liver to the next. Lengths without a unit are those of the drawing, in
/// millimetres about a point under the right dome; as they stand here they are the liver that ships.
struct LiverShape {
    /// A little flatter from front to back than drawn; makes the body 1.50 L.
    core::Vector3 metres_per_unit{1.0496e-3, 0.9640e-3, 1.0496e-3};
    core::Vector3 centroid{-30.5, -7.5, 9.8};   ///< what comes to the origin
    core::Vector3 right_lobe{73.0, 63.0, 92.0}; ///< semi-axes
    core::Vector3 left_lobe{91.0, 43.0, 38.0};  ///< semi-axes
    core::Vector3 stomach{66.0, 46.0, 50.0};    ///< semi-axes of its impression
    double visceral_height = -23.0;             ///< where the visceral plane meets the axis; lower is a thicker liver
    double tongue_length = 0.0;                 ///< how far a Riedel's lobe reaches below the right lobe; 0 for none
};

/// Level function of the liver: negative inside, positive outside, zero on the capsule, and close to the signed
/// distance [m] near it. A smooth blend of ellipsoids, cylinders and planes written with + - * / sqrt alone, which IEEE
/// 754 rounds in one way only, so that the same liver comes out wherever it is built (exp, sin and pow do not promise
/// that).
/// @param point  [m]
double liver_level(const core::Vector3 &point, const LiverShape &shape = {});

/// Depth of a point under the convex side, before stomach, kidney and the other neighbours press in [m]: near zero
/// on the diaphragmatic surface, positive on the visceral one.
double diaphragmatic_depth(const core::Vector3 &point, const LiverShape &shape = {});

/// Gradient of the level function by central differences: outward and close to unit length near the capsule.
core::Vector3 liver_gradient(const core::Vector3 &point, const LiverShape &shape = {});

/// The point of the capsule reached from a nearby point by Newton steps along the normal.
core::Vector3 project_to_liver(core::Vector3 point, const LiverShape &shape = {});

/// Corners of a box [m] that holds the whole capsule of the liver that ships.
std::array<core::Vector3, 2> liver_bounding_box();
/// The same for any shape.
std::array<core::Vector3, 2> liver_bounding_box(const LiverShape &shape);

/// Begin of the patch of the left lobe's tip: x [m].
double left_lobe_tip_begin(const LiverShape &shape);

/// End of the left lobe's ellipsoid: x [m].
double left_lobe_end(const LiverShape &shape);

/// An ellipsoidal lesion.
struct Lesion {
    core::Vector3 center;              ///< [m]
    core::Vector3 semi_axes;           ///< [m]
    std::array<core::Vector3, 3> axes; ///< orthonormal, right-handed
};

/// The six lesions of the body with tumours, largest first: 49 to 12 mm across, in both lobes.
std::vector<Lesion> liver_lesions();

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

/// Values drawn, in one line.
std::string to_text(const LiverVariant &variant);

} // namespace livermark::meshes
