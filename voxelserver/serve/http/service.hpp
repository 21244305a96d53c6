#pragma once

#include <cstdint>
#include <filesystem>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/boxes/box_cache.hpp"
#include "voxelserver/serve/boxes/preparer.hpp"
#include "voxelserver/serve/http/message.hpp"
#include "voxelserver/serve/http/request_counts.hpp"
#include "voxelserver/serve/http/routes.hpp"
#include "voxelserver/serve/http/squares.hpp"

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
[[nodiscard]] std::string etag_of(std::uint64_t hash, std::string_view tail);
/// Accepts only the canonical form of a number: no +1, -0, 007.
[[nodiscard]] std::optional<std::int32_t> parse_int32(std::string_view text) noexcept;

}  // namespace terravox::http
