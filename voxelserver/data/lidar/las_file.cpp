#include "voxelserver/data/lidar/las_file.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_header.hpp"
#include "voxelserver/data/lidar/laszip_reader.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
namespace {

template <class T>
std::vector<T> read_payload(const pointcloud::FileBytes& file, const VariableRecord& record) {
    std::vector<T> out(record.bytes / sizeof(T));
    file.read(record.at, {reinterpret_cast<unsigned char*>(out.data()), out.size() * sizeof(T)});
    return out;
}

/// What a file says of its coordinate reference system. Where several records say the same, the
/// first one that can be read counts.
struct CrsRecords {
    std::vector<std::string> wkts;
    std::vector<std::uint16_t> directory;
    std::vector<double> doubles;
    std::vector<char> ascii;
};

CrsRecords read_crs_records(const pointcloud::FileBytes& file) {
    CrsRecords out;
    std::vector<VariableRecord> records = read_records(file);
    const auto extended = read_extended_records(file);
    records.insert(records.end(), extended.begin(), extended.end());
    for (const VariableRecord& record : records) {
        // A longer one is refused as a text of a system, and is not read for that.
        if (record.user != "LASF_Projection" || record.bytes > geo::kLongestCrsText)
            continue;
        if (record.id == 2112) {
            const auto text = read_payload<char>(file, record);
            if (std::string wkt(text.begin(), std::find(text.begin(), text.end(), '\0'));
                !wkt.empty())
                out.wkts.push_back(std::move(wkt));
        }
        if (record.id == 34735 && out.directory.empty())
            out.directory = read_payload<std::uint16_t>(file, record);
        if (record.id == 34736 && out.doubles.empty())
            out.doubles = read_payload<double>(file, record);
        if (record.id == 34737 && out.ascii.empty())
            out.ascii = read_payload<char>(file, record);
    }
    return out;
}

/// @param fault of the first record that says something of no use
std::optional<geo::Crs> find_crs(const std::filesystem::path& path, std::string& fault) {
    const auto keep = [&fault](const util::Error& e) {
        if (fault.empty())
            fault = e.what();
    };
    const CrsRecords records = read_crs_records(pointcloud::FileBytes(path));
    for (const std::string& wkt : records.wkts) {
        try {
            return geo::Crs::from_wkt(wkt);
        } catch (const geo::ProjUnusableError&) {
            throw;
        } catch (const util::Error& e) {
            // Some writers store text that is not WKT in addition to valid GeoTIFF keys: then the
            // keys are used, or the user's --crs.
            util::log_info("{}: {}; its GeoTIFF keys decide, or --crs", path.string(), e.what());
            keep(e);
        }
    }
    try {
        return geo::Crs::from_geokeys(records.directory, records.doubles, records.ascii);
    } catch (const geo::ProjUnusableError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_info("{}: {}; --crs sets one", path.string(), e.what());
        keep(e);
    }
    return std::nullopt;
}

}  // namespace

LasInfo read_las_info(const std::filesystem::path& path) {
    LasInfo info = check_las_header(path);
    // What LASzip does not open is refused here, not when its first points are wanted.
    const LaszipReader reader(path, {});
    info.crs = find_crs(path, info.crs_fault);
    return info;
}

std::vector<PointRange> split_by_chunk(const LasInfo& info, std::uint64_t points_per_range) {
    std::vector<PointRange> out;
    if (info.point_count == 0)
        return out;
    if (!info.seekable)
        return {{0, info.point_count}};
    if (!info.chunks) {
        const std::uint64_t step =
            std::max<std::uint64_t>(1, points_per_range / info.chunk_points) * info.chunk_points;
        for (std::uint64_t begin = 0; begin < info.point_count; begin += step)
            out.push_back({begin, std::min(begin + step, info.point_count)});
        return out;
    }
    const auto& starts = info.chunks->first_point;
    for (std::size_t i = 0; i + 1 < starts.size(); ++i) {
        if (info.chunks->empty_chunk(i))
            continue;
        if (!out.empty() && starts[i + 1] - out.back().begin <= points_per_range)
            out.back().end = starts[i + 1];
        else
            out.push_back({starts[i], starts[i + 1]});
    }
    return out;
}

