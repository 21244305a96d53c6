#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <exception>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <system_error>
#include <thread>

#include "common/util/json_text.hpp"
#include "common/util/log.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/serve/http/file_reply.hpp"
#include "voxelserver/serve/http/route_answers.hpp"

namespace terravox::http {
namespace {

using voxel::kBoxSizeY;

// Part of every entity tag: each content coding is a separate representation.
constexpr std::string_view kZstdTag = "z1";
constexpr std::string_view kIdentityTag = "i1";
constexpr std::string_view kAirTag = "\"air\"";

template <std::size_t N>
std::optional<std::array<std::int32_t, N>> list_numbers(const PathParts& parts) {
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
    const auto numbers = list_numbers<4>(call.parts);
    if (!numbers)
        return not_numbers(call.request);
    const auto [level, bx, by, bz] = *numbers;
    if (const int levels = service.world.info().levels; level < 0 || level >= levels)
        return no_such_level(level, levels);
    const Coding coding = choose_coding(call.request.header("Accept-Encoding"));
    if (coding == Coding::kNone)
        return not_acceptable();
    const voxel::BoxKey key{level, bx, by, bz};
    const auto found = service.boxes.find_or_make(key);
    const bool packed = coding == Coding::kZstd;
    const std::string etag = found->air() ? std::string(kAirTag)
                                          : make_etag(packed ? found->frame_hash : found->checksum,
                                                      packed ? kZstdTag : kIdentityTag);
    if (etag_matches(call.request.header("If-None-Match"), etag))
        return not_modified(etag).add("Vary", "Accept-Encoding");
    Response out;
    out.status = found->air() ? 204 : 200;
    add_validators(out, etag);
    out.add("Vary", "Accept-Encoding");
    if (found->air())
        return out;
    out.add("Content-Type", voxel::kBoxMediaType);
    if (packed) {
        out.add("Content-Encoding", "zstd");
        out.body = found->frame;
    } else {
        const auto box = boxes::BoxCache::decompress(*found, key);
        const auto blob = box->blob();
        out.body = std::make_shared<const std::string>(reinterpret_cast<const char*>(blob.data()),
                                                       blob.size());
    }
    return out;
}

Response answer_column(Service& service, const RouteRequest& call) {
    const auto numbers = list_numbers<3>(call.parts);
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

namespace {

using nlohmann::json;
using voxel::BoxKey;

constexpr std::size_t kLanes = 4;
// Timeout for a place in the queue, while other requests take the free ones.
constexpr auto kTimeout = std::chrono::seconds(60);
constexpr auto kPause = std::chrono::milliseconds(50);

/// RAII count of the running batches.
/// Each batch has threads of its own.
boxes::Slots& batches() {
    static boxes::Slots all(8, "make a batch of boxes", "batches are being made");
    return all;
}

[[noreturn]] void refuse(const std::string& what) {
    throw util::UsageError("read the list of boxes: " + what +
                           "; allowed: {\"boxes\": [[level, bx, by, bz], ...]}, 1 to " +
                           std::to_string(kMaxBatchBoxes) + " boxes, whole numbers of 32 bits");
}

std::vector<BoxKey> list_keys(std::string_view body, int levels) {
    const json in = util::parse_json(body);
    if (!in.is_object() || !in.contains("boxes") || !in["boxes"].is_array())
        refuse("not JSON of that form");
    const json& list = in["boxes"];
    if (list.empty() || list.size() > kMaxBatchBoxes)
        refuse(std::to_string(list.size()) + " boxes");
    std::vector<BoxKey> out;
    for (const json& one : list) {
        if (!one.is_array() || one.size() != 4)
            refuse("an entry is not four numbers");
        std::array<std::int32_t, 4> numbers{};
        for (std::size_t i = 0; i < 4; ++i) {
            if (!one[i].is_number_integer())
                refuse("an entry is not four whole numbers");
            const auto value =
                one[i].is_number_unsigned() && one[i].get<std::uint64_t>() > INT64_MAX
                    ? INT64_MAX
                    : one[i].get<std::int64_t>();
            if (value < INT32_MIN || value > INT32_MAX)
                refuse("the number " + one[i].dump());
            numbers[i] = static_cast<std::int32_t>(value);
        }
        if (numbers[0] < 0 || numbers[0] >= levels)
            refuse("level " + std::to_string(numbers[0]) + " of a world with levels 0 to " +
                   std::to_string(levels - 1));
        out.push_back({numbers[0], numbers[1], numbers[2], numbers[3]});
    }
    return out;
}

std::string record(const BoxKey& key, std::uint32_t status, std::string_view payload) {
    const std::uint32_t words[6] = {static_cast<std::uint32_t>(key.level),
                                    static_cast<std::uint32_t>(key.bx),
                                    static_cast<std::uint32_t>(key.by),
                                    static_cast<std::uint32_t>(key.bz),
                                    status,
                                    static_cast<std::uint32_t>(payload.size())};
    std::string out;
    out.reserve(kBatchRecordBytes + payload.size());
    for (const std::uint32_t word : words)
        for (int byte = 0; byte < 4; ++byte)
            out += static_cast<char>(word >> (8 * byte) & 255);
    out += payload;
    return out;
}

// The queue may be full of other clients' boxes: a batch waits longer than a single request may.
boxes::CompressedBoxPtr get_with_retries(boxes::BoxCache& cache, const BoxKey& key) {
    for (const auto give_up = std::chrono::steady_clock::now() + kTimeout;;) {
        try {
            return cache.find_or_make(key);
        } catch (const boxes::OverloadedError&) {
            if (cache.refusing() || std::chrono::steady_clock::now() > give_up)
                throw;
        }
        std::this_thread::sleep_for(kPause);
    }
}

std::string make_record(boxes::BoxCache& cache, const BoxKey& key) {
    try {
        const auto found = get_with_retries(cache, key);
        return found->air() ? record(key, 204, "") : record(key, 200, *found->frame);
    } catch (const boxes::OverloadedError& e) {
        return record(key, 503, e.what());
    } catch (const voxel::UnreachableError& e) {
        util::log_error("make box {} of a batch: {}", voxel::to_string(key), e.what());
        return record(key, 502, kUnreachable);
    } catch (const std::exception& e) {
        util::log_error("make box {} of a batch: {}", voxel::to_string(key), e.what());
        return record(key, 500, without_folders(e.what()));
    }
}

// Cached boxes are sent first, since they are ready. The rest is made by a few threads, which write
// under one lock.
void send_all(boxes::BoxCache& cache, const std::vector<BoxKey>& keys, const Write& write) {
    std::vector<BoxKey> missing;
    for (const BoxKey& key : keys) {
        const auto found = cache.find(key);
        if (!found)
            missing.push_back(key);
        else if (!write(found->air() ? record(key, 204, "") : record(key, 200, *found->frame)))
            return;
    }
    std::atomic<std::size_t> next{0};
    std::atomic<bool> gone{false};
    std::mutex writing;
    const auto lane = [&] {
        try {
            for (std::size_t i = next++; i < missing.size() && !gone; i = next++) {
                const std::string bytes = make_record(cache, missing[i]);
                const std::lock_guard lock(writing);
                if (!gone && !write(bytes))
                    gone = true;
            }
        } catch (...) {
            gone = true;  // no memory even to report it: the stream ends without its last record
        }
    };
    {
        std::vector<std::jthread> lanes;
        try {
            for (std::size_t i = 1; i < std::min(kLanes, missing.size()); ++i)
                lanes.emplace_back(lane);
        } catch (const std::system_error&) {
            // The system refuses more threads: fewer can make all of it, too.
        }
        lane();
    }
    // So that clients can detect a truncated stream.
    if (!gone)
        write(record({-1, static_cast<std::int32_t>(keys.size()), 0, 0}, 0, ""));
}

}  // namespace

Response answer_batch(Service& service, const RouteRequest& call) {
    const std::string type = call.request.header("Content-Type");
    if (!same_word(type.substr(0, type.find(';')), "application/json"))
        return problem(
            415, "read the list of boxes: Content-Type '" + type + "'; allowed: application/json");
    std::vector<BoxKey> keys;
    try {
        keys = list_keys(call.request.body, service.world.info().levels);
    } catch (const util::UsageError& e) {
        return problem(400, e.what());
    }
    Response out;
    out.add("Content-Type", kBatchMediaType).add("Cache-Control", "no-store");
    auto counted = std::make_shared<boxes::Slots::Permit>(batches());
    out.stream = [counted, keys = std::move(keys), &cache = service.boxes](const Write& write) {
        send_all(cache, keys, write);
    };
    return out;
}

namespace {

constexpr const char* kType = "application/vnd.terravox.archive";

Response no_file(int why) {
    switch (why) {
        case ENOENT:
        case ENOTDIR:
        case EISDIR: return problem(404, "the archive is gone");
        case EMFILE:
        case ENFILE:
        case ENOMEM:
            return problem(503, "the server has too many files open").add("Retry-After", "1");
        default: return problem(500, "the archive cannot be read");
    }
}

}  // namespace

Response answer_archive(const Service& service, const RouteRequest& call) {
    if (service.archive.empty())
        return problem(404, "the world of this server is no box archive of its machine");
    const std::optional<OpenFile> file = open_file(service.archive, true);
    if (!file)
        return no_file(errno);
    return file_reply(call.request, *file, to_etag(*file), kType);
}

}  // namespace terravox::http
