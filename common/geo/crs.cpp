#include "common/geo/crs.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <numbers>
#include <system_error>

#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"

namespace terravox::geo {

namespace {

// Where memory is short, PROJ may still find a coordinate reference system that it has read before,
// although it has just failed to read another one.
bool has_memory() noexcept {
    try {
        check_memory_for_gdal();
        return true;
    } catch (...) {
        return false;
    }
}

}  // namespace

void check_proj_is_usable(const std::string& attempt) {
    const GdalErrorScope errors;
    constexpr int kKnownToAll = 4326;  // WGS 84
    OGRSpatialReference known;
    if (has_memory() && known.importFromEPSG(kKnownToAll) == OGRERR_NONE)
        return;
    throw ProjUnusableError(attempt +
                            ": PROJ cannot use its database (package proj-data), or lacks memory "
                            "or descriptors for it");
}

namespace {

// A library into which PROJ is compiled has PROJ's database next to it: that of the system may be
// missing, or of another version.
void use_own_proj_data() {
    const std::filesystem::path folder = util::beside_program("proj");
    std::error_code ignored;
    if (!std::filesystem::exists(folder / "proj.db", ignored))
        return;
    const std::string name = folder.string();
    const char* const folders[] = {name.c_str(), nullptr};
    OSRSetPROJSearchPaths(folders);
}

std::shared_ptr<OGRSpatialReference> empty_reference() {
    // PROJ would download missing grids if the user's PROJ_NETWORK or proj.ini enables that:
    // coordinates must not depend on it.
    static std::once_flag once;
    std::call_once(once, [] {
        OSRSetPROJEnableNetwork(0);
        use_own_proj_data();
    });
    auto ogr = std::shared_ptr<OGRSpatialReference>(new OGRSpatialReference,
                                                    [](OGRSpatialReference* p) { p->Release(); });
    ogr->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return ogr;
}

// A one-pixel TIFF in memory with the three GeoTIFF tags: GDAL's own driver then interprets the
// keys, with all their user-defined parameters, which no public function of GDAL does from memory.
std::vector<std::uint8_t> tiff_with_keys(std::span<const std::uint16_t> directory,
                                         std::span<const double> doubles,
                                         std::span<const char> ascii) {
    std::vector<std::uint8_t> out;
    const auto put = [&](const void* data, std::size_t bytes) {
        const auto* first = static_cast<const std::uint8_t*>(data);
        out.insert(out.end(), first, first + bytes);
    };
    const auto put16 = [&](std::uint16_t v) { put(&v, 2); };
    const auto put32 = [&](std::uint32_t v) { put(&v, 4); };
    struct Tag {
        std::uint16_t id;
        std::uint16_t type;
        std::uint32_t count;
        std::uint32_t value;
    };
    std::vector<Tag> tags = {{256, 3, 1, 1}, {257, 3, 1, 1}, {258, 3, 1, 8},
                             {259, 3, 1, 1}, {262, 3, 1, 1}, {273, 4, 1, 8},
                             {277, 3, 1, 1}, {278, 3, 1, 1}, {279, 4, 1, 1}};
    std::uint32_t entries = 10 + (doubles.empty() ? 0 : 1) + (ascii.empty() ? 0 : 1);
    std::uint32_t data_at = 16 + 2 + entries * 12 + 4;
    const std::uint32_t directory_at = data_at;
    tags.push_back({34735, 3, static_cast<std::uint32_t>(directory.size()), directory_at});
    data_at += static_cast<std::uint32_t>(directory.size_bytes());
    const std::uint32_t doubles_at = data_at;
    if (!doubles.empty())
        tags.push_back({34736, 12, static_cast<std::uint32_t>(doubles.size()), doubles_at});
    data_at += static_cast<std::uint32_t>(doubles.size_bytes());
    if (!ascii.empty())
        tags.push_back({34737, 2, static_cast<std::uint32_t>(ascii.size()), data_at});
    put("II", 2);
    put16(42);
    put32(16);
    const std::array<std::uint8_t, 8> pixel{};
    put(pixel.data(), pixel.size());
    put16(static_cast<std::uint16_t>(tags.size()));
    for (const Tag& tag : tags) {
        put16(tag.id);
        put16(tag.type);
        put32(tag.count);
        put32(tag.value);
    }
    put32(0);
    put(directory.data(), directory.size_bytes());
    put(doubles.data(), doubles.size_bytes());
    put(ascii.data(), ascii.size());
    return out;
}

struct LengthUnit {
    const char* name;
    double metres;
    const char* digits;  // the same, as written in WKT
};

constexpr std::uint16_t kVerticalSystem = 4096;
constexpr std::uint16_t kVerticalUnits = 4099;

/// @return 0 where the key is not there
std::uint16_t stated_code(std::span<const std::uint16_t> directory, std::uint16_t key) {
    for (std::size_t i = 4; i + 3 < directory.size(); i += 4)
        if (directory[i] == key && directory[i + 1] == 0)
            return directory[i + 3];
    return 0;
}

std::optional<LengthUnit> find_unit(std::uint16_t code) {
    constexpr std::uint16_t kMetre = 9001;
    constexpr std::uint16_t kFoot = 9002;
    constexpr std::uint16_t kUsSurveyFoot = 9003;
    switch (code) {
        case kMetre: return LengthUnit{"metre", 1, "1"};
        case kFoot: return LengthUnit{"foot", 0.3048, "0.3048"};
        case kUsSurveyFoot: return LengthUnit{"US survey foot", 1200.0 / 3937, "0.304800609601219"};
        default: return std::nullopt;
    }
}

void set_vertical_unit(OGRSpatialReference& ogr, const LengthUnit& unit) {
    if (ogr.IsVertical() != 0 && std::abs(ogr.GetTargetLinearUnits("VERT_CS") - unit.metres) < 1e-9)
        return;
    const std::string name = std::string("height (") + unit.name + ")";
    const std::string wkt =
        "VERTCRS[\"" + name +
        "\",VDATUM[\"unknown\"],CS[vertical,1],AXIS[\"height\",up],LENGTHUNIT[\"" + unit.name +
        "\"," + unit.digits + "]]";
    OGRSpatialReference heights(wkt.c_str()), flat(ogr);
    flat.StripVertical();
    ogr.SetCompoundCS((std::string(flat.GetName()) + " + " + name).c_str(), &flat, &heights);
}

std::string attempt_to_read(const std::string& text) {
    constexpr std::size_t kShown = 120;
    std::string shown = text.substr(0, kShown);
    std::replace_if(
        shown.begin(), shown.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; },
        ' ');
    return "read the coordinate reference system '" + shown + "': ";
}

// The fault of a text that PROJ refuses.
// @throws ProjUnusableError when the text is not at fault
std::string not_understood(const std::string& text) {
    check_proj_is_usable(attempt_to_read(text) + "not possible");
    return "not understood";
}

// What is wrong with a system that PROJ has understood; empty for one that places coordinates on
// the Earth. A site's own grid, or a unit alone, does not, and of three axes from the Earth's
// centre none is a height.
std::string fault_of_placing(const OGRSpatialReference& ogr) {
    if (ogr.IsProjected() != 0 || ogr.IsGeographic() != 0)
        return "";
    if (ogr.IsGeocentric() != 0)
        return "its axes begin at the Earth's centre, and none is a height; convert the data";
    const char* const name = ogr.GetName();
    return "it does not say where on the Earth '" + std::string(name != nullptr ? name : "") +
           "' is";
}

// One line; empty when the format cannot express the system.
std::string exported(const OGRSpatialReference& ogr, const char* format) {
    char* text = nullptr;
    const char* const options[] = {format, "MULTILINE=NO", nullptr};
    const bool done = ogr.exportToWkt(&text, options) == OGRERR_NONE;
    std::string out = done && text != nullptr ? text : "";
    CPLFree(text);
    return out;
}

}  // namespace

