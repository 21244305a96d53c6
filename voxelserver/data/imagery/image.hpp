#pragma once

#include <gdal_priv.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/data/grid/square_names.hpp"

class GDALDataset;

namespace terravox::imagery {

/// Assignment of an image's bands: GDAL's band numbers from 1, 0 = not present.
struct BandRoles {
    int red = 0;
    int green = 0;
    int blue = 0;
    int nir = 0;
    bool palette = false;  ///< the first band holds indices into a colour table
    [[nodiscard]] bool colour() const noexcept { return blue != 0; }
};

/// Determines what the bands hold, by these rules, in this order:
/// 1. per band, the metadata of the file: a colour interpretation (near infrared where GDAL
///    supports it: 3.10), or a description such as "nir", "near infrared", "pir";
/// 2. a file name with the word "irc" or "cir" (no letter before or after it:
///    "ortho_irc_2021.tif"), three bands or more: near infrared, red, green;
/// 3. a file name with the word "rgbi", "rgbn" or "rgbnir": the fourth band is near infrared, even
///    if tagged as alpha;
/// 4. four bands or more, the fourth neither alpha nor described: near infrared;
/// 5. else red, green, blue in the order of the bands; fewer than three bands are grey.
///
/// An image that has only near infrared, red and green gives no colour: its blue is unknown, and a
/// made-up value would end up in the picture.
[[nodiscard]] BandRoles find_roles(GDALDataset& image, const std::string& file_name);

/// The mutex that must be held for every use of GDAL data sets and PROJ transformations, which are
/// not thread-safe.
[[nodiscard]] std::mutex& gdal_mutex();

/// A rectangle of an image's own pixels.
struct PixelWindow {
    int x = 0;
    int y = 0;
    int width = 0;
    int height = 0;
};

/// One pixel as 8-bit values; 0 for missing bands.
struct Pixel {
    std::uint8_t r = 0;
    std::uint8_t g = 0;
    std::uint8_t b = 0;
    std::uint8_t nir = 0;
};

struct Pixels {
    PixelWindow window;
    std::vector<Pixel> values;        ///< row by row
    std::vector<std::uint8_t> valid;  ///< empty: all pixels are valid; else 0 = no data
};

/// One image file. No resampling is done here: pixels are returned as stored in the file (or in the
/// selected overview), so that values do not depend on the window. Every member function requires
/// the caller to hold gdal_mutex().
class Image {
public:
    /// Opens the file and reads its metadata.
    /// @param square where an image that is not georeferenced lies: its outline is that of the
    /// square. nullptr = unknown.
    /// @throws Error naming the file when it is missing, not an image, or not georeferenced
    explicit Image(const std::filesystem::path& path, const grid::NamedSquare* square = nullptr);

    /// Selects the overview to be read from now on, if there is one: its pixels must still be well
    /// below `pixels_per_voxel` times smaller than a voxel.
    void choose_overview(double pixels_per_voxel);

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    [[nodiscard]] const std::optional<geo::Crs>& crs() const noexcept { return m_crs; }
    /// The geotransform: pixel coordinates to coordinates of crs(), in GDAL's order.
    [[nodiscard]] const std::array<double, 6>& geo() const noexcept { return m_geo; }
    [[nodiscard]] int width() const noexcept { return m_width; }
    [[nodiscard]] int height() const noexcept { return m_height; }
    [[nodiscard]] const BandRoles& roles() const noexcept { return m_roles; }
    /// Whether the file states no place, so that it lies on the square given.
    [[nodiscard]] bool placed_by_name() const noexcept { return m_placed_by_name; }
    /// "2021:06:14 10:30:00"; empty when the file does not contain a date.
    [[nodiscard]] const std::string& date() const noexcept { return m_date; }

    /// @param window inside the image, not empty
    /// @throws Error naming the file when it is damaged
    void read(const PixelWindow& window, Pixels& out);

    [[nodiscard]] bool is_open() const noexcept { return m_data != nullptr; }
    void close() noexcept { m_data.reset(); }  ///< the next read reopens it

private:
    enum class Mask : std::uint8_t { kNone, kValue, kBand };
    [[noreturn]] void fail(const std::string& what) const;
    void open();
    void learn_georeference();
    void learn_values();
    void read_bands(const PixelWindow& window, Pixels& out);
    void read_wide(const PixelWindow& window, Pixels& out);
    void expand_palette(Pixels& out) const;
    void apply_mask(const PixelWindow& window, Pixels& out);

    std::filesystem::path m_path;
    std::optional<grid::NamedSquare> m_square;
    bool m_placed_by_name = false;
    GDALDatasetUniquePtr m_data;
    int m_overview = -1;
    int m_width = 0;
    int m_height = 0;
    std::array<double, 6> m_geo{};
    std::optional<geo::Crs> m_crs;
    std::string m_date;
    BandRoles m_roles;
    std::vector<int> m_bands;  ///< in the order of Pixel's members
    std::vector<Pixel> m_palette;
    std::vector<std::uint8_t> m_palette_valid;
    bool m_wide = false;  ///< whether values have 16 bits
    int m_shift = 8;      ///< right shift that converts wide values to 8 bits
    Mask m_mask = Mask::kNone;
    std::uint16_t m_nodata = 0;
};

}  // namespace terravox::imagery
