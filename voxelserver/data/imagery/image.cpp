#include "voxelserver/data/imagery/image.hpp"

#include <gdal_priv.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <string_view>

#include "common/geo/gdal_files.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"

namespace terravox::imagery {
namespace {

bool letter(char c) noexcept {
    return c >= 'a' && c <= 'z';
}

/// "irc" is a word of "ortho_irc1.tif", not of "circle.tif".
bool has_word(const std::string& text, std::initializer_list<std::string_view> words) {
    for (const std::string_view word : words)
        for (std::size_t at = text.find(word); at != std::string::npos;
             at = text.find(word, at + 1))
            if ((at == 0 || !letter(text[at - 1])) &&
                (at + word.size() == text.size() || !letter(text[at + word.size()])))
                return true;
    return false;
}

bool says_near_infrared(GDALRasterBand& band) {
#if GDAL_VERSION_NUM >= GDAL_COMPUTE_VERSION(3, 10, 0)
    if (band.GetColorInterpretation() == GCI_NIRBand)
        return true;
#endif
    return has_word(util::lower_case(band.GetDescription()),
                    {"nir", "near infrared", "near-infrared", "near_infrared", "nearinfrared",
                     "infrared", "pir", "ir"});
}

bool says_anything_else(GDALRasterBand& band) {
    const GDALColorInterp meaning = band.GetColorInterpretation();
    return (meaning != GCI_Undefined && meaning != GCI_GrayIndex) ||
           std::string_view(band.GetDescription()) != "";
}

}  // namespace

BandRoles find_roles(GDALDataset& image, const std::string& file_name) {
    BandRoles roles;
    const int bands = image.GetRasterCount();
    const std::string name = util::lower_case(file_name);
    if (image.GetRasterBand(1)->GetColorTable() != nullptr)
        return {1, 1, 1, 0, true};
    bool infrared_described = false;
    for (int b = 1; b <= bands; ++b) {
        GDALRasterBand& band = *image.GetRasterBand(b);
        const GDALColorInterp meaning = band.GetColorInterpretation();
        const std::string says = util::lower_case(band.GetDescription());
        if (says_near_infrared(band)) {
            roles.nir = roles.nir == 0 ? b : roles.nir;
            infrared_described = true;
        } else if (meaning == GCI_RedBand || says == "red")
            roles.red = roles.red == 0 ? b : roles.red;
        else if (meaning == GCI_GreenBand || says == "green")
            roles.green = roles.green == 0 ? b : roles.green;
        else if (meaning == GCI_BlueBand || says == "blue")
            roles.blue = roles.blue == 0 ? b : roles.blue;
    }
    // Described as near infrared, but tagged as if red, green, blue.
    if (infrared_described && roles.nir == 1 && roles.blue != 0 && bands < 4)
        roles = {2, 3, 0, 1, false};
    if (infrared_described && roles.red != 0)
        return roles;
    if (bands >= 3 && has_word(name, {"irc", "cir"}))
        return {2, 3, 0, 1, false};
    if (bands < 3)
        return {1, 1, 1, 0, false};
    if (roles.red == 0 || roles.green == 0 || roles.blue == 0)
        roles = {1, 2, 3, roles.nir > 3 ? roles.nir : 0, false};
    if (roles.nir == 0 && bands >= 4 &&
        (has_word(name, {"rgbi", "rgbn", "rgbnir"}) ||
         !says_anything_else(*image.GetRasterBand(4))))
        roles.nir = 4;
    return roles;
}

namespace fs = std::filesystem;

namespace {

/// "YYYY:MM:DD hh:mm:ss" as in TIFF and EXIF; anything else is not a date.
std::string find_date(GDALDataset& data) {
    for (const char* key : {"TIFFTAG_DATETIME", "EXIF_DateTimeOriginal", "EXIF_DateTime"}) {
        const char* text = data.GetMetadataItem(key);
        if (text == nullptr)
            continue;
        std::string date(text);
        const std::string form = "0000:00:00 00:00:00";
        if (date.size() != form.size())
            continue;
        bool good = true;
        for (std::size_t i = 0; i < form.size(); ++i)
            good = good && (form[i] == '0' ? date[i] >= '0' && date[i] <= '9' : date[i] == form[i]);
        if (good)
            return date;
    }
    return {};
}

}  // namespace

std::mutex& gdal_mutex() {
    static std::mutex mutex;
    return mutex;
}

void Image::fail(const std::string& what) const {
    throw util::Error("read the orthophoto {}: {}", m_path.string(), what);
}

Image::Image(const fs::path& path, const grid::NamedSquare* square) : m_path(path) {
    if (square != nullptr)
        m_square = *square;
    const geo::GdalErrorScope errors;
    open();
    learn_georeference();
    learn_values();
    m_date = find_date(*m_data);
}

void Image::open() {
    if (m_data)
        return;
    const geo::GdalErrorScope errors;
    m_data = geo::open_raster(m_path, "read the orthophoto", m_overview);
    if (m_data->GetRasterXSize() < 1 || m_data->GetRasterYSize() < 1)
        fail("an image without pixels");
    // A file may declare a block of any size; GDAL would allocate the memory before it reads the
    // data.
    constexpr double kMaxBlock_bytes = 512e6;
    int block_x = 0;
    int block_y = 0;
    GDALRasterBand* band = m_data->GetRasterBand(1);
    band->GetBlockSize(&block_x, &block_y);
    const double bytes = static_cast<double>(block_x) * block_y * m_data->GetRasterCount() *
                         GDALGetDataTypeSizeBytes(band->GetRasterDataType());
    if (bytes > kMaxBlock_bytes)
        fail("its blocks are " + std::to_string(block_x) + " x " + std::to_string(block_y) +
             " pixels; allowed: up to 512 MB");
    m_width = m_data->GetRasterXSize();
    m_height = m_data->GetRasterYSize();
}

void Image::learn_georeference() {
    const geo::GdalErrorScope errors;
    if (m_data->GetGeoTransform(m_geo.data()) != CE_None) {
        if (!m_square)
            fail(
                "not georeferenced (neither GeoTIFF tags nor a world file, nor the name of a "
                "square of the world)");
        m_placed_by_name = true;
        m_geo = {m_square->west,
                 (m_square->east - m_square->west) / m_width,
                 0,
                 m_square->north,
                 0,
                 (m_square->south - m_square->north) / m_height};
        m_crs = geo::Crs::from_text(m_square->crs);
        return;
    }
    const double area = m_geo[1] * m_geo[5] - m_geo[2] * m_geo[4];
    const bool finite =
        std::all_of(m_geo.begin(), m_geo.end(), [](double v) { return std::isfinite(v); });
    if (!finite || !(std::abs(area) > 0))
        fail("the size of its pixels is not above 0 (area " + std::to_string(area) +
             "; allowed: above 0)");
    if (const OGRSpatialReference* own = geo::Crs::placing(m_data->GetSpatialRef()))
        m_crs = geo::Crs::from_ogr(*own, m_path.string());
}

void Image::learn_values() {
    m_roles = find_roles(*m_data, m_path.filename().string());
    GDALRasterBand* first = m_data->GetRasterBand(1);
    const GDALDataType type = first->GetRasterDataType();
    m_wide = type != GDT_Byte;
    // Values of 12 bits in 16 are not shifted by 8; types other than unsigned 16-bit numbers are
    // assumed to be in [0, 255].
    m_shift = type == GDT_UInt16 ? 8 : 0;
    if (const char* bits = first->GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
        bits != nullptr && type == GDT_UInt16)
        m_shift = std::clamp(std::atoi(bits) - 8, 0, 8);
    m_bands = {m_roles.red, m_roles.green, m_roles.colour() ? m_roles.blue : m_roles.green};
    if (m_roles.nir != 0)
        m_bands.push_back(m_roles.nir);
    if (const GDALColorTable* table = first->GetColorTable()) {
        m_bands = {1};
        const auto byte = [](short v) {
            return static_cast<std::uint8_t>(std::clamp<int>(v, 0, 255));
        };
        for (int i = 0; i < table->GetColorEntryCount(); ++i) {
            GDALColorEntry entry{};
            const bool known = table->GetColorEntryAsRGB(i, &entry) != 0;
            m_palette.push_back({byte(entry.c1), byte(entry.c2), byte(entry.c3), 0});
            m_palette_valid.push_back(known && table->GetColorEntry(i)->c4 != 0 ? 1 : 0);
        }
    }
    const int flags = m_data->GetRasterBand(m_bands[0])->GetMaskFlags();
    int has_nodata = 0;
    const double nodata = m_data->GetRasterBand(m_bands[0])->GetNoDataValue(&has_nodata);
    const bool alpha_is_nir =
        (flags & GMF_ALPHA) != 0 && m_roles.nir != 0 &&
        m_data->GetRasterBand(m_roles.nir)->GetColorInterpretation() == GCI_AlphaBand;
    if ((flags & GMF_ALL_VALID) != 0 || alpha_is_nir)
        m_mask = Mask::kNone;
    else if ((flags & GMF_NODATA) != 0 && has_nodata != 0 &&
             (type == GDT_Byte || type == GDT_UInt16)) {
        const double max_value = type == GDT_Byte ? 255 : 65535;
        const bool possible = nodata >= 0 && nodata <= max_value && nodata == std::floor(nodata);
        m_mask = possible ? Mask::kValue : Mask::kNone;
        if (possible)
            m_nodata = static_cast<std::uint16_t>(nodata);
    } else
        m_mask = Mask::kBand;
}

void Image::choose_overview(double pixels_per_voxel) {
    // Pixels per voxel edge: more than sufficient; the minimum that must remain.
    constexpr double kEnough = 8;
    constexpr double kMin = 4;
    if (!(pixels_per_voxel > kEnough) || m_overview >= 0)
        return;
    open();
    GDALRasterBand* band = m_data->GetRasterBand(1);
    int best = -1;
    double coarsest = 1;
    for (int i = 0; i < band->GetOverviewCount(); ++i) {
        GDALRasterBand* overview = band->GetOverview(i);
        if (overview == nullptr || overview->GetXSize() < 1)
            continue;
        const double factor = static_cast<double>(m_width) / overview->GetXSize();
        if (factor > coarsest && pixels_per_voxel / factor >= kMin) {
            coarsest = factor;
            best = i;
        }
    }
    if (best < 0)
        return;
    m_overview = best;
    close();
    open();
    learn_georeference();
}

void Image::read(const PixelWindow& window, Pixels& out) {
    open();
    const geo::GdalErrorScope errors;
    out.window = window;
    out.values.assign(
        static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height), Pixel{});
    out.valid.clear();
    if (m_wide)
        read_wide(window, out);
    else
        read_bands(window, out);
    if (m_mask == Mask::kBand)
        apply_mask(window, out);
}

