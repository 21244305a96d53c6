#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace terravox::luanti {

/// Decompresses the contents of map blocks, one after the other, into a buffer that is reused. Not
/// thread-safe: one for each thread.
class Unpacker {
public:
    /// Maximum size that one stream may decompress to. Its nodes take 16 KiB; the rest is the
    /// contents of chests, signs and books.
    static constexpr std::size_t kLimitBytes = std::size_t{16} << 20;

    Unpacker();
    ~Unpacker();
    Unpacker(const Unpacker&) = delete;
    Unpacker& operator=(const Unpacker&) = delete;

    struct Stream {
        std::span<const std::uint8_t> bytes;  ///< valid until the next call
        std::size_t packed_bytes = 0;         ///< how long the stream is; others may follow
    };
    /// The zlib stream with which `packed` begins.
    /// @throws Error
    [[nodiscard]] Stream zlib(std::span<const std::uint8_t> packed);
    /// The zstd frame with which `packed` begins.
    /// @return as Stream::bytes
    /// @throws Error
    [[nodiscard]] std::span<const std::uint8_t> zstd(std::span<const std::uint8_t> packed);

private:
    struct Contexts;
    std::unique_ptr<Contexts> m_contexts;
    std::vector<std::uint8_t> m_buffer;
};

}  // namespace terravox::luanti
