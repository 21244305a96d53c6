#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "voxelserver/out/archive/stac/stac_time.hpp"

namespace terravox::stac {

/// What an item says of one archive.
struct StacItem {
    std::string id;                    ///< the archive's name without ending
    std::array<double, 4> bbox_deg{};  ///< west, south, east, north; WGS 84
    std::string licence;               ///< as STAC names licences
    std::uint64_t holes = 0;
    nlohmann::ordered_json json;
};

inline constexpr const char* kStacVersion = "1.0.0";
inline constexpr const char* kStacCollection = "collection.json";

/// @param href where the archive lies, from where the item lies
/// @param collection id; empty: none
/// @throws as write_stac()
[[nodiscard]] StacItem stac_item(const std::filesystem::path& archive, const StacTime& time,
                                 const std::string& href, const std::string& collection);

/// A link of an item or a collection.
[[nodiscard]] nlohmann::ordered_json stac_link(const char* rel, const std::string& href,
                                               const char* type);

/// A name as one segment of an address: all but unreserved characters as %XX.
[[nodiscard]] std::string url_segment(const std::string& name);

}  // namespace terravox::stac