void Image::read_bands(const PixelWindow& window, Pixels& out) {
    // One call for all bands: pixel-interleaved files are then decoded once.
    const CPLErr failed = m_data->RasterIO(
        GF_Read, window.x, window.y, window.width, window.height, out.values.data(), window.width,
        window.height, GDT_Byte, static_cast<int>(m_bands.size()), m_bands.data(), sizeof(Pixel),
        static_cast<GSpacing>(sizeof(Pixel)) * window.width, 1, nullptr);
    if (failed != CE_None)
        fail("damaged: " + geo::GdalErrorScope::reason());
    if (m_mask == Mask::kValue) {
        out.valid.resize(out.values.size());
        const auto none = static_cast<std::uint8_t>(m_nodata);
        const bool single = m_bands.size() == 1;
        for (std::size_t i = 0; i < out.values.size(); ++i) {
            const Pixel p = out.values[i];
            out.valid[i] = p.r != none || (!single && (p.g != none || p.b != none)) ? 1 : 0;
        }
    }
    if (m_roles.palette)
        expand_palette(out);
}

void Image::read_wide(const PixelWindow& window, Pixels& out) {
    const std::size_t bands = m_bands.size();
    std::vector<std::uint16_t> wide(out.values.size() * bands);
    const auto pixel_bytes = static_cast<GSpacing>(bands * sizeof(std::uint16_t));
    const CPLErr failed = m_data->RasterIO(
        GF_Read, window.x, window.y, window.width, window.height, wide.data(), window.width,
        window.height, GDT_UInt16, static_cast<int>(bands), m_bands.data(), pixel_bytes,
        pixel_bytes * window.width, sizeof(std::uint16_t), nullptr);
    if (failed != CE_None)
        fail("damaged: " + geo::GdalErrorScope::reason());
    const auto narrow = [&](std::uint16_t v) {
        return static_cast<std::uint8_t>(std::min(v >> m_shift, 255));
    };
    if (m_mask == Mask::kValue)
        out.valid.resize(out.values.size());
    for (std::size_t i = 0; i < out.values.size(); ++i) {
        const std::uint16_t* v = &wide[i * bands];
        if (m_mask == Mask::kValue)
            out.valid[i] = std::any_of(v, v + std::min<std::size_t>(bands, 3),
                                       [&](std::uint16_t x) { return x != m_nodata; })
                               ? 1
                               : 0;
        // An index of a palette is not a brightness.
        out.values[i].r =
            m_roles.palette ? static_cast<std::uint8_t>(std::min<int>(v[0], 255)) : narrow(v[0]);
        if (bands >= 3) {
            out.values[i].g = narrow(v[1]);
            out.values[i].b = narrow(v[2]);
        }
        if (bands >= 4)
            out.values[i].nir = narrow(v[3]);
    }
    if (m_roles.palette)
        expand_palette(out);
}

