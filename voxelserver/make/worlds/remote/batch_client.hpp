#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/util/stage_times.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/remote/retrying_client.hpp"

namespace terravox::remote {

/// Limit for a box as it is sent; the largest that the box format allows needs less.
inline constexpr std::size_t kMaxBox_bytes = std::size_t{64} << 20;

inline constexpr const char* kBatchMediaType = "application/vnd.terravox.boxes";

/// The JSON request that is sent to a voxel server to get these boxes (docs/formats/http.md:
/// Batch).
[[nodiscard]] std::string batch_request(std::span<const voxel::BoxKey> keys);

/// One box of a batch, as the server sent it. The payload is valid only during the callback.
struct BatchRecord {
    voxel::BoxKey key;
    /// 200: payload is a zstd frame; 204: air; otherwise payload is the reason why there is none.
    std::uint32_t status = 0;
    std::span<const std::byte> payload;
};

/// Reads the stream of records of a batch from parts of any size. Memory: one record and one part.
/// Not thread-safe.
class BatchStream {
public:
    /// @param requested how many boxes were requested from the server
    /// @param max_payload_bytes of a record
    BatchStream(std::size_t requested, std::size_t max_payload_bytes) noexcept
        : m_requested(requested), m_max_payload_bytes(max_payload_bytes) {}

    /// Calls take for each complete record except the last one, which only marks the end.
    /// @throws Error for what is not a batch: too long a record, too many, a last one with another
    /// count, bytes after it; what take throws
    void feed(std::span<const std::byte> part, const std::function<void(const BatchRecord&)>& take);
    /// Whether the last record was received: without it the stream was cut short.
    [[nodiscard]] bool whole() const noexcept { return m_whole; }

private:
    static constexpr std::size_t kHead_bytes = 24;
    [[nodiscard]] std::uint32_t word(std::size_t at, std::size_t index) const noexcept;
    void last_record(const BatchRecord& record);

    std::size_t m_requested;
    std::size_t m_max_payload_bytes;
    std::size_t m_taken = 0;
    std::vector<std::byte> m_bytes;  ///< starts at a record
    bool m_whole = false;
};

/// Requests many boxes from a voxel server in one request (docs/formats/http.md: Batch).
/// Thread-safe.
///
/// A batch is an optimization: boxes that it does not deliver are requested one by one, with the
/// timeout and the errors of RemoteWorld::box(). So a lost or damaged stream is retried only once,
/// and batches are suspended for a server that has no capacity for them, or does not support them.
class BatchClient {
public:
    /// Client and times must outlive it.
    /// @param timeout for one request; a quarter of it while no data arrives
    BatchClient(HttpClient& client, util::StageTimes& times, std::string server_url,
                std::chrono::milliseconds timeout)
        : m_client(client),
          m_times(times),
          m_url(std::move(server_url) + "/v2/boxes"),
          m_timeout(timeout) {}

    /// Passes the received boxes to `take` and removes them from `missing`; boxes and air only,
    /// failures stay. Ends soon after HttpClient::stop().
    void fetch(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);

private:
    void fetch_once(std::vector<voxel::BoxKey>& missing, const voxel::TakeBox& take);
    void check(const HttpReply& reply, const BatchStream& stream);
    [[nodiscard]] bool welcome() const noexcept {
        return m_client.now().time_since_epoch().count() >= m_from.load(std::memory_order_relaxed);
    }

    HttpClient& m_client;
    util::StageTimes& m_times;
    const std::string m_url;
    const std::chrono::milliseconds m_timeout;
    /// The time from which batches may be requested.
    std::atomic<Retry::Clock::rep> m_from{
        Retry::Clock::time_point::min().time_since_epoch().count()};
};

}  // namespace terravox::remote
