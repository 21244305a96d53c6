#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/geo/lat_lon.hpp"
#include "common/util/error.hpp"

namespace terravox::geo {

/// The longest accepted text of a coordinate reference system (CRS), in bytes: the capacity of a
/// variable length record of a LAS file.
inline constexpr std::size_t kLongestCrsText = 65'535;

/// The three accepted notations of a CRS.
enum class CrsNotation {
    kCode,  ///< AUTHORITY:CODE or AUTHORITY:CODE+CODE, of EPSG, ESRI, IGNF or OGC
    kWkt,   ///< well-known text, version 1 or 2
    kProj,  ///< a PROJ string: +proj=utm +zone=33
};

/// Decides by the first characters only; the rest is not checked.
[[nodiscard]] CrsNotation find_notation(std::string_view text) noexcept;

/// Checks the text of a CRS before it is passed to PROJ, which opens any path that such a text
/// names: in +nadgrids, +init and +grids, in PARAMETERFILE, in EXTENSION["PROJ4"], in METHOD["PROJ
/// ..."], in GEOIDMODEL["PROJ ..."]. Only text that is known to name no file passes: fixed lists of
/// authorities, of WKT keywords (nested at most 16 deep) and of PROJ parameters. A geoid of a
/// vertical datum may be given by a bare file name, as it is in many data files: heights are never
/// converted, so that file is never searched for. Thread-safe; reads nothing but the text.
/// @return what is wrong, as the end of a message; empty when the text is accepted
[[nodiscard]] std::string fault_of_crs_text(std::string_view text);

/// PROJ cannot read its own database: the text of the coordinate reference system is not at fault.
class ProjUnusableError : public util::Error {
public:
    using util::Error::Error;
};

/// Must be called when PROJ has failed to parse something, before the text is blamed: without
/// memory, file descriptors or its database, PROJ rejects every text and does not report why.
/// Thread-safe.
/// @param attempt  the beginning of the message, such as "read the coordinate reference system
/// 'EPSG:3794'"
/// @throws ProjUnusableError
void check_proj_is_usable(const std::string& attempt);

}  // namespace terravox::geo

class OGRSpatialReference;
class OGRCoordinateTransformation;

namespace terravox::geo {

/// A coordinate reference system, built from a name, WKT or GeoTIFF keys. A value type; copying is
/// cheap. The axis order is always easting, northing (longitude, latitude), whatever the authority
/// defines.
class Crs {
public:
    /// Parses text that a user entered. No text can make PROJ open a file or access the network
    /// (see above).
    /// @param text EPSG:n (ESRI, IGNF and OGC too, EPSG:n+m with a vertical system), WKT 1 or 2, or
    /// a PROJ string
    /// @throws UsageError naming the text when it is refused or cannot be parsed
    static Crs from_text(const std::string& text);

    /// Parses text that was read from a file or received from another program.
    /// @param wkt WKT 1 or 2, and nothing else
    /// @throws Error naming the text when it is refused or cannot be parsed
    static Crs from_wkt(const std::string& wkt);

    /// Parses what a file says in a comment or a side file.
    /// @param text EPSG:n, EPSG:n+m or WKT
    /// @throws Error naming the text when it is refused or cannot be parsed
    static Crs from_file_text(const std::string& text);

    /// Reads the .prj file next to a file, as GIS programs write it.
    /// @return nullopt where there is none
    /// @throws Error when it cannot be read, or says no system that can be used
    static std::optional<Crs> from_side_file(const std::filesystem::path& file);

    /// @param read what GDAL has read of a file, or null
    /// @return the same, or null where it does not say where on the Earth the file is: a site's own
    /// grid, or a unit alone
    [[nodiscard]] static const OGRSpatialReference* placing(const OGRSpatialReference* read);

    /// Wraps a system that GDAL has read, e.g. that of an image.
    /// @param origin where the system comes from, for messages: a file's name
    /// @throws Error naming the origin when the system names files for PROJ to open
    static Crs from_ogr(const OGRSpatialReference& ogr, const std::string& origin);

