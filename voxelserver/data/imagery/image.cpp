#include "voxelserver/data/imagery/image.hpp"

#include <gdal_priv.h>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <utility>

#include "common/geo/gdal_files.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/grid/frame.hpp"

namespace terravox::imagery {

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

/// GDAL reads this side file of a few formats alone.
std::optional<geo::Crs> crs_beside(const fs::path& image) {
    try {
        return geo::Crs::from_side_file(image);
    } catch (const geo::ProjUnusableError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_warn("orthophoto {}: its .prj file does not count: {}", image.string(), e.what());
        return std::nullopt;
    }
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
        if (m_data->GetGCPCount() > 0)
            fail("placed by control points alone; make it straight with gdalwarp");
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
    else if (m_data->GetSpatialRef() == nullptr)
        m_crs = crs_beside(m_path);
    if (m_crs)
        if (const std::string fault = grid::fault_of_degrees(*m_crs, m_geo, m_width, m_height);
            !fault.empty())
            fail(fault);
}

void Image::learn_values() {
    m_roles = find_roles(*m_data, m_path.filename().string());
    m_bands = {m_roles.red, m_roles.green, m_roles.colour() ? m_roles.blue : m_roles.green};
    if (m_roles.nir != 0)
        m_bands.push_back(m_roles.nir);
    if (const GDALColorTable* table = m_data->GetRasterBand(1)->GetColorTable())
        learn_palette(*table);
    if (const int last = *std::max_element(m_bands.begin(), m_bands.end());
        last > m_data->GetRasterCount())
        fail("its colours would be in band " + std::to_string(last) + " of " +
             std::to_string(m_data->GetRasterCount()) + "; allowed: 1, 3 or more");
    for (const int b : m_bands) {
        const GDALColorInterp meaning = m_data->GetRasterBand(b)->GetColorInterpretation();
        if (meaning >= GCI_HueBand && meaning <= GCI_YCbCr_CrBand)
            fail("its bands are " + std::string(GDALGetColorInterpretationName(meaning)) +
                 " and others; allowed: red, green, blue, near infrared or grey; convert it");
    }
    learn_depth();
    learn_mask();
}

void Image::learn_palette(const GDALColorTable& table) {
    m_bands = {1};
    const auto byte = [](short v) { return static_cast<std::uint8_t>(std::clamp<int>(v, 0, 255)); };
    for (int i = 0; i < table.GetColorEntryCount(); ++i) {
        GDALColorEntry entry{};
        const bool known = table.GetColorEntryAsRGB(i, &entry) != 0;
        m_palette.push_back({byte(entry.c1), byte(entry.c2), byte(entry.c3), 0});
        m_palette_valid.push_back(known && table.GetColorEntry(i)->c4 != 0 ? 1 : 0);
    }
}

void Image::learn_depth() {
    constexpr int kByte = 8;
    int bits = 0;  // as the file states, of whole numbers
    bool bytes = true;
    for (const int b : m_bands) {
        GDALRasterBand& band = *m_data->GetRasterBand(b);
        const GDALDataType type = band.GetRasterDataType();
        if (GDALDataTypeIsComplex(type) != 0)
            fail("its values are complex; allowed: whole or floating-point numbers");
        bytes = bytes && type == GDT_Byte;
        m_whole_numbers = m_whole_numbers && GDALDataTypeIsInteger(type) != 0;
        if (const char* stated = band.GetMetadataItem("NBITS", "IMAGE_STRUCTURE"))
            bits = std::max(bits, std::clamp(std::atoi(stated), 1, 32));
        Meaning meaning;
        int known = 0;
        if (const double scale = band.GetScale(&known); known != 0)
            meaning.scale.factor = scale;
        if (const double offset = band.GetOffset(&known); known != 0)
            meaning.scale.offset = offset;
        if (!std::isfinite(meaning.scale.factor) || !std::isfinite(meaning.scale.offset) ||
            meaning.scale.factor == 0)
            fail("scale and offset of its values = " + std::to_string(meaning.scale.factor) + ", " +
                 std::to_string(meaning.scale.offset) + "; allowed: numbers, the scale not 0");
        m_scaled = m_scaled || meaning.scale != Scale{};
        m_meanings.push_back(meaning);
    }
    if (bytes || m_roles.palette)
        forget_scales();
    if (bytes && bits == 0)
        bits = kByte;
    const char* white = m_data->GetMetadataItem("MINISWHITE", "IMAGE_STRUCTURE");
    m_inverted = white != nullptr && EQUAL(white, "YES") && !m_roles.palette;
    m_wide = !bytes || bits != kByte || m_inverted || m_roles.palette;
    m_bits = bits;
    use_bits();
}

void Image::use_bits() {
    m_states_brightness = m_roles.palette || (has_whole_numbers() && m_bits != 0);
    if (m_wide && m_states_brightness && !m_roles.palette) {
        set_brightness(Brightness::of_bits(m_bits));
        m_opaque = std::ldexp(1.0F, m_bits - 1);
    }
}

void Image::learn_mask() {
    GDALRasterBand& first = *m_data->GetRasterBand(m_bands[0]);
    const int flags = first.GetMaskFlags();
    int has_nodata = 0;
    const double nodata = first.GetNoDataValue(&has_nodata);
    // GDAL knows alpha bands of bytes and 16 bits, as the last of two or four, and takes the latter
    // for values that use all of their bits.
    const int last = m_data->GetRasterCount();
    if (last > 1 && last != m_roles.nir && !m_roles.palette &&
        m_data->GetRasterBand(last)->GetColorInterpretation() == GCI_AlphaBand &&
        (m_wide || (flags & GMF_ALPHA) == 0)) {
        m_wide = true;
        m_alpha = last;
    }
    const bool alpha_is_nir =
        (flags & GMF_ALPHA) != 0 && m_roles.nir != 0 &&
        m_data->GetRasterBand(m_roles.nir)->GetColorInterpretation() == GCI_AlphaBand;
    if ((flags & GMF_ALL_VALID) != 0 || alpha_is_nir || m_alpha != 0) {
        m_mask = Mask::kNone;
    } else if ((flags & GMF_NODATA) != 0 && has_nodata != 0) {
        // Wide pixels without a finite number have no data in any case.
        const bool possible =
            m_wide || (nodata >= 0 && nodata <= 255 && nodata == std::floor(nodata));
        m_mask = possible && !std::isnan(nodata) ? Mask::kValue : Mask::kNone;
        // Values beyond those of a float become infinite.
        constexpr double kMost = std::numeric_limits<float>::max();
        m_nodata = static_cast<float>(std::clamp(nodata, -kMost, kMost));
    } else {
        m_mask = Mask::kBand;
    }
}

void Image::set_brightness(const Brightness& brightness) {
    for (Meaning& m : m_meanings) {
        m.brightness = (m_inverted ? brightness.inverted() : brightness)
                           .of_scaled(m.scale.factor, m.scale.offset);
    }
}

double Image::stored(double value) const noexcept {
    const Meaning& first = m_meanings.front();
    return (value - first.scale.offset) / first.scale.factor;
}

std::vector<Image::Scale> Image::scales() const {
    std::vector<Scale> out;
    for (const Meaning& m : m_meanings)
        if (m_scaled)
            out.push_back(m.scale);
    return out;
}

void Image::forget_scales() noexcept {
    m_scaled = false;
    for (Meaning& m : m_meanings)
        m.scale = {};
    use_bits();
}

void Image::copy_brightness(const Image& same) {
    m_meanings = same.m_meanings;
    m_opaque = same.m_opaque;
}

void Image::add_brightness(voxel::ByteWriter& out) const {
    if (!m_wide)
        return;
    for (const Meaning& m : m_meanings) {
        out.add(m.brightness.factor);
        out.add(m.brightness.add);
    }
    out.add(m_opaque);
}

struct Image::Sample {
    std::vector<float> stored;
    std::vector<float> scaled;
    float most_opaque = 0;
};

Image::Seen Image::look_at_values(int across) {
    constexpr int kMost = 16;
    constexpr int kSide = 64;
    open();
    Sample sample;
    const auto place = [](int i, int n, int size) {
        const auto middle = static_cast<int>((2 * std::int64_t{i} + 1) * size / (2 * n));
        return std::clamp(middle - kSide / 2, 0, std::max(size - kSide, 0));
    };
    for (int n = across; n <= kMost && sample.stored.empty(); n *= 2)
        for (int i = 0; i < n * n; ++i) {
            const PixelWindow window{place(i % n, n, m_width), place(i / n, n, m_height),
                                     std::min(kSide, m_width), std::min(kSide, m_height)};
            try {
                look_at_window(window, sample);
            } catch (const util::Error&) {
                continue;
            }
        }
    const GDALDataType type = m_data->GetRasterBand(m_bands[0])->GetRasterDataType();
    double greatest = 0;
    if (m_whole_numbers)
        greatest = std::ldexp(1.0, GDALGetDataTypeSizeBits(type) - GDALDataTypeIsSigned(type)) - 1;
    Seen out;
    out.stored = find_range(std::move(sample.stored), greatest);
    out.scaled = find_range(std::move(sample.scaled), 0);
    add_statistics(out);
    if (sample.most_opaque > 0)
        m_opaque = static_cast<float>(
            assume_brightness({0, sample.most_opaque}, GDALDataTypeIsInteger(type) != 0).white / 2);
    return out;
}

void Image::look_at_window(const PixelWindow& window, Sample& sample) {
    const geo::GdalErrorScope errors;
    const std::vector<float> read = read_values(window);
    Pixels mask;
    mask.values.resize(static_cast<std::size_t>(window.width) *
                       static_cast<std::size_t>(window.height));
    if (m_mask == Mask::kBand)
        apply_mask(window, mask);
    const std::size_t stride = read.size() / mask.values.size();
    for (std::size_t i = 0; i < mask.values.size(); ++i) {
        const std::span<const float> pixel(&read[i * stride], stride);
        if (m_alpha != 0)
            sample.most_opaque = std::max(sample.most_opaque, pixel.back());
        if ((!mask.valid.empty() && mask.valid[i] == 0) || !has_data(pixel) ||
            (m_alpha != 0 && !(pixel.back() > 0)))
            continue;
        for (std::size_t b = 0; b < m_bands.size(); ++b) {
            if (pixel[b] == 0)
                continue;
            const Scale& scale = m_meanings[b].scale;
            sample.stored.push_back(pixel[b]);
            if (m_scaled)
                sample.scaled.push_back(static_cast<float>(pixel[b] * scale.factor + scale.offset));
        }
    }
}

void Image::add_statistics(Seen& seen) const {
    // More above the mean than nearly all values are, but for single ones that are wrong.
    constexpr double kDeviations = 4;
    for (std::size_t b = 0; b < m_bands.size(); ++b) {
        GDALRasterBand& band = *m_data->GetRasterBand(m_bands[b]);
        const char* const most = band.GetMetadataItem("STATISTICS_MAXIMUM");
        const char* const mean = band.GetMetadataItem("STATISTICS_MEAN");
        const char* const deviation = band.GetMetadataItem("STATISTICS_STDDEV");
        if (most == nullptr || mean == nullptr || deviation == nullptr)
            continue;
        const double high =
            std::min(CPLAtof(most), CPLAtof(mean) + kDeviations * CPLAtof(deviation));
        if (!std::isfinite(high))
            continue;
        const Scale& scale = m_meanings[b].scale;
        seen.stored.add({0, high});
        seen.scaled.add({0, high * scale.factor + scale.offset});
    }
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
    if (!m_has_light)
        look_for_light(out);
}

void Image::look_for_light(const Pixels& pixels) noexcept {
    constexpr std::uint8_t kBlack = 2;  // at most
    for (std::size_t i = 0; i < pixels.values.size() && !m_has_light; ++i) {
        if (!pixels.valid.empty() && pixels.valid[i] == 0)
            continue;
        const Pixel& p = pixels.values[i];
        m_has_light = std::max({p.r, p.g, p.b}) > kBlack;
        m_is_black = !m_has_light;
    }
}

void Image::add_read(const Image& other) noexcept {
    m_has_light = m_has_light || other.m_has_light;
    m_is_black = (m_is_black || other.m_is_black) && !m_has_light;
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
}

// Interleaved by pixel: of m_bands, and of alpha.
std::vector<float> Image::read_values(const PixelWindow& window) {
    std::vector<int> bands = m_bands;
    if (m_alpha != 0)
        bands.push_back(m_alpha);
    std::vector<float> out(static_cast<std::size_t>(window.width) *
                           static_cast<std::size_t>(window.height) * bands.size());
    const auto pixel_bytes = static_cast<GSpacing>(bands.size() * sizeof(float));
    const CPLErr failed = m_data->RasterIO(
        GF_Read, window.x, window.y, window.width, window.height, out.data(), window.width,
        window.height, GDT_Float32, static_cast<int>(bands.size()), bands.data(), pixel_bytes,
        pixel_bytes * window.width, sizeof(float), nullptr);
    if (failed != CE_None)
        fail("damaged: " + geo::GdalErrorScope::reason());
    return out;
}

bool Image::has_data(std::span<const float> values) const noexcept {
    const auto colours = values.first(std::min<std::size_t>(m_bands.size(), 3));
    if (!std::all_of(colours.begin(), colours.end(), [](float v) { return std::isfinite(v); }))
        return false;
    // The nodata value of many files that do not declare one, which is no brightness.
    constexpr float kUndeclared = -9999;
    if (std::all_of(colours.begin(), colours.end(), [](float v) { return v == kUndeclared; }))
        return false;
    return m_mask != Mask::kValue ||
           std::any_of(colours.begin(), colours.end(), [&](float v) { return v != m_nodata; });
}

void Image::read_wide(const PixelWindow& window, Pixels& out) {
    const std::vector<float> values = read_values(window);
    const std::size_t bands = m_bands.size();
    const std::size_t stride = bands + (m_alpha != 0 ? 1 : 0);
    out.valid.resize(out.values.size());
    for (std::size_t i = 0; i < out.values.size(); ++i) {
        const std::span<const float> v(&values[i * stride], stride);
        out.valid[i] = has_data(v) && (m_alpha == 0 || v.back() >= m_opaque) ? 1 : 0;
        const auto shown = [&](std::size_t band) {
            return m_meanings[band].brightness.of(static_cast<double>(v[band]));
        };
        if (m_roles.palette) {
            const auto index = static_cast<std::size_t>(std::max(v[0], 0.0F));
            const bool known = index < m_palette.size() && m_palette_valid[index] != 0;
            out.values[i] = known ? m_palette[index] : Pixel{};
            out.valid[i] = known ? out.valid[i] : 0;
            continue;
        }
        out.values[i].r = shown(0);
        if (bands >= 3) {
            out.values[i].g = shown(1);
            out.values[i].b = shown(2);
        }
        if (bands >= 4)
            out.values[i].nir = shown(3);
    }
    if (std::find(out.valid.begin(), out.valid.end(), 0) == out.valid.end())
        out.valid.clear();
}

void Image::apply_mask(const PixelWindow& window, Pixels& out) {
    std::vector<std::uint8_t> masked(out.values.size());
    GDALRasterBand* mask = m_data->GetRasterBand(m_bands[0])->GetMaskBand();
    const CPLErr failed =
        mask->RasterIO(GF_Read, window.x, window.y, window.width, window.height, masked.data(),
                       window.width, window.height, GDT_Byte, 0, 0, nullptr);
    if (failed != CE_None)
        fail("damaged: " + geo::GdalErrorScope::reason());
    constexpr std::uint8_t kHalf = 128;  // of an alpha band: mostly transparent counts as no data
    out.valid.resize(out.values.size(), 1);
    for (std::size_t i = 0; i < masked.size(); ++i)
        out.valid[i] = masked[i] >= kHalf ? out.valid[i] : 0;
}

}  // namespace terravox::imagery
