#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "raytracer/core/ray.hpp"

namespace terravox::publish {

/// A view that the viewer of a site offers by name. Level-0 voxels: x east, y up, z south.
struct SiteView {
    std::string name;
    core::Vec3 position;
    core::Vec3 target;
    double fov_deg = 40;  ///< vertical, [5, 120]
};

/// One of the files that an archive lies in, in their order.
struct ArchivePart {
    std::string name;  ///< of the file, in the site's folder
    std::uint64_t bytes = 0;
};

/// What a site says about its place.
struct SiteFacts {
    std::string title;
    std::string attribution;
    std::string licence;
    std::vector<ArchivePart> archive;  ///< not empty; one: the archive itself
    std::vector<SiteView> views;       ///< not empty; the first one is shown at the beginning
    std::int64_t time_ms = 0;          ///< of the sun, UTC, since 1970; not negative
};

inline constexpr const char* kSiteArchive = "place.tvx";
inline constexpr const char* kSitePreview = "preview.jpg";

/// place.json (docs/formats/site.md).
[[nodiscard]] std::string place_json(const SiteFacts& facts);

/// index.html: the viewer's, with the title and a description of the place, and a picture for those
/// who show links. Texts are escaped.
[[nodiscard]] std::string index_html(const SiteFacts& facts);

/// Writes place.json, the viewer's files below viewer/, and last index.html.
/// @param folder exists
/// @throws Error
void write_site(const std::filesystem::path& folder, const SiteFacts& facts);

/// Cuts an archive into files of at most so many bytes next to it, place-0001.part and following,
/// for hosts that limit the size of files; removes the archive, and parts of an earlier one.
/// @param max_bytes above 0
/// @return the parts; the archive itself where it is small enough
/// @throws Error
[[nodiscard]] std::vector<ArchivePart> split_archive(const std::filesystem::path& archive,
                                                     std::uint64_t max_bytes);

}  // namespace terravox::publish
