#include "voxelserver/tools/laz/laz_commands.hpp"

#include <laszip/laszip_api.h>
#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/data/lidar/las_header.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/tools/laz/point_stream.hpp"

namespace terravox::laz {

namespace fs = std::filesystem;

namespace {

// Offsets in the header. Ref: ASPRS, "LAS Specification 1.4 - R15", 2019, section 2.4.
constexpr std::uint64_t kEncodingAt = 6;
constexpr std::uint64_t kPointsAt = 96;
constexpr std::uint64_t kRecordBytesAt = 105;
constexpr std::uint64_t kWaveformsAt = 227;
constexpr std::uint64_t kExtendedAt = 235;
constexpr std::uint64_t kExtendedCountAt = 243;
constexpr std::uint16_t kInternalWaveforms = 2;

/// LAS 1.4 stores point counts twice, with 32 and with 64 bits; LASzip refuses headers in which the
/// two differ. The field that belongs to the point format is kept.
void agree_on_counts(laszip_header_struct& header) {
    if (header.version_minor < 4)
        return;
    const bool extended = header.point_data_format >= 6;
    const auto agree = [extended](laszip_U32& narrow, laszip_U64& wide) {
        if (narrow == 0 || wide == 0 || narrow == wide)
            return;
        if (extended)
            narrow = 0;
        else
            wide = narrow;
    };
    agree(header.number_of_point_records, header.extended_number_of_point_records);
    for (int i = 0; i < 5; ++i)
        agree(header.number_of_points_by_return[i], header.extended_number_of_points_by_return[i]);
}

/// RAII wrapper of LASzip's writer.
class Writer {
public:
    Writer(const fs::path& path, const fs::path& shown, const laszip_header_struct& from)
        : m_shown(shown) {
        if (laszip_create(&m_writer) != 0)
            fail("LASzip could not start");
        try {
            laszip_header_struct header = from;
            // LASzip would store an offset that its file does not have; the data after the points
            // are appended later.
            header.start_of_waveform_data_packet_record = 0;
            header.start_of_first_extended_variable_length_record = 0;
            header.number_of_extended_variable_length_records = 0;
            agree_on_counts(header);
            require(laszip_set_header(m_writer, &header));
            require(laszip_preserve_generating_software(m_writer, 1));
            if (header.point_data_format >= 6)
                require(laszip_request_native_extension(m_writer, 1));
            require(laszip_open_writer(m_writer, path.c_str(), 1));
            m_open = true;
        } catch (...) {
            close();
            throw;
        }
    }
    ~Writer() { close(); }
    Writer(const Writer&) = delete;
    Writer& operator=(const Writer&) = delete;

