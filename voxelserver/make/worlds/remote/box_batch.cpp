#include "voxelserver/make/worlds/remote/box_batch.hpp"

#include "common/util/error.hpp"

namespace terravox::remote {
namespace {

[[noreturn]] void refuse(const std::string& what) {
    throw util::Error("read a batch of boxes: " + what);
}

}  // namespace

std::string batch_request(std::span<const voxel::BoxKey> keys) {
    std::string out = "{\"boxes\":[";
    for (const voxel::BoxKey& key : keys) {
        if (out.back() == ']')
            out += ',';
        out += '[' + std::to_string(key.level) + ',' + std::to_string(key.bx) + ',' +
               std::to_string(key.by) + ',' + std::to_string(key.bz) + ']';
    }
    return out + "]}";
}

std::uint32_t BatchStream::word(std::size_t at, std::size_t index) const noexcept {
    std::uint32_t value = 0;
    for (std::size_t byte = 0; byte < 4; ++byte)
        value |= std::to_integer<std::uint32_t>(m_bytes[at + index * 4 + byte]) << (8 * byte);
    return value;
}

void BatchStream::feed(std::span<const std::byte> part,
                       const std::function<void(const BatchRecord&)>& take) {
    m_bytes.insert(m_bytes.end(), part.begin(), part.end());
    std::size_t at = 0;
    while (m_bytes.size() - at >= kHead_bytes) {
        if (m_whole)
            break;
        const auto number = [&](std::size_t index) {
            return static_cast<std::int32_t>(word(at, index));
        };
        const std::size_t length = word(at, 5);
        // Checked before waiting for the data: the number is untrusted.
        if (length > m_max_payload_bytes)
            refuse("a record of " + std::to_string(length) + " bytes; allowed: up to " +
                   std::to_string(m_max_payload_bytes));
        if (m_bytes.size() - at - kHead_bytes < length)
            break;
        const BatchRecord record{{number(0), number(1), number(2), number(3)},
                                 word(at, 4),
                                 std::span(m_bytes).subspan(at + kHead_bytes, length)};
        at += kHead_bytes + length;
        if (record.key.level == -1) {
            last_record(record);
            continue;
        }
        if (++m_taken > m_requested)
            refuse("more than the " + std::to_string(m_requested) + " boxes that were requested");
        take(record);
    }
    m_bytes.erase(m_bytes.begin(), m_bytes.begin() + static_cast<std::ptrdiff_t>(at));
    if (m_whole && !m_bytes.empty())
        refuse("bytes after the last record");
}

void BatchStream::last_record(const BatchRecord& record) {
    if (record.status != 0 || !record.payload.empty() || record.key.bx < 0 ||
        static_cast<std::size_t>(record.key.bx) != m_requested || m_taken != m_requested)
        refuse("a last record after " + std::to_string(m_taken) + " boxes that states " +
               std::to_string(record.key.bx) + "; requested: " + std::to_string(m_requested));
    m_whole = true;
}

}  // namespace terravox::remote
