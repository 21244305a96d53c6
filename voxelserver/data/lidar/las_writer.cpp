#include "voxelserver/data/lidar/las_writer.hpp"

#include <laszip/laszip_api.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::lidar {
namespace {

constexpr std::uint16_t kGlobalGpsTime = 1;
constexpr std::uint16_t kGlobalWkt = 16;
constexpr double kAngleStep_deg = 0.006;  ///< unit of the scan angle in formats 6-10

// Bytes of a point without extra bytes, by format.
constexpr std::array<std::uint16_t, 9> kRecordBytes = {20, 28, 26, 34, 0, 0, 30, 36, 38};

void copy_text(laszip_CHAR (&field)[32], const std::string& text) {
    std::memset(field, 0, sizeof field);
    std::memcpy(field, text.data(), std::min(text.size(), sizeof field - 1));
}

void check(const LasWriterOptions& options, const std::filesystem::path& path) {
    const int format = options.point_format;
    if (format < 0 || format > 8 || kRecordBytes[static_cast<std::size_t>(format)] == 0)
        throw util::UsageError("write {}: point format {}; allowed: 0-3, 6-8", path.string(),
                               format);
    for (const double scale : options.scale)
        if (!(scale > 0))
            throw util::UsageError("write {}: scale {:f}; allowed: above 0", path.string(), scale);
}

/// A LASzip writer that is neither closed nor deleted (State::broken). The list keeps it reachable,
/// so that tools that look for leaks know it from a forgotten one.
struct Abandoned {
    laszip_POINTER laszip = nullptr;
    Abandoned* next = nullptr;
};
std::atomic<Abandoned*> s_abandoned = nullptr;

}  // namespace

struct LasWriter::State {
    util::AtomicFile file;
    /// A stream of our own: LASzip's ignores the result of fclose(), and so the loss of the end of
    /// a file on a full disk.
    std::ofstream stream;
    LasWriterOptions options;
    laszip_POINTER laszip = nullptr;
    laszip_point_struct* point = nullptr;
    std::uint64_t count = 0;
    bool open = false;
    /// A call has failed. LASzip would go on writing when it is closed, although it may lack the
    /// memory for that: its objects stay where they are until the program ends.
    bool broken = false;
    /// Allocated while there is memory.
    std::unique_ptr<Abandoned> abandoned = std::make_unique<Abandoned>();

    State(const std::filesystem::path& path, LasWriterOptions o)
        : file(path), options(std::move(o)) {
        if (laszip_create(&laszip) != 0)
            throw util::Error("write {}: cannot create a LASzip writer", path.string());
    }
    ~State() {
        if (laszip == nullptr)
            return;
        if (broken) {
            Abandoned* const kept = abandoned.release();
            kept->laszip = laszip;
            kept->next = s_abandoned;
            while (!s_abandoned.compare_exchange_weak(kept->next, kept)) {
            }
            return;
        }
        if (open)
            laszip_close_writer(laszip);
        laszip_destroy(laszip);
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    [[nodiscard]] bool extended() const noexcept { return options.point_format >= 6; }
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("write {}: {}", file.target().string(), what);
    }
    void require(laszip_I32 result, const char* what) {
        if (result == 0)
            return;
        broken = true;
        laszip_CHAR* message = nullptr;
        laszip_get_error(laszip, &message);
        fail(std::string(what) + ": " + (message != nullptr ? message : "unknown LASzip error"));
    }
    void fill_header();
    void add_wkt();
    [[nodiscard]] laszip_I32 quantised(double value, std::size_t axis) const;
    void fill_returns(const LasWritePoint& from) const;
};

void LasWriter::State::fill_header() {
    laszip_header_struct* header = nullptr;
    require(laszip_get_header_pointer(laszip, &header), "cannot set the header");
    header->version_major = 1;
    header->version_minor = extended() ? 4 : 2;
    header->header_size = extended() ? 375 : 227;
    header->offset_to_point_data = header->header_size;
    header->global_encoding = static_cast<laszip_U16>(
        kGlobalGpsTime | (extended() && !options.wkt.empty() ? kGlobalWkt : 0));
    copy_text(header->system_identifier, options.system_identifier);
    copy_text(header->generating_software, options.generating_software);
    header->file_creation_day = options.creation_day;
    header->file_creation_year = options.creation_year;
    header->point_data_format = static_cast<laszip_U8>(options.point_format);
    header->point_data_record_length = kRecordBytes[static_cast<std::size_t>(options.point_format)];
    header->x_scale_factor = options.scale[0];
    header->y_scale_factor = options.scale[1];
    header->z_scale_factor = options.scale[2];
    header->x_offset = options.offset[0];
    header->y_offset = options.offset[1];
    header->z_offset = options.offset[2];
}

