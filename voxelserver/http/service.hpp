#pragma once

#include <cstdint>

#include "common/util/stage_times.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/boxes/box_cache.hpp"
#include "voxelserver/boxes/preparer.hpp"
#include "voxelserver/http/message.hpp"
#include "voxelserver/http/request_counts.hpp"
#include "voxelserver/http/routes.hpp"
#include "voxelserver/http/squares.hpp"

namespace terravox::http {

class MapView;

/// A header of replies and requests (docs/formats/http.md: Editions).
inline constexpr const char* kEditionHeader = "Terravox-Edition";

/// Can boxes be made?
struct Health {
    enum class State { kOk, kOpening, kFailed } state = State::kOk;
    std::string reason = {};  ///< of kFailed; may name files
};

/// What the routes answer from. All of it must outlive the router.
struct Service {
    voxel::ProvenanceWorld& world;
    util::StageTimes& times;
    boxes::BoxCache& boxes;
    SquaresNow squares = [] { return std::vector<SquareEntry>{}; };
    std::function<Health()> health = [] { return Health{}; };
    const boxes::Preparer* preparer = nullptr;  ///< nullptr: nothing is being prepared
    MapView* map = nullptr;                     ///< nullptr: there is none
    /// Names the state of all that the boxes are made of, for clients that must not mix two.
    std::string edition = {};
    std::size_t memory_limit_bytes = 0;  ///< of the process; 0: not known
};

/// A request, as its route sees it.
struct RouteRequest {
    const Request& request;
    const PathParts& parts;
    bool has_token = false;  ///< the request brought the server's token
};

/// What a client learns of a voxel::UnreachableError.
inline constexpr const char* kUnreachable =
    "the server that this world comes from does not answer, or refuses; the log says why";

/// What the routes share.
[[nodiscard]] Response json_reply(std::string text,
                                  const Request& request);  ///< not to be kept; compressed where
                                                            ///< that helps and the client takes it
void add_validators(Response& out, std::string_view etag);
[[nodiscard]] Response not_modified(std::string_view etag);
[[nodiscard]] Response not_acceptable();
[[nodiscard]] Response not_numbers(const Request& request);
[[nodiscard]] Response no_such_level(int level, int levels);
[[nodiscard]] std::string etag_of(std::uint64_t hash,
                                  std::string_view tail);  ///< "16 hex digits-tail", in quotes
[[nodiscard]] std::optional<std::int32_t> parse_int32(
    std::string_view
        text) noexcept;  ///< only the one usual way to write a number counts: no +1, -0, 007

/// The resident memory of this process, bytes; 0 where the system does not tell.
[[nodiscard]] std::uint64_t resident_bytes() noexcept;

}  // namespace terravox::http