Crs::Crs(std::shared_ptr<const OGRSpatialReference> ogr)
    : m_ogr(std::move(ogr)), m_geographic(m_ogr->IsGeographic() != 0) {
    if (!m_geographic)
        m_metres_per_unit = m_ogr->GetLinearUnits();
    if (m_ogr->IsVertical() != 0)
        m_vertical_metres = m_ogr->GetTargetLinearUnits("VERT_CS");
}

Crs Crs::from_text(const std::string& text) {
    const GdalErrorScope errors;
    auto ogr = empty_reference();
    std::string fault = fault_of_crs_text(text);
    if (fault.empty() &&
        ogr->SetFromUserInput(text.c_str(), OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS) !=
            OGRERR_NONE)
        fault = not_understood(text);
    if (fault.empty())
        fault = fault_of_placing(*ogr);
    if (!fault.empty())
        throw util::UsageError(
            "{}{}; allowed: EPSG:<code>, WKT or a PROJ string, without names of files",
            attempt_to_read(text), fault);
    return Crs(std::move(ogr));
}

Crs Crs::from_wkt(const std::string& wkt) {
    const GdalErrorScope errors;
    auto ogr = empty_reference();
    std::string fault =
        find_notation(wkt) == CrsNotation::kWkt ? fault_of_crs_text(wkt) : "no well-known text";
    if (fault.empty() && ogr->importFromWkt(wkt.c_str()) != OGRERR_NONE)
        fault = not_understood(wkt);
    if (fault.empty())
        fault = fault_of_placing(*ogr);
    if (!fault.empty())
        throw util::Error("{}{}; allowed: WKT without names of files", attempt_to_read(wkt), fault);
    return Crs(std::move(ogr));
}

