#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/boxes/box_cache.hpp"
#include "voxelserver/serve/boxes/preparer.hpp"
#include "voxelserver/serve/host/message.hpp"
#include "voxelserver/serve/http/routes.hpp"

namespace terravox::http {

/// A LiDAR square as shown by the HTTP interface.
struct SquareEntry {
    std::string name, state;  ///< "wanted", "fetched", "prepared", "failed"
    std::optional<std::string> file;
    std::optional<std::string> error;
    std::optional<std::uint64_t> points;
    std::uint64_t bytes = 0;
    std::string source;
    std::string licence;
    std::string attribution;
    std::int32_t min_x = 0, min_z = 0, max_x = 0, max_z = 0;  ///< voxels of level 0, half-open
};

/// Called for each reply: must be cheap and thread-safe.
using SquaresNow = std::function<std::vector<SquareEntry>()>;

/// GeoJSON in the world's own CRS (named in the member `crs`), not in degrees, because the page
/// shows the world in that CRS.
[[nodiscard]] std::string squares_json(const std::vector<SquareEntry>& squares,
                                       const voxel::WorldInfo& info);

/// Counts of the replies sent, by route and status, and their durations. Thread-safe and lock-free,
/// since every request is counted here.
class RequestCounts {
public:
    /// Upper bounds of the buckets of durations, seconds; the last bucket has none.
    static constexpr std::array kBucketEnds_s = {0.0005, 0.001, 0.005, 0.01, 0.05,
                                                 0.1,    0.5,   1.0,   5.0,  30.0};
    static constexpr std::size_t kBuckets = kBucketEnds_s.size() + 1;

    void add(Route route, int status, double seconds) noexcept;
    void add_bytes(std::uint64_t bytes) noexcept { m_bytes += bytes; }

    struct Times {
        std::array<std::uint64_t, kBuckets> buckets{};  ///< not cumulative
        std::uint64_t count = 0;
        double seconds = 0;
    };
    [[nodiscard]] std::map<int, std::uint64_t> statuses(Route route) const;
    [[nodiscard]] Times times(Route route) const noexcept;
    [[nodiscard]] std::uint64_t replies() const noexcept;
    [[nodiscard]] std::uint64_t bytes() const noexcept { return m_bytes; }  ///< of bodies, as sent

private:
    static constexpr int kFirstStatus = 100;
    static constexpr int kStatuses = 500;
    struct OfRoute {
        std::array<std::atomic<std::uint64_t>, kStatuses> status{};
        std::array<std::atomic<std::uint64_t>, kBuckets> bucket{};
        std::atomic<std::uint64_t> microseconds{0};
    };
    std::array<OfRoute, kRouteCount> m_routes;
    std::atomic<std::uint64_t> m_bytes{0};
};

}  // namespace terravox::http

namespace terravox::jobs {
class JobQueue;
}

namespace terravox::http {

class MapView;

/// A header of replies and requests (docs/formats/http.md: Editions).
inline constexpr const char* kEditionHeader = "Terravox-Edition";

/// Whether boxes can be made.
struct Health {
    enum class State { kOk, kOpening, kFailed } state = State::kOk;
    std::string reason = {};  ///< for kFailed; may contain file names
};

/// The resources that the routes use. All of them must outlive the router.
struct Service {
    voxel::ProvenanceWorld& world;
    util::StageTimes& times;
    boxes::BoxCache& boxes;
    SquaresNow squares = [] { return std::vector<SquareEntry>{}; };
    std::function<Health()> health = [] { return Health{}; };
    const boxes::Preparer* preparer = nullptr;  ///< nullptr: no boxes are being prepared
    MapView* map = nullptr;                     ///< nullptr: there is no map
    jobs::JobQueue* jobs = nullptr;             ///< nullptr: no analyses are made
    std::filesystem::path archive = {};  ///< the file of a world that is a box archive; else empty
    /// Identifies the state of all inputs of the boxes, for clients that must not mix boxes of two
    /// states.
    std::string edition = {};
    std::size_t memory_limit_bytes = 0;  ///< limit of the process; 0: unknown
};

/// A request, as passed to its route.
struct RouteRequest {
    const Request& request;
    const PathParts& parts;
    bool has_token = false;  ///< whether the request carries the server's token
};

/// The text of the reply for a voxel::UnreachableError.
inline constexpr const char* kUnreachable =
    "the server that this world comes from does not answer, or refuses; the log says why";

// Helpers shared by the routes.

/// A reply that must not be cached. It is compressed where that helps and the client accepts it.
[[nodiscard]] Response json_reply(std::string text, const Request& request);
void add_validators(Response& out, std::string_view etag);
[[nodiscard]] Response not_modified(std::string_view etag);
[[nodiscard]] Response not_acceptable();
[[nodiscard]] Response not_numbers(const Request& request);
[[nodiscard]] Response no_such_level(int level, int levels);
/// "16 hex digits-tail", in quotes.
[[nodiscard]] std::string make_etag(std::uint64_t hash, std::string_view tail);
/// Accepts only the canonical form of a number: no +1, -0, 007.
[[nodiscard]] std::optional<std::int32_t> parse_int32(std::string_view text) noexcept;

/// Converts the exception that is being handled to a reply; details that clients must not see are
/// only logged. Must be called in a catch block only.
///
/// - boxes::OverloadedError: 503, to be retried after a second; not logged
/// - voxel::UnreachableError: 502, without the address of the other server
/// - everything else: 500; the text of a std::exception, without the folders of this machine
///
/// @throws only when there is not enough memory for an error reply
[[nodiscard]] Response reply_to_current_exception(const Request& request);

}  // namespace terravox::http
