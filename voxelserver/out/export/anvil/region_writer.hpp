#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace terravox::exports::anvil {

/// Compresses as the game does. Not thread-safe; the output depends on the input alone.
class Compressor {
public:
    Compressor();
    ~Compressor();
    Compressor(const Compressor&) = delete;
    Compressor& operator=(const Compressor&) = delete;
    [[nodiscard]] std::string zlib(std::string_view bytes);
    [[nodiscard]] std::string gzip(std::string_view bytes);

private:
    struct Impl;
    std::unique_ptr<Impl> m_impl;
};

/// A chunk as it goes into a region file.
struct PackedChunk {
    std::int32_t x = 0, z = 0;  ///< of the chunk
    std::string zlib;           ///< its NBT, compressed; never empty
};

/// Writes r.<rx>.<rz>.mca, whole or not at all; chunks that are too long for it go to c.<x>.<z>.mcc
/// next to it, written before.
/// @param chunks of this region, each place once; their order does not matter
/// @return bytes written
/// @throws Error when a file cannot be written
std::uint64_t write_region(const std::filesystem::path& folder, std::int32_t rx, std::int32_t rz,
                           std::vector<PackedChunk> chunks);

}  // namespace terravox::exports::anvil