void Image::expand_palette(Pixels& out) const {
    const bool gaps =
        std::find(m_palette_valid.begin(), m_palette_valid.end(), 0) != m_palette_valid.end() ||
        m_palette.size() < 256;
    if (gaps && out.valid.empty())
        out.valid.assign(out.values.size(), 1);
    for (std::size_t i = 0; i < out.values.size(); ++i) {
        const std::size_t index = out.values[i].r;
        const bool known = index < m_palette.size();
        out.values[i] = known ? m_palette[index] : Pixel{};
        if (gaps && !(known && m_palette_valid[index] != 0))
            out.valid[i] = 0;
    }
}

void Image::apply_mask(const PixelWindow& window, Pixels& out) {
    out.valid.resize(out.values.size());
    GDALRasterBand* mask = m_data->GetRasterBand(m_bands[0])->GetMaskBand();
    const CPLErr failed =
        mask->RasterIO(GF_Read, window.x, window.y, window.width, window.height, out.valid.data(),
                       window.width, window.height, GDT_Byte, 0, 0, nullptr);
    if (failed != CE_None)
        fail("damaged: " + geo::GdalErrorScope::reason());
    constexpr std::uint8_t kHalf = 128;  // of an alpha band: mostly transparent counts as no data
    for (std::uint8_t& v : out.valid)
        v = v >= kHalf ? 1 : 0;
}

}  // namespace terravox::imagery
