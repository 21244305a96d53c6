#include "voxelserver/serve/http/service.hpp"

#include <zstd.h>
#include <algorithm>
#include <charconv>
#include <exception>
#include <new>
#include <nlohmann/json.hpp>

#include "common/util/log.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/boxes/admission_control.hpp"
#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

using nlohmann::json;

std::string squares_json(const std::vector<SquareEntry>& squares, const voxel::WorldInfo& info) {
    json features = json::array();
    for (const SquareEntry& s : squares) {
        const double west = s.min_x * info.crs_units_per_voxel;
        const double east = s.max_x * info.crs_units_per_voxel;
        const double north = -s.min_z * info.crs_units_per_voxel;
        const double south = -s.max_z * info.crs_units_per_voxel;
        const double area_m2 = (static_cast<double>(s.max_x) - s.min_x) *
                               (static_cast<double>(s.max_z) - s.min_z) * info.voxel_m *
                               info.voxel_m;
        const auto text = [](const std::optional<std::string>& t) { return t ? json(*t) : json(); };
        const json density =
            s.points && area_m2 > 0 ? json(static_cast<double>(*s.points) / area_m2) : json();
        features.push_back(
            {{"type", "Feature"},
             {"geometry",
              {{"type", "Polygon"},
               {"coordinates",
                {{{west, south}, {east, south}, {east, north}, {west, north}, {west, south}}}}}},
             {"properties",
              {{"name", s.name},
               {"state", s.state},
               {"file", text(s.file)},
               {"points", s.points ? json(*s.points) : json()},
               {"density_per_m2", density},
               {"bytes", s.bytes},
               {"source", s.source},
               {"licence", s.licence},
               {"attribution", s.attribution},
               {"error", s.error ? json(without_folders(*s.error)) : json()}}}});
    }
    const json out = {{"type", "FeatureCollection"}, {"crs", info.crs}, {"features", features}};
    return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

void RequestCounts::add(Route route, int status, double seconds) noexcept {
    OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    ++r.status[static_cast<std::size_t>(std::clamp(status - kFirstStatus, 0, kStatuses - 1))];
    const auto bucket = std::lower_bound(kBucketEnds_s.begin(), kBucketEnds_s.end(), seconds) -
                        kBucketEnds_s.begin();
    ++r.bucket[static_cast<std::size_t>(bucket)];
    r.microseconds += static_cast<std::uint64_t>(std::max(seconds, 0.0) * 1e6);
}

std::map<int, std::uint64_t> RequestCounts::statuses(Route route) const {
    std::map<int, std::uint64_t> out;
    const OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    for (int i = 0; i < kStatuses; ++i)
        if (const std::uint64_t n = r.status[static_cast<std::size_t>(i)]; n > 0)
            out[kFirstStatus + i] = n;
    return out;
}

RequestCounts::Times RequestCounts::times(Route route) const noexcept {
    Times out;
    const OfRoute& r = m_routes[static_cast<std::size_t>(route)];
    for (std::size_t i = 0; i < kBuckets; ++i)
        out.count += out.buckets[i] = r.bucket[i];
    out.seconds = static_cast<double>(r.microseconds) * 1e-6;
    return out;
}

std::uint64_t RequestCounts::replies() const noexcept {
    std::uint64_t out = 0;
    for (const OfRoute& r : m_routes)
        for (const auto& bucket : r.bucket)
            out += bucket;
    return out;
}

namespace {

// What fits into one packet anyway is not sent faster.
constexpr std::size_t kWorthCompressing = 1400;

}  // namespace

Response json_reply(std::string text, const Request& request) {
    Response out;
    out.add("Content-Type", "application/json")
        .add("Cache-Control", "no-store")
        .add("Vary", "Accept-Encoding");
    const Coding coding = choose_coding(request.header("Accept-Encoding"));
    if (coding == Coding::kNone)
        return not_acceptable();
    if (coding == Coding::kZstd && text.size() > kWorthCompressing) {
        std::string packed(ZSTD_compressBound(text.size()), '\0');
        const std::size_t size =
            ZSTD_compress(packed.data(), packed.size(), text.data(), text.size(), 1);
        if (ZSTD_isError(size) == 0) {
            packed.resize(size);
            text = std::move(packed);
            out.add("Content-Encoding", "zstd");
        }
    }
    out.body = std::make_shared<const std::string>(std::move(text));
    return out;
}

// A client may cache it, but must revalidate it with If-None-Match each time: the server may have
// other data tomorrow.
void add_validators(Response& out, std::string_view etag) {
    out.add("ETag", etag).add("Cache-Control", "no-cache");
}

Response not_modified(std::string_view etag) {
    Response out;
    out.status = 304;
    add_validators(out, etag);
    return out;
}

Response not_acceptable() {
    return problem(406,
                   "the request takes neither zstd nor identity; allowed: Accept-Encoding with one "
                   "of them, or none");
}

Response not_numbers(const Request& request) {
    return problem(400, "read the address " + std::string(request.path) +
                            ": not whole numbers from -2147483648 to 2147483647, such as -12");
}

Response no_such_level(int level, int levels) {
    return problem(
        404, "level " + std::to_string(level) + "; allowed: 0 to " + std::to_string(levels - 1));
}

std::string make_etag(std::uint64_t hash, std::string_view tail) {
    static constexpr char kHex[] = "0123456789abcdef";
    std::string out(18 + tail.size() + 1, '-');
    out[0] = '"';
    for (int i = 0; i < 16; ++i)
        out[static_cast<std::size_t>(16 - i)] = kHex[hash >> (4 * i) & 15];
    out.replace(18, tail.size(), tail);
    out.back() = '"';
    return out;
}

std::optional<std::int32_t> parse_int32(std::string_view text) noexcept {
    std::int32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    const bool minus = text.front() == '-';
    const char first = text[minus ? 1 : 0];
    if (first == '0' && text.size() > 1)
        return std::nullopt;  // 007, -0
    return value;
}

Response reply_to_current_exception(const Request& request) {
    try {
        throw;
    } catch (const boxes::OverloadedError& e) {
        return problem(503, e.what()).add("Retry-After", "1");
    } catch (const voxel::UnreachableError& e) {
        // The address of the other server is only for the operator of this one.
        util::log_error("{} {}: {}", request.method, request.path, e.what());
        return problem(502, kUnreachable).add("Retry-After", "5");
    } catch (const std::bad_alloc&) {
        util::log_error("{} {}: out of memory", request.method, request.path);
        return problem(500, "out of memory");
    } catch (const std::exception& e) {
        util::log_error("{} {}: {}", request.method, request.path, e.what());
        return problem(500, without_folders(e.what()));
    } catch (...) {
        util::log_error("{} {}: unknown error", request.method, request.path);
        return problem(500, "unknown error");
    }
}

}  // namespace terravox::http
