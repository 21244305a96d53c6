#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/util/files.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/core/base/ray.hpp"
#include "voxelserver/out/archive/split.hpp"

namespace terravox::publish {

/// A view that the viewer of a site offers by name. Level-0 voxels: x east, y up, z south.
struct SiteView {
    std::string name;
    core::Vec3 position;
    core::Vec3 target;
    double fov_deg = 40;  ///< vertical, [5, 120]
    /// What the page shows whole, in this direction, whatever the shape of its picture is.
    std::optional<voxel::VoxelBounds> frame = {};
};

/// A LiDAR square: where one of the files of the data lies. Units of the world's CRS.
struct SiteSquare {
    std::string name;
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
};

/// What a site says about its place.
struct SiteFacts {
    std::string title;
    std::string attribution;
    std::string licence;
    /// Files of the site that the archive lies in; not empty. Of a single one the name may be an
    /// address, and `bytes` is not used.
    std::vector<archive_tools::FilePart> archive;
    std::vector<SiteView> views;      ///< not empty; the first one is shown at the beginning
    std::vector<SiteSquare> squares;  ///< up to kMaxSquares; none: unknown, or other data
    std::int64_t time_ms = 0;         ///< of the sun, UTC, since 1970; [0, kMaxTime_ms]
    bool has_preview = false;         ///< kSitePreview is there
};

// What the page accepts (docs/formats/site.md).
inline constexpr std::size_t kMaxText_bytes = 4096;
inline constexpr double kMinFov_deg = 5;
inline constexpr double kMaxFov_deg = 120;
inline constexpr std::int64_t kMaxTime_ms = 7'258'118'400'000;  ///< the year 2200

/// The page reads the list when somebody asks what is at a point.
inline constexpr std::size_t kMaxSquares = 10'000;

inline constexpr const char* kSiteAppearance = "appearance.bin";
inline constexpr const char* kSiteArchive = "place.tvx";
inline constexpr const char* kSitePage = "index.html";
inline constexpr const char* kSitePlace = "place.json";
inline constexpr const char* kSitePreview = "preview.jpg";
inline constexpr const char* kSiteSquares = "squares.json";

/// Whether pages may read an archive at an address: the page's policy allows its own origin and
/// https (viewer.html).
/// @param url https://..., or a reference relative to the page; visible ASCII, without a fragment
///     or a user, of at most kMaxText_bytes
/// @throws UsageError otherwise
void check_archive_url(const std::string& url);

/// "https://HOST" of the address of an archive; empty for one of the page's own host, and for one
/// that check_archive_url() refuses.
[[nodiscard]] std::string to_origin(const std::string& url);

/// What the place.json of a folder says, which may be anybody's.
struct FoundSite {
    std::string archive_url;  ///< empty: the archive lies in parts, or is a server
};
/// @return nullopt for a folder that is no site
[[nodiscard]] std::optional<FoundSite> read_site(const std::filesystem::path& folder);

/// Copies an archive into a site: with the permissions that new files get, not with its own.
/// @throws Error; ChangedError when another program writes to it meanwhile
void copy_archive(const std::filesystem::path& from, const std::filesystem::path& to);

/// place.json (docs/formats/site.md).
[[nodiscard]] std::string place_json(const SiteFacts& facts);

/// squares.json: GeoJSON in the world's own CRS, as `/v2/squares` of a voxel server, with names.
[[nodiscard]] std::string squares_json(const std::vector<SiteSquare>& squares);

/// index.html: the viewer's, with the title and a description of the place, and the picture that
/// sites show next to a link. Texts are escaped.
[[nodiscard]] std::string index_html(const SiteFacts& facts);

/// Writes the viewer's files below viewer/, squares.json where there are squares, place.json and
/// index.html, then removes what an earlier site has left: an archive or parts of one, squares, and
/// a preview, that are not of these facts.
/// @param folder exists
/// @throws Error
void write_site(const std::filesystem::path& folder, const SiteFacts& facts);

/// The folder of a site while it is written: by one process at a time, and never over files of
/// others. A file with the lock lies in it meanwhile. It stays where the process ends before the
/// folder is a site, and tells the next run whose folder that is.
class SiteFolder {
public:
    /// Makes the folder where it is missing, takes the lock, and removes the unfinished files of
    /// killed runs.
    /// @param input a file that may lie in the folder, as what is published; empty: none
    /// @param overwrite the folder may hold anything
    /// @throws UsageError for a folder that is neither new, empty nor a site, and holds more than
    /// the input; Error when it cannot be made, or another process writes a site there
    SiteFolder(std::filesystem::path folder, const std::filesystem::path& input, bool overwrite);
    /// Removes the file of the lock, unless the folder holds something, and no site yet.
    ~SiteFolder();
    SiteFolder(const SiteFolder&) = delete;
    SiteFolder& operator=(const SiteFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    void take_lock();
    void remove_unfinished() const;

    const std::filesystem::path m_path;
    const std::filesystem::path m_input;
    std::optional<util::FileLock> m_lock;
};

/// The file of the lock, in the folder of a site.
inline constexpr const char* kSiteLock = ".terravox-publish.lock";

}  // namespace terravox::publish
