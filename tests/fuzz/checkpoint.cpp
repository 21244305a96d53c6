// Checkpoints: the file's head, its records, and the tiles in them, with checksums made right.
#include <fcntl.h>

#include "raytracer/farm/checkpoint/tile_journal.hpp"
#include "tests/fuzz/tile_bytes.hpp"

namespace terravox::fuzz {
namespace {

constexpr std::uint64_t kFileHead_bytes = 24;
constexpr std::uint64_t kTextBytesAt = 12;
constexpr std::uint64_t kTextChecksumAt = 16;
constexpr std::uint32_t kMarker = 0x9e01c57a;
constexpr std::uint64_t kCountAt = 12;
constexpr std::uint64_t kPayloadChecksumAt = 16;
constexpr std::uint64_t kChecksumAt = 24;
constexpr std::uint32_t kMaxCells = 64;
constexpr int kMaxTile_px = 64;

void put_checksums(Editable& file) {
    if (!file.holds(0, kFileHead_bytes))
        return;
    const auto text_bytes = file.get<std::uint32_t>(kTextBytesAt);
    if (!file.holds(kFileHead_bytes, text_bytes))
        return;
    const auto text = file.part(kFileHead_bytes, text_bytes);
    file.put(kTextChecksumAt, XXH3_64bits(text.data(), text.size()));
    for (std::uint64_t at = kFileHead_bytes + text_bytes;
         file.holds(at, farm::kRecordHead_bytes);) {
        const auto bytes = file.get<std::uint32_t>(at + kCountAt);
        const std::uint64_t payload_at = at + farm::kRecordHead_bytes;
        if (file.get<std::uint32_t>(at) != kMarker || !file.holds(payload_at, bytes)) {
            ++at;
            continue;
        }
        put_tile_checksum(file, payload_at, bytes);
        const auto payload = file.part(payload_at, bytes);
        file.put(at + kPayloadChecksumAt, XXH3_64bits(payload.data(), payload.size()));
        file.put(at + kChecksumAt, XXH3_64bits(file.part(at, kChecksumAt).data(), kChecksumAt));
        at = payload_at + bytes;
    }
}

}  // namespace

void run(Input input) {
    Editable file(input);
    put_checksums(file);
    const farm::TileJournal journal(
        farm::OpenFile(as_file(file.input(), "input.tiles"), O_RDONLY, "read"));
    (void)journal.what_is_damaged();
    (void)farm::PictureKey::from_json(journal.key().to_json(), "what was written");
    if (journal.key().grid.tile_px > kMaxTile_px)
        return;
    for (std::uint32_t cell = 0; cell < std::min(journal.key().grid.cells(), kMaxCells); ++cell)
        if (journal.at(cell).is_there())
            allow_errors([&] { (void)journal.tile(cell); });
}

}  // namespace terravox::fuzz