Crs Crs::from_file_text(const std::string& text) {
    // PROJ strings are accepted from users only.
    constexpr std::string_view kAuthority = "EPSG:";
    constexpr std::string_view kNumbers = "0123456789+";
    const std::string trimmed(util::trimmed(text));
    const bool is_epsg =
        trimmed.starts_with(kAuthority) && trimmed.size() > kAuthority.size() &&
        trimmed.find_first_not_of(kNumbers, kAuthority.size()) == std::string::npos;
    return is_epsg ? from_text(trimmed) : from_wkt(trimmed);
}

std::optional<Crs> Crs::from_side_file(const std::filesystem::path& file) {
    for (const char* const ending : {".prj", ".PRJ"}) {
        std::filesystem::path side = file;
        side.replace_extension(ending);
        std::error_code failed;
        if (std::filesystem::is_regular_file(side, failed) && side != file)
            return from_file_text(util::read_text(side, kLongestCrsText, "read " + side.string()));
    }
    return std::nullopt;
}

const OGRSpatialReference* Crs::placing(const OGRSpatialReference* read) {
    return read != nullptr && fault_of_placing(*read).empty() ? read : nullptr;
}

Crs Crs::from_ogr(const OGRSpatialReference& read, const std::string& origin) {
    const GdalErrorScope errors;
    // WKT 2 describes the system completely; WKT 1, which cannot represent every system, contains
    // what GDAL passes to PROJ in addition (EXTENSION).
    std::string fault = fault_of_crs_text(exported(read, "FORMAT=WKT2_2019"));
    if (const std::string older = exported(read, "FORMAT=WKT1_GDAL");
        fault.empty() && !older.empty())
        fault = fault_of_crs_text(older);
    if (!fault.empty())
        throw util::Error(
            "read the coordinate reference system of {}: {}; allowed: one without names of files",
            origin, fault);
    auto ogr = empty_reference();
    *ogr = read;
    ogr->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    return Crs(std::move(ogr));
}

