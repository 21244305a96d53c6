#include "common/geo/raster_gate.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <fstream>

#include "common/geo/gdal_messages.hpp"

namespace terravox::geo {
namespace {

/// One number of GDAL's metadata of a block; 0 for a block that was never written.
std::uint64_t to_number(GDALRasterBand& band, const char* what, int column, int row) {
    const std::string name = what + std::to_string(column) + "_" + std::to_string(row);
    const char* text = band.GetMetadataItem(name.c_str(), "TIFF");
    return text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
}

/// The offset after the last block of a directory.
std::uint64_t end_of_blocks(GDALRasterBand& band) {
    int width_px = 0;
    int height_px = 0;
    band.GetBlockSize(&width_px, &height_px);
    if (width_px <= 0 || height_px <= 0)
        return 0;
    const int columns = (band.GetXSize() + width_px - 1) / width_px;
    const int rows = (band.GetYSize() + height_px - 1) / height_px;
    std::uint64_t end = 0;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const std::uint64_t first = to_number(band, "BLOCK_OFFSET_", column, row);
            const std::uint64_t bytes = to_number(band, "BLOCK_SIZE_", column, row);
            end = std::max(end, first + bytes);
        }
    }
    return end;
}

/// The chain of directories of a TIFF file. Ref: Adobe, "TIFF", revision 6.0, 1992, section 2; for
/// 64 bits "The BigTIFF File Format" of libtiff.
class TiffChain {
public:
    explicit TiffChain(const std::filesystem::path& file)
        : m_in(file, std::ios::binary), m_bytes(std::filesystem::file_size(file)) {}

    [[nodiscard]] std::optional<std::string> lost() {
        if (!read_header())
            return std::nullopt;
        // A directory that leads back to itself is left to GDAL, which reads each only once.
        constexpr int kMax = 65'536;
        for (int number = 1; m_at != 0 && number <= kMax; ++number)
            if (const std::uint64_t end = end_of_directory(); end > m_bytes)
                return "directory " + std::to_string(number) + " ends at byte " +
                       (end == kBeyond ? "2^64 or later" : std::to_string(end)) + ", the file at " +
                       std::to_string(m_bytes);
        return std::nullopt;
    }

    [[nodiscard]] std::vector<std::uint16_t> geokeys() {
        constexpr std::uint64_t kMaxEntries = 4096;
        std::vector<std::uint16_t> out;
        if (!read_header())
            return out;
        const std::uint64_t count = std::min(number(m_at, m_big ? 8 : 2), kMaxEntries);
        const std::uint64_t first = sum(m_at, m_big ? 8 : 2);
        for (std::uint64_t i = 0; i < count && m_in && out.empty(); ++i)
            out = shorts(sum(first, i * (m_big ? 20 : 12)));
        return out;
    }

private:
    static constexpr std::uint64_t kBeyond = ~std::uint64_t{0};

    [[nodiscard]] bool read_header() {
        constexpr std::uint64_t kClassic = 42;
        constexpr std::uint64_t kBig = 43;
        std::array<char, 2> order{};
        if (!m_in.read(order.data(), order.size()))
            return false;
        m_little = order[0] == 'I';
        if (order[0] != order[1] || (!m_little && order[0] != 'M'))
            return false;
        const std::uint64_t version = number(2, 2);
        m_big = version == kBig;
        if (version != kClassic && !m_big)
            return false;
        m_at = m_big ? number(8, 8) : number(4, 4);
        return static_cast<bool>(m_in);
    }

    /// Returns 0 beyond the end, and sets m_in to a failed state.
    [[nodiscard]] std::uint64_t number(std::uint64_t at, int bytes) {
        std::array<unsigned char, 8> read{};
        m_in.seekg(static_cast<std::streamoff>(at));
        m_in.read(reinterpret_cast<char*>(read.data()), bytes);
        std::uint64_t out = 0;
        for (int i = 0; i < bytes; ++i) {
            const auto byte = read[static_cast<std::size_t>(m_little ? bytes - 1 - i : i)];
            out = out << 8 | byte;
        }
        return m_in ? out : 0;
    }

    [[nodiscard]] static std::uint64_t sum(std::uint64_t a, std::uint64_t b) noexcept {
        return a > kBeyond - b ? kBeyond : a + b;
    }

