#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/util/error.hpp"

namespace terravox::minecraft {

/// Packed bytes are damaged, or unpack to more than the limit.
class InflateError : public util::Error {
public:
    using util::Error::Error;
};

/// How a chunk is packed: the number in a region file.
enum class Compression : std::uint8_t { kGzip = 1, kZlib = 2, kNone = 3, kLz4 = 4 };
/// "gzip", "zlib", "none", "lz4".
[[nodiscard]] const char* compression_name(Compression compression) noexcept;

/// From the first bytes, for files that stand alone: gzip, zlib, LZ4, else none.
[[nodiscard]] Compression guess_compression(std::span<const std::uint8_t> packed) noexcept;

/// Unpacks chunks, one after the other, into a buffer of its own that is reused. Not thread-safe:
/// one for each thread.
class Inflater {
public:
    /// Maximum size that a chunk may unpack to. The largest known ones are some MiB; the
    /// format has no limit.
    static constexpr std::size_t kLimitBytes = std::size_t{64} << 20;

    Inflater();
    ~Inflater();
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;

    /// @return the unpacked bytes, valid until the next call; or the given ones when they are not
    /// packed
    /// @throws InflateError
    [[nodiscard]] std::span<const std::uint8_t> unpack(Compression compression,
                                                       std::span<const std::uint8_t> packed);

private:
    struct Deflate;
    [[nodiscard]] std::span<const std::uint8_t> unpack_deflate(
        Compression compression, std::span<const std::uint8_t> packed);
    [[nodiscard]] std::span<const std::uint8_t> unpack_lz4(std::span<const std::uint8_t> packed);
    void reserve(std::size_t bytes, std::size_t keep);

    std::unique_ptr<Deflate> m_deflate;
    std::unique_ptr<std::uint8_t[]> m_buffer;
    std::size_t m_capacity = 0;
};

}  // namespace terravox::minecraft