namespace {

// 1024 points fit in the L1 cache along with LASzip's own tables.
constexpr std::size_t kBatchPoints = 1024;

void copy_extended(const laszip_point_struct& from, RawPoint& to) noexcept {
    to.classification = from.extended_classification;
    to.return_number = from.extended_return_number;
    to.return_count = from.extended_number_of_returns;
    to.withheld = (from.extended_classification_flags & 4) != 0;
    to.overlap = (from.extended_classification_flags & 8) != 0;
}

void copy_legacy(const laszip_point_struct& from, RawPoint& to) noexcept {
    to.classification = from.classification;
    to.return_number = from.return_number;
    to.return_count = from.number_of_returns;
    to.withheld = from.withheld_flag != 0;
    to.overlap = from.classification == 12;
}

// LASzip can do this itself, but it trusts the description of the extra bytes;
// find_compatible_bytes() has validated them.
void copy_compatible(const laszip_point_struct& from, const CompatibleBytes& bytes,
                     RawPoint& to) noexcept {
    const laszip_U8 *const extra = from.extra_bytes, returns = extra[bytes.returns];
    to.classification =
        static_cast<std::uint8_t>(from.classification + extra[bytes.classification]);
    to.return_number = static_cast<std::uint8_t>(from.return_number + (returns >> 4));
    to.return_count = static_cast<std::uint8_t>(from.number_of_returns + (returns & 15));
    to.withheld = from.withheld_flag != 0;
    to.overlap = (extra[bytes.flags] & 1) != 0;
    if (bytes.near_infrared)
        to.nir = static_cast<std::uint16_t>(extra[*bytes.near_infrared] |
                                            extra[*bytes.near_infrared + 1] << 8);
}

class BatchReader {
public:
    BatchReader(const LasInfo& info, const RawBatchSink& sink, Echoes echoes)
        : m_info(info),
          m_sink(sink),
          m_bytes(info.path),
          m_reader(info.path,
                   {info.has_colour(), info.has_near_infrared(), echoes == Echoes::kRead}),
          m_echoes(echoes == Echoes::kRead),
          m_batch(kBatchPoints) {}

    void read(PointRange range) {
        if (!m_info.chunks)
            return read_piece(range);
        // Chunk by chunk; each is checked before it is passed to LASzip.
        const auto& starts = m_info.chunks->first_point;
        for (std::size_t chunk = m_info.chunks->find_chunk(range.begin);
             chunk < m_info.chunks->size() && starts[chunk] < range.end; ++chunk) {
            if (m_info.chunks->empty_chunk(chunk)) {
                // LASzip would continue reading in it, so seek to the points after it.
                m_at = kNowhere;
                continue;
            }
            check_chunk(m_bytes, *m_info.chunks, chunk);
            read_piece(
                {std::max(range.begin, starts[chunk]), std::min(range.end, starts[chunk + 1])});
        }
    }

private:
    void read_piece(PointRange range) {
        if (range.begin != m_at)
            m_reader.seek(range.begin);
        for (m_at = range.begin; m_at < range.end;) {
            const auto count =
                static_cast<std::size_t>(std::min<std::uint64_t>(kBatchPoints, range.end - m_at));
            for (std::size_t i = 0; i < count; ++i) {
                m_reader.next();
                copy(m_batch[i]);
            }
            m_at += count;
            m_sink({m_batch.data(), count});
        }
    }
    void copy(RawPoint& to) const noexcept {
        const laszip_point_struct& from = m_reader.point();
        to.x = from.X;
        to.y = from.Y;
        to.z = from.Z;
        if (m_extended)
            copy_extended(from, to);
        else if (m_info.compatible) [[unlikely]]
            copy_compatible(from, *m_info.compatible, to);
        else
            copy_legacy(from, to);
        if (m_echoes) {
            to.intensity = from.intensity;
            to.point_source = from.point_source_ID;
        }
        if (m_colour)
            to.rgb = {from.rgb[0], from.rgb[1], from.rgb[2]};
        if (m_near_infrared)
            to.nir = from.rgb[3];
    }
    const LasInfo& m_info;
    const RawBatchSink& m_sink;
    const pointcloud::FileBytes m_bytes;
    LaszipReader m_reader;
    bool m_echoes;
    std::vector<RawPoint> m_batch;
    static constexpr std::uint64_t kNowhere = std::numeric_limits<std::uint64_t>::max();
    /// The next point that LASzip decodes. At the beginning LASzip is in the first chunk, which may
    /// be empty.
    std::uint64_t m_at = m_info.chunks && m_info.chunks->empty_chunk(0) ? kNowhere : 0;
    const bool m_extended = m_info.point_format >= 6;
    const bool m_colour = m_info.has_colour();
    const bool m_near_infrared = m_extended && m_info.has_near_infrared();
};

}  // namespace