    /// The offset after the directory at m_at and its lists; advances to the next directory.
    [[nodiscard]] std::uint64_t end_of_directory() {
        const int wide = m_big ? 8 : 4;
        const std::uint64_t count_bytes = m_big ? 8 : 2;
        const std::uint64_t entry_bytes = m_big ? 20 : 12;
        const std::uint64_t first = sum(m_at, count_bytes);
        if (first > m_bytes)
            return first;
        const std::uint64_t count = number(m_at, static_cast<int>(count_bytes));
        if (count > m_bytes / entry_bytes)
            return kBeyond;
        // More entries than the file has room for: the chain has a cycle, or directories overlap.
        // Following it would take hours.
        m_entries += count;
        if (m_entries > m_bytes / entry_bytes) {
            m_at = 0;
            return 0;
        }
        const std::uint64_t next = first + count * entry_bytes;
        std::uint64_t end = sum(next, static_cast<std::uint64_t>(wide));
        if (end > m_bytes)
            return end;
        for (std::uint64_t i = 0; i < count; ++i)
            end = std::max(end, end_of_list(first + i * entry_bytes, wide));
        m_at = number(next, wide);
        return end;
    }

    /// The values of an entry with GeoTIFF keys; none of another one.
    [[nodiscard]] std::vector<std::uint16_t> shorts(std::uint64_t entry) {
        constexpr std::uint64_t kGeoKeys = 34735;
        constexpr std::uint64_t kMaxKeys = 4 * 4096;
        const int wide = m_big ? 8 : 4;
        std::vector<std::uint16_t> out;
        if (number(entry, 2) != kGeoKeys)
            return out;
        const std::uint64_t values = std::min(number(entry + 4, wide), kMaxKeys);
        // A header of four values and a key of four at least, which do not fit into the entry.
        const std::uint64_t at = number(entry + 4 + static_cast<std::uint64_t>(wide), wide);
        for (std::uint64_t i = 0; i < values && m_in; ++i)
            out.push_back(static_cast<std::uint16_t>(number(sum(at, 2 * i), 2)));
        return m_in ? out : std::vector<std::uint16_t>{};
    }

    /// For an entry with the offsets or lengths of strips or tiles: the end of its list; 0 for
    /// others.
    [[nodiscard]] std::uint64_t end_of_list(std::uint64_t entry, int wide) {
        constexpr std::array<std::uint64_t, 4> kTags{273, 279, 324, 325};
        if (std::find(kTags.begin(), kTags.end(), number(entry, 2)) == kTags.end())
            return 0;
        constexpr std::uint64_t kShort = 3;
        constexpr std::uint64_t kLong = 4;
        constexpr std::uint64_t kLong8 = 16;
        const std::uint64_t type = number(entry + 2, 2);
        const std::uint64_t count = number(entry + 4, wide);
        const std::uint64_t each = type == kShort ? 2 : type == kLong ? 4 : type == kLong8 ? 8 : 0;
        if (each == 0)
            return 0;
        if (count > m_bytes)
            return kBeyond;
        if (count * each <= static_cast<std::uint64_t>(wide))
            return 0;  // the value is stored in the entry
        return sum(number(entry + 4 + static_cast<std::uint64_t>(wide), wide), count * each);
    }

    std::ifstream m_in;
    const std::uint64_t m_bytes;
    std::uint64_t m_at = 0;       ///< of the next directory; 0: none
    std::uint64_t m_entries = 0;  ///< of all directories so far
    bool m_little = true;
    bool m_big = false;
};

}  // namespace

std::optional<std::string> find_lost_directory_of_tiff(const std::filesystem::path& file) {
    return TiffChain(file).lost();
}

std::vector<std::uint16_t> find_geokeys_of_tiff(const std::filesystem::path& file) {
    return TiffChain(file).geokeys();
}

std::optional<std::string> find_missing_part_of_tiff(const std::filesystem::path& file) {
    const GdalErrorScope errors;
    const char* const drivers[] = {"GTiff", nullptr};
    const GDALDatasetUniquePtr image{
        GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers)};
    if (!image)
        return "its directory: " + GdalErrorScope::reason();
    std::uint64_t end = 0;
    for (GDALRasterBand* band : image->GetBands()) {
        end = std::max(end, end_of_blocks(*band));
        for (int i = 0; i < band->GetOverviewCount(); ++i) {
            GDALRasterBand* overview = band->GetOverview(i);
            if (overview == nullptr)
                return "an overview";
            end = std::max(end, end_of_blocks(*overview));
        }
    }
    const std::uint64_t there = std::filesystem::file_size(file);
    if (end <= there)
        return std::nullopt;
    return std::to_string(end - there) + " of " + std::to_string(end) + " bytes";
}

}  // namespace terravox::geo
