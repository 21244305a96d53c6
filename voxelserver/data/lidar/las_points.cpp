#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/laszip_reader.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
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
        for (std::size_t chunk = m_info.chunks->chunk_of(range.begin);
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
            throw util::Error("read the point cloud " + info.path.string() + ": points " +
                              std::to_string(range.begin) + " to " + std::to_string(range.end) +
                              "; it has " + std::to_string(info.point_count));
        if (range.begin >= range.end)
            continue;
        if (!reader)
            reader.emplace(info, sink, echoes);
        reader->read(range);
    }
}

}  // namespace terravox::lidar
