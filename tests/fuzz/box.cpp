// Boxes: a zstd frame as it comes over the wire, or the blob in it with its checksum made right.
#include <xxhash.h>

#include <algorithm>

#include "common/voxel/box.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {
namespace {

constexpr std::uint32_t kZstdMagic = 0xFD2FB528;
constexpr std::size_t kChecksumAt = 56;
constexpr std::size_t kHeader_bytes = 64;

std::shared_ptr<const voxel::Box> read(Input input) {
    Editable blob(input);
    if (blob.holds(0, 4) && blob.get<std::uint32_t>(0) == kZstdMagic)
        return voxel::decompress_box(blob.bytes(), "the input");
    if (blob.holds(0, kHeader_bytes)) {
        const std::uint64_t head = XXH64(blob.bytes().data(), kChecksumAt, 0);
        const auto payload = blob.bytes().subspan(kHeader_bytes);
        blob.put(kChecksumAt, XXH64(payload.data(), payload.size(), head));
    }
    return voxel::Box::from_blob(blob.bytes(), "the input");
}

}  // namespace

void run(Input input) {
    const auto box = read(input);
    // Every fifth column: each leads through all levels of the tree.
    int highest = 0;
    for (int z = 0; z < voxel::kBoxSizeZ; z += 5)
        for (int x = 0; x < voxel::kBoxSizeX; x += 5)
            for (int y = 0; y < voxel::kBoxSizeY; ++y)
                if (box->voxel(x, y, z))
                    highest = std::max(highest, y + 1);
    expect(highest <= box->top(), "no voxel lies above the highest");
    const auto again = voxel::decompress_box(voxel::compress(*box), "what was written");
    expect(again->checksum() == box->checksum(), "a box comes back as it was written");
}

}  // namespace terravox::fuzz
