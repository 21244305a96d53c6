#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/box.hpp"

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

}  // namespace terravox::remote