void LasWriter::State::add_wkt() {
    if (options.wkt.empty())
        return;
    const std::size_t bytes = options.wkt.size() + 1;  // LAS 1.4 requires the terminating null byte
    if (bytes > 65535)
        fail("the WKT has " + std::to_string(bytes) + " bytes; allowed: at most 65535");
    std::vector<laszip_U8> data(options.wkt.begin(), options.wkt.end());
    data.push_back(0);
    require(laszip_add_vlr(laszip, "LASF_Projection", 2112, static_cast<laszip_U16>(bytes),
                           "OGC WKT", data.data()),
            "cannot add the CRS");
}

laszip_I32 LasWriter::State::quantised(double value, std::size_t axis) const {
    const double steps = std::floor((value - options.offset[axis]) / options.scale[axis] + 0.5);
    if (!(steps >= -2147483648.0 && steps <= 2147483647.0))
        fail("coordinate " + std::to_string(value) + " does not fit scale " +
             std::to_string(options.scale[axis]) + " and offset " +
             std::to_string(options.offset[axis]));
    return static_cast<laszip_I32>(steps);
}

void LasWriter::State::fill_returns(const LasWritePoint& from) const {
    const int max_returns = extended() ? 15 : 7;
    const int max_class = extended() ? 255 : 31;
    if (from.return_number < 1 || from.return_number > from.return_count ||
        from.return_count > max_returns)
        fail("return " + std::to_string(from.return_number) + " of " +
             std::to_string(from.return_count) + "; allowed: 1 to " + std::to_string(max_returns));
    if (from.classification > max_class)
        fail("class " + std::to_string(from.classification) + "; allowed: 0 to " +
             std::to_string(max_class));
    const auto legacy = [](int value, int most) {
        return static_cast<laszip_U8>(std::min(value, most));
    };
    point->return_number = legacy(from.return_number, 7) & 7U;
    point->number_of_returns = legacy(from.return_count, 7) & 7U;
    point->classification = (from.classification > 31 ? 0U : from.classification) & 31U;
    if (!extended()) {
        point->scan_angle_rank =
            static_cast<laszip_I8>(std::clamp(std::floor(from.scan_angle_deg + 0.5), -90.0, 90.0));
        return;
    }
    point->extended_point_type = 1;
    point->extended_return_number = from.return_number & 15U;
    point->extended_number_of_returns = from.return_count & 15U;
    point->extended_classification = from.classification;
    point->extended_scan_angle = static_cast<laszip_I16>(
        std::clamp(std::floor(from.scan_angle_deg / kAngleStep_deg + 0.5), -30000.0, 30000.0));
}

LasWriter::LasWriter(const std::filesystem::path& path, const LasWriterOptions& options) {
    check(options, path);
    m_state = std::make_unique<State>(path, options);
    m_state->fill_header();
    m_state->require(laszip_preserve_generating_software(m_state->laszip, 1),
                     "cannot set the header");
    m_state->add_wkt();
    if (m_state->extended())
        m_state->require(laszip_request_native_extension(m_state->laszip, 1),
                         "cannot set the compression");
    const bool compress = path.extension() == ".laz" || path.extension() == ".LAZ";
    m_state->stream.open(m_state->file.temporary_path(), std::ios::binary | std::ios::trunc);
    if (!m_state->stream)
        m_state->fail(std::string("cannot open the file: ") + std::strerror(errno));
    m_state->require(
        laszip_open_writer_stream(m_state->laszip, m_state->stream, compress ? 1 : 0, 0),
        "cannot open the file");
    m_state->open = true;
    m_state->require(laszip_get_point_pointer(m_state->laszip, &m_state->point),
                     "cannot write points");
}

LasWriter::~LasWriter() = default;
LasWriter::LasWriter(LasWriter&&) noexcept = default;
LasWriter& LasWriter::operator=(LasWriter&&) noexcept = default;

void LasWriter::write(const LasWritePoint& from) {
    State& s = *m_state;
    laszip_point_struct& to = *s.point;
    to.X = s.quantised(from.x, 0);
    to.Y = s.quantised(from.y, 1);
    to.Z = s.quantised(from.z, 2);
    s.fill_returns(from);
    to.intensity = from.intensity;
    to.scan_direction_flag = from.forward_scan ? 1 : 0;
    to.edge_of_flight_line = from.line_edge ? 1 : 0;
    to.point_source_ID = from.point_source;
    to.gps_time = from.gps_time_s;
    for (std::size_t i = 0; i < 3; ++i)
        to.rgb[i] = from.rgb[i];
    s.require(laszip_write_point(s.laszip), "cannot write a point");
    s.require(laszip_update_inventory(s.laszip), "cannot count a point");
    ++s.count;
}

void LasWriter::close() {
    State& s = *m_state;
    s.open = false;
    s.require(laszip_close_writer(s.laszip), "cannot finish the file");
    s.stream.close();
    if (!s.stream)
        s.fail(std::string("cannot finish the file: ") + std::strerror(errno));
    s.file.commit();
}

std::uint64_t LasWriter::point_count() const noexcept {
    return m_state->count;
}

}  // namespace terravox::lidar