std::optional<Crs> Crs::from_geokeys(std::span<const std::uint16_t> directory,
                                     std::span<const double> doubles, std::span<const char> ascii) {
    constexpr std::size_t kHeaderWords = 4;
    constexpr std::size_t kMaxKeys = 4096;
    if (directory.size() < 2 * kHeaderWords || directory.size() > kMaxKeys * 4)
        return std::nullopt;
    const GdalErrorScope errors;
    start_gdal();
    static std::atomic<unsigned> counter{0};
    const std::string name = "/vsimem/terravox-geokeys-" + std::to_string(counter++) + ".tif";
    auto bytes = tiff_with_keys(directory, doubles, ascii);
    VSIFCloseL(VSIFileFromMemBuffer(name.c_str(), bytes.data(), bytes.size(), FALSE));
    const auto forget = [](const std::string* file) { VSIUnlink(file->c_str()); };
    const std::unique_ptr<const std::string, decltype(forget)> forgotten_at_the_end(&name, forget);
    std::optional<Crs> crs;
    const std::uint16_t code = stated_code(directory, kVerticalUnits);
    const auto unit = find_unit(code);
    bool is_known = code == 0 || unit;
    // Without this, GDAL ignores the vertical keys of GeoTIFF 1.0, which LAS files contain: heights
    // in feet would be read as metres.
    const CPLConfigOptionSetter with_vertical("GTIFF_REPORT_COMPD_CS", "YES", false);
    const char* const only_tiff[] = {"GTiff", nullptr};
    if (GDALDatasetUniquePtr image{
            GDALDataset::Open(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, only_tiff)}) {
        const OGRSpatialReference* found = image->GetSpatialRef();
        if (found != nullptr && fault_of_placing(*found).empty()) {
            OGRSpatialReference read(*found);
            if (unit)
                set_vertical_unit(read, *unit);
            // GDAL knows more units than those that count before the code's. GDAL 3.10 takes others
            // for metres, and has none but that of 9001 with its length.
            is_known =
                is_known || (read.IsVertical() != 0 && read.GetTargetLinearUnits("VERT_CS") != 1);
            crs = from_ogr(read, "GeoTIFF keys");
        }
    }
    if (!is_known)
        throw util::Error("read the GeoTIFF keys: unit of heights = {}; allowed: {}", code,
                          kKeyedUnits);
    if (!crs)
        check_proj_is_usable("read the GeoTIFF keys of a coordinate reference system");
    return crs;
}

KeyedUnit vertical_unit_of_keys(std::span<const std::uint16_t> directory) {
    KeyedUnit out{stated_code(directory, kVerticalUnits), std::nullopt,
                  stated_code(directory, kVerticalSystem) != 0};
    if (const auto unit = find_unit(out.code))
        out.metres = unit->metres;
    return out;
}

std::string Crs::name() const {
    const char* authority = m_ogr->GetAuthorityName(nullptr);
    const char* code = m_ogr->GetAuthorityCode(nullptr);
    if (authority != nullptr && code != nullptr)
        return std::string(authority) + ":" + code;
    const char* own = m_ogr->GetName();
    return own != nullptr ? own : "unnamed";
}

std::string Crs::wkt() const {
    return exported(*m_ogr, "FORMAT=WKT2_2019");
}

bool Crs::pseudo_mercator() const {
    // WKT 2 names the method, whichever authority's code the system has (EPSG:3857, ESRI:102100),
    // or if it has none.
    return wkt().find("METHOD[\"Popular Visualisation Pseudo Mercator\"") != std::string::npos;
}

std::optional<std::string> Crs::vertical_datum() const {
    if (m_ogr->IsCompound() == 0 && m_ogr->IsVertical() == 0)
        return m_ogr->GetAxesCount() == 3 ? std::optional<std::string>("ellipsoid") : std::nullopt;
    const char* name = m_ogr->GetAttrValue("VERT_DATUM");
    // A system that consists only of a unit has such a name: from set_vertical_unit, or in files of
    // other programs.
    const auto nothing = {"unknown", "unnamed", "not specified"};
    const auto begins = [&](const char* words) { return EQUALN(name, words, std::strlen(words)); };
    if (name == nullptr || *name == '\0' || std::any_of(nothing.begin(), nothing.end(), begins))
        return std::nullopt;
    return name;
}

bool Crs::same_horizontal(const Crs& other) const {
    const auto flat = [](const OGRSpatialReference& ogr) {
        OGRSpatialReference copy(ogr);
        copy.StripVertical();
        return copy;
    };
    const char* const options[] = {"IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
                                   "CRITERION=EQUIVALENT", nullptr};
    const auto mine = flat(*m_ogr);
    const auto theirs = flat(*other.m_ogr);
    return mine.IsSame(&theirs, options) != 0;
}

