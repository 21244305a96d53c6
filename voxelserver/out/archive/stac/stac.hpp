#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace terravox::stac {

/// An instant, or the time from one to another, in UTC as RFC 3339 writes it:
/// "2023-04-01T00:00:00Z".
struct StacTime {
    std::string start;
    std::string end;  ///< not before `start`; the same: an instant
    [[nodiscard]] bool is_instant() const noexcept { return start == end; }
};

/// @param text a date (2023-04-01: all of that day) or an instant (2023-04-01T10:30:00Z), or two of
/// them with a slash between them
/// @throws UsageError for another text, a day that no calendar has, or an end before its start
[[nodiscard]] StacTime stac_time(const std::string& text);

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

/// What is written about archives for catalogues (SpatioTemporal Asset Catalog).
struct StacRequest {
    std::vector<std::filesystem::path> archives;  ///< not empty; each is one file
    std::filesystem::path folder;                 ///< of the items; made where it is missing
    StacTime time;  ///< when the data were taken: archives do not know that
    /// Address of the folder of the archives, https://example.org/data; empty: they lie in `folder`
    /// or below it, and are referred to relative to it.
    std::string href;
    /// Id of the collection; empty: none where there is one archive, else the folder's name.
    std::string collection;
    bool overwrite = false;
};

struct StacReport {
    std::vector<std::filesystem::path> files;  ///< that were written
    std::uint64_t holes = 0;                   ///< of all archives
};

/// Writes a STAC item NAME.json for each archive NAME.tvx and, for several or where it has an id, a
/// collection, collection.json (docs/formats/stac.md). All archives are read before the first file
/// is written. The bytes depend on the archives' headers, facts and indices and on the request.
/// Ref: SpatioTemporal Asset Catalog specification 1.0.0, 2021; its extensions Projection 1.1.0 and
/// File 2.1.0.
/// @throws UsageError when an archive has no place on Earth, lies elsewhere, or has the name of
/// another one, a shard or change is given, or a file is there already; Error when an archive
/// cannot be read, its place crosses the antimeridian or holds a pole, or a file cannot be written
StacReport write_stac(const StacRequest& request);

}  // namespace terravox::stac
