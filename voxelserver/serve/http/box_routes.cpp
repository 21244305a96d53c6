#include "voxelserver/serve/http/box_routes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/voxel/box_codec.hpp"

namespace terravox::http {
namespace {

using voxel::kBoxSizeY;

// Part of every entity tag: each content coding is a separate representation.
constexpr std::string_view kZstdTag = "z1";
constexpr std::string_view kIdentityTag = "i1";
constexpr std::string_view kAirTag = "\"air\"";

template <std::size_t N>
std::optional<std::array<std::int32_t, N>> numbers_of(const PathParts& parts) {
    std::array<std::int32_t, N> out{};
    for (std::size_t i = 0; i < N; ++i) {
        const auto number = parse_int32(parts.part[i + 2]);
        if (!number)
            return std::nullopt;
        out[i] = *number;
    }
    return out;
}

}  // namespace

Response answer_box(Service& service, const RouteRequest& call) {
    const auto numbers = numbers_of<4>(call.parts);
    if (!numbers)
        return not_numbers(call.request);
    const auto [level, bx, by, bz] = *numbers;
    if (const int levels = service.world.info().levels; level < 0 || level >= levels)
        return no_such_level(level, levels);
    const Coding coding = choose_coding(call.request.header("Accept-Encoding"));
    if (coding == Coding::kNone)
        return not_acceptable();
    const voxel::BoxKey key{level, bx, by, bz};
    const auto kept = service.boxes.get(key);
    const bool packed = coding == Coding::kZstd;
    const std::string etag = kept->air() ? std::string(kAirTag)
                                         : etag_of(packed ? kept->frame_hash : kept->checksum,
                                                   packed ? kZstdTag : kIdentityTag);
    if (etag_matches(call.request.header("If-None-Match"), etag))
        return not_modified(etag).add("Vary", "Accept-Encoding");
    Response out;
    out.status = kept->air() ? 204 : 200;
    add_validators(out, etag);
    out.add("Vary", "Accept-Encoding");
    if (kept->air())
        return out;
    out.add("Content-Type", voxel::kBoxMediaType);
    if (packed) {
        out.add("Content-Encoding", "zstd");
        out.body = kept->frame;
    } else {
        const auto box = boxes::BoxCache::unpacked(*kept, key);
        const auto blob = box->blob();
        out.body = std::make_shared<const std::string>(reinterpret_cast<const char*>(blob.data()),
                                                       blob.size());
    }
    return out;
}

Response answer_column(Service& service, const RouteRequest& call) {
    const auto numbers = numbers_of<3>(call.parts);
    if (!numbers)
        return not_numbers(call.request);
    const auto [level, bx, bz] = *numbers;
    const voxel::WorldInfo& info = service.world.info();
    if (level < 0 || level >= info.levels)
        return no_such_level(level, info.levels);
    const voxel::ColumnExtent extent = service.world.column(level, bx, bz);
    std::int64_t min_y = 0;
    std::int64_t max_y = 0;
    if (!extent.empty()) {
        const std::int64_t side = std::int64_t{kBoxSizeY} << level;
        min_y = std::max<std::int64_t>(extent.by_begin * side, info.bounds.min[1]);
        max_y = std::min<std::int64_t>(extent.by_end * side, info.bounds.max[1]);
    }
    const nlohmann::json out = {{"by_begin", extent.by_begin},
                                {"by_end", extent.by_end},
                                {"min_y", min_y},
                                {"max_y", max_y}};
    return json_reply(out.dump() + "\n", call.request);
}

}  // namespace terravox::http
