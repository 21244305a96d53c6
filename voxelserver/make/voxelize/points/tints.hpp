#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/voxel/material.hpp"

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::voxelize {

/// Settings::tints: whichever table is meant for the place.
inline constexpr const char* kAnyTints = "auto";

/// What the looks of a building are drawn from: equal ones look alike.
struct HouseNumber {
    std::uint64_t own = 0;       ///< depends on its place
    std::uint64_t district = 0;  ///< the same for all buildings of the district
    /// It is too wide to be known as one, and looks like most: the first colour of each list.
    bool typical = false;
};

/// Colours that buildings and trees of one material have, from which each takes one by a number
/// from its place. They are typical, not measured. Immutable, thread-safe.
class Tints {
public:
    /// Edge of the blocks of buildings whose colours are fewer, metres.
    static constexpr double kDistrict_m = 200;
    /// West, south, east, north in degrees; a longitude or latitude on the north or east edge is
    /// outside.
    using Region = std::array<double, 4>;

    /// Reads config/tints/<id>.toml. A path to a .toml file works too.
    /// @throws UsageError for an unknown id or a bad file, naming field, value and allowed range
    [[nodiscard]] static Tints load(const std::string& id_or_path);

    /// @param number of a tree; equal ones have equal colours
    /// @return nullopt for a material without colours
    [[nodiscard]] std::optional<voxel::Rgb8> of(voxel::Material material,
                                                std::uint64_t number) const noexcept;
    /// The same for a part of a building, with the share of buildings that keep to their district.
    [[nodiscard]] std::optional<voxel::Rgb8> of(voxel::Material material,
                                                const HouseNumber& house) const noexcept;

    /// Whether buildings too wide to be known as one have looks as well (HouseNumber::typical).
    [[nodiscard]] bool has_wide() const noexcept { return m_wide; }

    [[nodiscard]] const std::string& id() const noexcept { return m_id; }
    [[nodiscard]] const std::string& title() const noexcept { return m_title; }
    /// Where the table is meant: roughly. Empty: where no other one is.
    [[nodiscard]] const std::vector<Region>& regions() const noexcept { return m_regions; }

    /// Adds all values that results depend on, for a fingerprint.
    void add_values(voxel::ByteWriter& out) const;

private:
    [[nodiscard]] bool keeps_to_district(const HouseNumber& house) const noexcept;

    std::string m_id;
    std::string m_title;
    std::vector<Region> m_regions;
    double m_brightness = 0;      ///< each colour is up to this share brighter or darker
    double m_district_share = 0;  ///< of buildings that keep to the looks of their district
    bool m_wide = false;
    std::array<std::vector<voxel::Rgb8>, voxel::kMaterialCount> m_colours;
};

/// The tables of config/tints, by id.
/// @throws UsageError for a bad file, as Tints::load()
[[nodiscard]] std::vector<Tints> shipped_tints();

/// The table of this id or path. With kAnyTints the one meant for the place: of those whose
/// regions hold it, that with the smallest; else `default`. Logs which one was found and why.
/// @throws UsageError as Tints::load()
[[nodiscard]] Tints choose_tints(const std::string& wanted, const geo::LatLon& place);

}  // namespace terravox::voxelize