    void write(const laszip_point_struct& point) {
        require(laszip_set_point(m_writer, &point));
        require(laszip_write_point(m_writer));
    }
    void finish() {
        m_open = false;
        require(laszip_close_writer(m_writer));
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("write " + m_shown.string() + ": " + what);
    }
    void require(laszip_I32 failed) const {
        if (failed != 0)
            fail(lidar::laszip_message(m_writer));
    }
    void close() noexcept {
        if (m_open)
            laszip_close_writer(m_writer);
        laszip_destroy(m_writer);
    }
    const fs::path& m_shown;
    laszip_POINTER m_writer = nullptr;
    bool m_open = false;
};

/// The data after the points of an uncompressed file, and the header fields that refer to them.
struct Tail {
    std::uint64_t at = 0;
    std::uint64_t bytes = 0;
    std::uint64_t waveforms = 0, extended = 0;  ///< offsets in the file; 0 = none
    std::uint32_t extended_count = 0;
};

Tail find_tail(const pointcloud::FileBytes& file, const lidar::LasInfo& info) {
    Tail tail;
    tail.at = file.at<std::uint32_t>(kPointsAt) +
              info.point_count * file.at<std::uint16_t>(kRecordBytesAt);
    const auto within = [&](std::uint64_t offset, const char* what) {
        if (offset < tail.at || offset >= file.size())
            file.fail(std::string(what) + " at byte " + std::to_string(offset) + "; allowed: " +
                      std::to_string(tail.at) + " to " + std::to_string(file.size() - 1));
        return offset;
    };
    if (info.version_minor >= 3 && (file.at<std::uint16_t>(kEncodingAt) & kInternalWaveforms) != 0)
        if (const auto at = file.at<std::uint64_t>(kWaveformsAt); at != 0)
            tail.waveforms = within(at, "waveforms");
    if (info.version_minor >= 4) {
        tail.extended_count = file.at<std::uint32_t>(kExtendedCountAt);
        if (tail.extended_count != 0)
            tail.extended = within(file.at<std::uint64_t>(kExtendedAt), "extended records");
    }
    // Bytes that no header field refers to are leftovers of a writer that appended; no reader uses
    // them.
    if (tail.waveforms != 0 || tail.extended != 0)
        tail.bytes = file.size() - tail.at;
    return tail;
}

template <class T>
void put_at(std::fstream& out, std::uint64_t offset, T value) {
    out.seekp(static_cast<std::streamoff>(offset));
    out.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void add_tail(const pointcloud::FileBytes& from, const Tail& tail, const lidar::LasInfo& info,
              const fs::path& path, const fs::path& shown) {
    std::fstream out(path, std::ios::in | std::ios::out | std::ios::binary | std::ios::ate);
    const auto end = static_cast<std::uint64_t>(out.tellp());
    std::vector<unsigned char> part(1 << 16);
    for (std::uint64_t done = 0; done < tail.bytes && out;) {
        const auto count =
            static_cast<std::size_t>(std::min<std::uint64_t>(part.size(), tail.bytes - done));
        from.read(tail.at + done, {part.data(), count});
        out.write(reinterpret_cast<const char*>(part.data()), static_cast<std::streamsize>(count));
        done += count;
    }
    const auto moved = [&](std::uint64_t offset) {
        return offset == 0 ? 0 : offset - tail.at + end;
    };
    if (info.version_minor >= 3) {
        // Waveforms in a separate file (.wdp) have an offset there, which is unchanged.
        const bool internal = tail.waveforms != 0;
        put_at(out, kWaveformsAt,
               internal ? moved(tail.waveforms) : from.at<std::uint64_t>(kWaveformsAt));
    }
    if (info.version_minor >= 4) {
        put_at(out, kExtendedAt, moved(tail.extended));
        put_at(out, kExtendedCountAt, tail.extended_count);
    }
    out.close();
    if (!out)
        throw util::Error("write " + shown.string() +
                          ": the disk did not take the records behind the points");
}

std::uint64_t compute_digest(const lidar::LasInfo& info, Writer* copy) {
    PointStream points(info);
    PointDigest digest(info.point_format);
    while (points.next()) {
        digest.add(points.point());
        if (copy != nullptr)
            copy->write(points.point());
    }
    return digest.value();
}

void check_same(const lidar::LasInfo& before, const fs::path& path, const fs::path& shown,
                std::uint64_t wanted) {
    const lidar::LasInfo after = lidar::read_las_info(path);
    const auto fail = [&](const std::string& what) {
        throw util::Error("write " + shown.string() + ": read back, " + what + "; it is not kept");
    };
    if (!after.compressed || after.point_format != before.point_format ||
        after.version_minor != before.version_minor)
        fail("it is of another format");
    if (after.point_count != before.point_count)
        fail("it has " + std::to_string(after.point_count) +
             " points; allowed: " + std::to_string(before.point_count));
    if (after.min != before.min || after.max != before.max || after.scale != before.scale ||
        after.offset != before.offset)
        fail("its header lies elsewhere");
    if (compute_digest(after, nullptr) != wanted)
        fail("a point differs from " + before.path.string());
}

}  // namespace

Compressed compress(const fs::path& from, const fs::path& to) {
    std::error_code none;
    if (fs::equivalent(from, to, none))
        throw util::UsageError("compress " + from.string() +
                               ": the result has the same name; allowed: another one");
    const lidar::LasInfo info = lidar::read_las_info(from);
    const pointcloud::FileBytes bytes(from);
    if (info.compressed)
        bytes.fail("compressed already; allowed: LAS");
    if (info.point_count == 0)
        bytes.fail("no points; allowed: 1 or more");
    const Tail tail = find_tail(bytes, info);
    util::AtomicFile file(to);
    std::uint64_t digest = 0;
    {
        const PointStream header(info);
        Writer writer(file.temporary_path(), to, header.header());
        digest = compute_digest(info, &writer);
        writer.finish();
    }
    add_tail(bytes, tail, info, file.temporary_path(), to);
    check_same(info, file.temporary_path(), to, digest);
    file.commit();
    return {info.point_count, info.file_bytes, fs::file_size(to)};
}

namespace {

bool is_copc(const std::filesystem::path& path) {
    const pointcloud::FileBytes file(path);
    const auto records = lidar::read_records(file);
    return std::any_of(records.begin(), records.end(), [](const lidar::VariableRecord& r) {
        return r.id == 1 && r.user == "copc";
    });
}

}  // namespace

std::string info_json(const std::filesystem::path& path) {
    const lidar::LasInfo info = lidar::read_las_info(path);
    const std::string crs = info.crs ? info.crs->name() : "";
    std::error_code none;
    const nlohmann::ordered_json json = {
        {"path", path.string()},
        {"bytes", info.file_bytes},
        {"version", "1." + std::to_string(info.version_minor)},
        {"point_format", info.point_format},
        {"compressed", info.compressed},
        {"copc", is_copc(path)},
        {"lax", std::filesystem::exists(lidar::lax_path(path), none)},
        {"point_count", info.point_count},
        {"scale", info.scale},
        {"offset", info.offset},
        {"min", info.min},
        {"max", info.max},
        {"crs",
         crs.starts_with("EPSG:") ? nlohmann::ordered_json(crs) : nlohmann::ordered_json(nullptr)},
        {"crs_name", info.crs ? nlohmann::ordered_json(crs) : nlohmann::ordered_json(nullptr)},
        {"colour", info.has_colour()},
        {"near_infrared", info.has_near_infrared()},
    };
    return json.dump(2, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

std::uint64_t check(const std::filesystem::path& path) {
    const lidar::LasInfo info = lidar::read_las_info(path);
    const pointcloud::FileBytes file(path);
    if (info.point_count == 0)
        file.fail("no points; allowed: 1 or more");
    PointStream points(info);
    std::uint64_t count = 0;
    while (points.next()) {
        const laszip_point_struct& p = points.point();
        const std::array<laszip_I32, 3> raw = {p.X, p.Y, p.Z};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double value = raw[axis] * info.scale[axis] + info.offset[axis];
            const double step = info.scale[axis];
            if (value < info.min[axis] - step || value > info.max[axis] + step) [[unlikely]]
                file.fail("point " + std::to_string(count) + " has " + "xyz"[axis] + " = " +
                          std::to_string(value) + "; allowed by its header: " +
                          std::to_string(info.min[axis]) + " to " + std::to_string(info.max[axis]));
        }
        ++count;
    }
    return count;
}

}  // namespace terravox::laz
