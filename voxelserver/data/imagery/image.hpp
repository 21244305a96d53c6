#pragma once

#include <gdal_priv.h>
#include <array>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "voxelserver/data/grid/square_names.hpp"
#include "voxelserver/data/imagery/band_roles.hpp"
#include "voxelserver/data/imagery/brightness.hpp"

class GDALColorTable;
class GDALDataset;

namespace terravox::voxel {
class ByteWriter;
}

namespace terravox::imagery {

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

    /// Whether nothing need be assumed of what its values mean: they are bytes, or the file states
    /// their depth.
    [[nodiscard]] bool states_brightness() const noexcept { return m_states_brightness; }
    /// Whether values are integers without a scale.
    [[nodiscard]] bool has_whole_numbers() const noexcept { return m_whole_numbers && !m_scaled; }
    /// What the file's metadata make of the values of a band.
    struct Scale {
        double factor = 1;
        double offset = 0;
        auto operator<=>(const Scale&) const = default;
    };
    /// Of the bands that are read; empty where the file states none, or it does not count.
    [[nodiscard]] std::vector<Scale> scales() const;
    /// Takes values as they are stored from now on. To be called before set_brightness().
    void forget_scales() noexcept;
    /// What look_at_values() finds.
    struct Seen {
        ValueRange stored;
        ValueRange scaled;  ///< by scales()
    };
    /// Looks at the values of some windows that lie evenly over the image, at more where these hold
    /// no data, and at statistics that the file states. Does not depend on what was read before.
    /// Damage is passed over: reading it will fail. To be called before choose_overview().
    /// @param across windows along each edge, [1, 16]
    [[nodiscard]] Seen look_at_values(int across);
    /// To be called before read() unless states_brightness().
    void set_brightness(const Brightness& brightness);
    /// What a value is as the file stores it, before scale and offset of its first band.
    [[nodiscard]] double stored(double value) const noexcept;
    /// Instead of look_at_values() and set_brightness(): what the same file has found.
    void copy_brightness(const Image& same);

    /// Adds to what brightness values become, for a fingerprint.
    void add_brightness(voxel::ByteWriter& out) const;

    /// Whether pixels with data have been read, and all of them were black.
    [[nodiscard]] bool is_black() const noexcept { return m_is_black; }

    /// As if everything that another reading of the same file has read had been read here.
    void add_read(const Image& other) noexcept;

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
    void learn_depth();
    void use_bits();
    void learn_palette(const GDALColorTable& table);
    void learn_mask();
    struct Sample;
    void look_at_window(const PixelWindow& window, Sample& sample);
    void add_statistics(Seen& seen) const;
    void read_bands(const PixelWindow& window, Pixels& out);
    [[nodiscard]] std::vector<float> read_values(const PixelWindow& window);
    void read_wide(const PixelWindow& window, Pixels& out);
    [[nodiscard]] bool has_data(std::span<const float> values) const noexcept;
    void apply_mask(const PixelWindow& window, Pixels& out);
    void look_for_light(const Pixels& pixels) noexcept;

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
    bool m_wide = false;  ///< whether values are not bytes of brightness
    bool m_states_brightness = true;
    bool m_whole_numbers = true;
    int m_bits = 0;           ///< of its whole numbers, as the file states; 0: it does not
    bool m_scaled = false;    ///< whether a band's scale counts
    bool m_inverted = false;  ///< 0 is white
    /// Of wide values, for each of m_bands: to what the file's metadata make of them, and to
    /// brightness.
    struct Meaning {
        Scale scale;
        Brightness brightness;
    };
    std::vector<Meaning> m_meanings;
    int m_alpha = 0;       ///< a band that GDAL makes no mask of; 0: none
    float m_opaque = 128;  ///< of that band, at least: less counts as no data
    Mask m_mask = Mask::kNone;
    float m_nodata = 0;
    bool m_has_light = false;  ///< a pixel that was read is not black
    bool m_is_black = false;
};

}  // namespace terravox::imagery
