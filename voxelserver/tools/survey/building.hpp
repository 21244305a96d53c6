#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/roads.hpp"
#include "voxelserver/tools/survey/terrain.hpp"

namespace terravox::survey {

enum class RoofType : std::uint8_t { kGable, kHip, kFlat, kPyramid, kCone };
enum class RoofColour : std::uint8_t { kRed, kGrey, kPale, kCopper };
enum class BuildingUse : std::uint8_t {
    kHouse,
    kShed,
    kFarm,
    kHotel,
    kChurch,
    kCastle,
    kBalcony,
    kCarport,
    kCanopy,
    kPassage
};

[[nodiscard]] const char* to_name(RoofType) noexcept;
[[nodiscard]] const char* to_name(RoofColour) noexcept;
[[nodiscard]] const char* to_name(BuildingUse) noexcept;

inline constexpr double kDownToGround_m = -1e6;  ///< the underside of what stands on the ground

/// One box with a roof; a church or a castle is made of several. The footprint is a rectangle (a
/// circle for a cone). Balconies, carports, canopies and passages are slabs: there is air between
/// the ground and their underside.
struct Building {
    Vec2 centre;
    Vec2 direction{1, 0};      ///< of length 1, along the ridge
    double half_length_m = 5;  ///< along the ridge
    double half_width_m = 4;
    double ground_m = 0;  ///< lowest ground at the footprint
    double eaves_m = 0;   ///< height where the roof begins, sea level
    /// Highest point, sea level; equals the eaves for a flat roof (battlements rise 0.9 m more).
    double ridge_m = 0;
    double underside_m = kDownToGround_m;  ///< of a slab, sea level
    RoofType roof = RoofType::kGable;
    RoofColour colour = RoofColour::kRed;
    BuildingUse use = BuildingUse::kHouse;
    bool battlements = false;
    std::uint32_t tint = 0;  ///< random, for the shade of the roof

    /// @return height of roof or battlement above p, or nullopt outside the footprint
    [[nodiscard]] std::optional<double> top_m(Vec2 p) const noexcept;
    /// Anticlockwise.
    [[nodiscard]] std::array<Vec2, 4> corners(double margin_m = 0) const noexcept;
    /// The footprint as a ring, anticlockwise; 12 corners for a circle.
    [[nodiscard]] std::vector<Vec2> outline() const;
    [[nodiscard]] Box2 bounds() const noexcept;
    [[nodiscard]] bool open_beneath() const noexcept { return underside_m > kDownToGround_m; }
    [[nodiscard]] double top_of_all_m() const noexcept {
        return ridge_m + (battlements ? 0.9 : 0.0);
    }
};

/// @return whether the footprints, each widened by `margin_m`, overlap (separating axes; exact for
/// rectangles)
[[nodiscard]] bool footprints_overlap(const Building& a, const Building& b,
                                      double margin_m) noexcept;

/// All buildings of a site: castle, churches, hotels, the houses along its streets, and the
/// balconies and carports at some of them. No two overlap, except parts of one landmark; none
/// stands on a road or in water. A function of seed and site only.
/// @param terrain made for an area that holds the site, or for one no farther than kSiteReach_m
/// from its centre
[[nodiscard]] std::vector<Building> build_village(const Terrain& terrain, const Site& site);

/// The landmarks alone. They come first in build_village.
[[nodiscard]] std::vector<Building> build_landmarks(const Terrain& terrain, const Site& site);

}  // namespace terravox::survey