    /// Reads the three GeoTIFF VLRs of a LAS file (LASF_Projection 34735, 34736, 34737); the last
    /// two may be empty.
    /// @return nullopt when the keys name no system
    /// @throws Error when the system names files for PROJ to open, or heights are in a unit that is
    /// not known
    static std::optional<Crs> from_geokeys(std::span<const std::uint16_t> directory,
                                           std::span<const double> doubles,
                                           std::span<const char> ascii);

    [[nodiscard]] const OGRSpatialReference& ogr() const noexcept { return *m_ogr; }
    /// "EPSG:3794" when an authority is known, else the CRS's own name.
    [[nodiscard]] std::string name() const;
    [[nodiscard]] std::string wkt() const;  ///< WKT 2 (2019), one line
    /// Whether coordinates are in degrees.
    [[nodiscard]] bool geographic() const noexcept { return m_geographic; }
    /// Whether this is EPSG:3857 or an equivalent: lengths are stretched by 1 / cos(latitude).
    [[nodiscard]] bool pseudo_mercator() const;
    /// Metres per horizontal unit; 1 for geographic systems.
    [[nodiscard]] double metres_per_unit() const noexcept { return m_metres_per_unit; }
    /// Metres per vertical unit; nullopt when the system has no vertical part.
    [[nodiscard]] std::optional<double> vertical_metres_per_unit() const noexcept {
        return m_vertical_metres;
    }
    /// The reference of heights, when the system defines it: the name of its vertical datum, or
    /// "ellipsoid" for a three-dimensional system.
    [[nodiscard]] std::optional<std::string> vertical_datum() const;
    [[nodiscard]] bool same_horizontal(const Crs& other) const;

private:
    explicit Crs(std::shared_ptr<const OGRSpatialReference> ogr);
    std::shared_ptr<const OGRSpatialReference> m_ogr;
    // Asked once: GDAL keeps answers in the object, without a lock, and copies share it.
    bool m_geographic = false;
    double m_metres_per_unit = 1;
    std::optional<double> m_vertical_metres;
};

/// The unit of heights that GeoTIFF keys state (VerticalUnitsGeoKey). It counts before that of the
/// vertical system's code, which GDAL prefers: files in feet under the code of a system in metres
/// are common.
struct KeyedUnit {
    std::uint16_t code = 0;  ///< of EPSG; 0: they state none
    /// nullopt: another than metre, foot (both feet) and US survey foot
    std::optional<double> metres;
    bool has_system = false;  ///< whether they state a vertical system, too
};
/// @param directory the payload of the tag or record 34735
[[nodiscard]] KeyedUnit vertical_unit_of_keys(std::span<const std::uint16_t> directory);
inline constexpr std::uint16_t kUserDefinedKey = 32767;
inline constexpr const char* kKeyedUnits = "9001 (metre), 9002 (foot), 9003 (US survey foot)";

/// Transforms horizontal coordinates between two systems. Not thread-safe: use one per thread.
class Transform {
public:
    /// @throws Error when PROJ has no operation between the two systems
    Transform(const Crs& from, const Crs& to);
    ~Transform();
    Transform(Transform&&) noexcept;
    Transform& operator=(Transform&&) noexcept;

    /// Transforms in place.
    /// @throws Error when a point lies outside the domain of either system
    void apply(std::span<double> x, std::span<double> y) const;

    /// The least rectangle in the other system around one of this, both as west, south, east,
    /// north; up to what its edges bend between a few points.
    /// @throws Error as apply()
    [[nodiscard]] std::array<double, 4> around(const std::array<double, 4>& rect) const;

private:
    std::string m_between;  ///< "A to B", for messages
    std::unique_ptr<OGRCoordinateTransformation> m_ogr;
};

/// @throws Error outside the domain of `crs`
[[nodiscard]] LatLon to_lat_lon(const Crs& crs, double easting, double northing);

/// A place of a map, with the map's direction there: that of the short line on the ellipsoid
/// between two points of the map, 10 units south and north of it. Rounded to 1e-8 degrees, and the
/// direction to 1e-6, so that all versions of PROJ say the same.
/// @throws Error outside the domain of `crs`
[[nodiscard]] MapPlace map_place(const Crs& crs, double easting, double northing);

}  // namespace terravox::geo