Transform::Transform(const Crs& from, const Crs& to) : m_between(from.name() + " to " + to.name()) {
    const GdalErrorScope errors;
    m_ogr.reset(OGRCreateCoordinateTransformation(&from.ogr(), &to.ogr()));
    if (!m_ogr)
        throw util::Error("transform coordinates from {}: PROJ has no transformation between them",
                          m_between);
}

Transform::~Transform() = default;
Transform::Transform(Transform&&) noexcept = default;
Transform& Transform::operator=(Transform&&) noexcept = default;

void Transform::apply(std::span<double> x, std::span<double> y) const {
    if (x.size() != y.size())
        throw util::Error("transform coordinates: {} x but {} y", x.size(), y.size());
    if (x.empty())
        return;
    const GdalErrorScope errors;
    const double first_x = x[0];
    const double first_y = y[0];
    const int ok =
        m_ogr->Transform(static_cast<int>(x.size()), x.data(), y.data(), nullptr, nullptr);
    if (ok == 0 || !std::isfinite(x[0]) || !std::isfinite(y[0]))
        throw util::Error(
            "transform coordinates from {}: a point near ({:f}, {:f}) lies outside the domain",
            m_between, first_x, first_y);
}

std::array<double, 4> Transform::around(const std::array<double, 4>& rect) const {
    // Along the edges too: a straight line of one system is an arc in another.
    constexpr int kPieces = 20;
    const auto [west, south, east, north] = rect;
    std::vector<double> x;
    std::vector<double> y;
    const auto add = [&](double at_x, double at_y) {
        x.push_back(at_x);
        y.push_back(at_y);
    };
    for (int i = 0; i <= kPieces; ++i) {
        const double part = static_cast<double>(i) / kPieces;
        const double along_x = i == kPieces ? east : west + part * (east - west);
        const double along_y = i == kPieces ? north : south + part * (north - south);
        add(along_x, south);
        add(along_x, north);
        add(west, along_y);
        add(east, along_y);
    }
    apply(x, y);
    const auto [x0, x1] = std::minmax_element(x.begin(), x.end());
    const auto [y0, y1] = std::minmax_element(y.begin(), y.end());
    return {*x0, *y0, *x1, *y1};
}

LatLon to_lat_lon(const Crs& crs, double easting, double northing) {
    const Transform transform(crs, Crs::from_text("EPSG:4326"));
    double x = easting;
    double y = northing;
    transform.apply({&x, 1}, {&y, 1});
    return {.lat_deg = y, .lon_deg = x};
}

MapPlace map_place(const Crs& crs, double easting, double northing) {
    constexpr double kReach = 10;
    std::array<double, 3> x = {easting, easting, easting};
    std::array<double, 3> y = {northing, northing - kReach, northing + kReach};
    Transform(crs, Crs::from_text("EPSG:4326")).apply(x, y);
    const auto& [here_lon_deg, south_lon_deg, north_lon_deg] = x;
    const auto& [here_lat_deg, south_lat_deg, north_lat_deg] = y;
    // Radii of curvature of the WGS 84 ellipsoid, across the meridian to along it.
    constexpr double kEccentricitySquared = 0.0066943799901413;
    constexpr double kRad = std::numbers::pi / 180;
    const double sine = std::sin(here_lat_deg * kRad);
    const double across_to_along =
        (1 - kEccentricitySquared * sine * sine) / (1 - kEccentricitySquared);
    const double east = std::remainder(north_lon_deg - south_lon_deg, 360) *
                        std::cos(here_lat_deg * kRad) * across_to_along;
    const double convergence_deg = std::atan2(east, north_lat_deg - south_lat_deg) / kRad;
    // The last digits of PROJ depend on its version and the processor, and with them the last bits
    // of sunlight would: of the convergence 1e-11 degrees, as it is a difference.
    const auto rounded = [](double deg, double parts) {
        return std::round(deg * parts) / parts + 0.0;  // never -0
    };
    constexpr double kPlaceParts = 1e8;  // a millimetre
    constexpr double kDirectionParts = 1e6;
    return {{rounded(here_lat_deg, kPlaceParts), rounded(here_lon_deg, kPlaceParts)},
            rounded(convergence_deg, kDirectionParts)};
}

}  // namespace terravox::geo
