// Finished tiles, as workers and checkpoints have them.
// The first byte defines how the others are used: an odd one as an encoded tile, an even one
// as a tile whose pixels are not compressed yet, so that mutations reach their values.
#include "tests/fuzz/tile_bytes.hpp"

namespace terravox::fuzz {
namespace {

/// A coordinator decodes only what it has leased.
constexpr std::uint64_t kMaxPixels = 64 * 64;

std::vector<std::uint8_t> with_packed_pixels(Input input) {
    const Editable head(input);
    std::size_t before = tile_head_bytes();
    if (!head.holds(0, before))
        return {input.begin(), input.end()};
    const auto holes = head.get<std::uint32_t>(kTileHolesAt);
    if (!head.holds(before, std::uint64_t{holes} * kTileHole_bytes))
        return {input.begin(), input.end()};
    before += holes * kTileHole_bytes;
    const Input pixels = input.subspan(before);
    std::vector<std::uint8_t> out(input.begin(),
                                  input.begin() + static_cast<std::ptrdiff_t>(before));
    std::vector<std::uint8_t> frame(ZSTD_compressBound(pixels.size()));
    const std::size_t bytes =
        ZSTD_compress(frame.data(), frame.size(), pixels.data(), pixels.size(), 1);
    expect(ZSTD_isError(bytes) == 0, "pixels can be compressed");
    out.insert(out.end(), frame.begin(), frame.begin() + static_cast<std::ptrdiff_t>(bytes));
    return out;
}

}  // namespace

void run(Input input) {
    if (input.empty())
        return;
    const bool encoded = (input[0] & 1) != 0;
    const Input rest = input.subspan(1);
    const std::vector<std::uint8_t> bytes =
        encoded ? std::vector<std::uint8_t>(rest.begin(), rest.end()) : with_packed_pixels(rest);
    Editable tile(bytes);
    put_tile_checksum(tile, 0, bytes.size());
    const tiles::TileHead head = tiles::read_tile_head(tile.bytes(), "the input");
    if (head.pixels > kMaxPixels)
        return;
    const tiles::TileResult result = tiles::decode_tile(tile.bytes(), "the input");
    expect(result.samples.size() == head.pixels, "a tile has as many pixels as its head says");
    const tiles::TileResult again =
        tiles::decode_tile(tiles::encode_tile(result), "what was written");
    expect(hash_of_pixels(again) == hash_of_pixels(result), "a tile comes back as it was written");
    expect(again.holes == result.holes, "holes come back as they were written");
}

}  // namespace terravox::fuzz