void read_point_batches(const LasInfo& info, std::span<const PointRange> ranges,
                        const RawBatchSink& sink, Echoes echoes) {
    std::optional<BatchReader> reader;
    for (const PointRange& range : ranges) {
        if (range.end > info.point_count)
            throw util::Error("read the point cloud {}: points {} to {}; it has {}",
                              info.path.string(), range.begin, range.end, info.point_count);
        if (range.begin >= range.end)
            continue;
        if (!reader)
            reader.emplace(info, sink, echoes);
        reader->read(range);
    }
}

namespace {

constexpr std::size_t kMaxChunks = 64;
/// Limit for a root node, which may be large; takes some hundredths of a second.
constexpr std::uint64_t kMaxDecoded = 100'000;

// The root node of a COPC file holds points from the whole area, which some writers sort by
// position. It holds at least as many as requested.
std::vector<RawPoint> sample_root(const LasInfo& info, PointRange root, std::size_t about) {
    const PointRange read{
        root.begin, std::min(root.end, root.begin + std::max<std::uint64_t>(kMaxDecoded, about))};
    const std::uint64_t stride = (read.end - read.begin) / about;
    std::vector<RawPoint> out;
    std::uint64_t at = 0;
    read_point_batches(info, {&read, 1}, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& point : batch)
            if (at++ % stride == 0)
                out.push_back(point);
    });
    return out;
}

// Whoever needs the hierarchy says what is wrong with it; a sample does not.
std::optional<PointRange> find_root(const LasInfo& info) {
    try {
        const auto copc = read_copc_index(info);
        return copc ? copc->root : std::nullopt;
    } catch (const util::Error&) {
        return std::nullopt;
    }
}

std::vector<PointRange> beginnings(const LasInfo& info, std::size_t about) {
    if (!info.seekable)
        return {{0, std::min<std::uint64_t>(about, info.point_count)}};
    // An uncompressed file has no chunks, so it can be divided anywhere.
    const std::size_t pieces = std::min(kMaxChunks, about);
    std::vector<PointRange> out;
    const std::uint64_t chunks =
        info.chunks ? info.chunks->size() : std::min<std::uint64_t>(pieces, info.point_count);
    const std::uint64_t used = std::min<std::uint64_t>(pieces, chunks);
    const std::uint64_t each = (about + used - 1) / used;
    for (std::uint64_t i = 0; i < used; ++i) {
        const std::uint64_t chunk = i * chunks / used;
        const std::uint64_t begin =
            info.chunks ? info.chunks->first_point[chunk] : chunk * info.point_count / chunks;
        const std::uint64_t end = info.chunks ? info.chunks->first_point[chunk + 1]
                                              : (chunk + 1) * info.point_count / chunks;
        out.push_back({begin, std::min(end, begin + each)});
    }
    return out;
}

}  // namespace

std::vector<RawPoint> sample_points(const LasInfo& info, std::size_t about) {
    if (info.point_count == 0 || about == 0)
        return {};
    // A root with only a few points would be a poor sample of millions.
    if (const auto root = find_root(info); root && root->end - root->begin >= about)
        return sample_root(info, *root, about);
    std::vector<RawPoint> out;
    read_point_batches(info, beginnings(info, about), [&](std::span<const RawPoint> batch) {
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

}  // namespace terravox::lidar
