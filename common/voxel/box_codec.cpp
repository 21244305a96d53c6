#include "common/voxel/box_codec.hpp"

#include <zstd.h>

#include "common/util/error.hpp"

namespace terravox::voxel {
namespace {

// Size of a box with all cells in which every voxel has attributes: larger sizes are rejected,
// whatever a frame's header claims.
constexpr std::size_t kMaxBytes =
    64 + (4 + 4 * 64 + 4 * 64 * 64) * sizeof(TreeCell) +
    std::size_t{kBoxSizeX} * kBoxSizeY * kBoxSizeZ * sizeof(VoxelAttr);

}  // namespace

std::vector<std::byte> compress(const Box& box, int zstd_level) {
    const auto blob = box.blob();
    std::vector<std::byte> out(ZSTD_compressBound(blob.size()));
    const std::size_t size =
        ZSTD_compress(out.data(), out.size(), blob.data(), blob.size(), zstd_level);
    if (ZSTD_isError(size) != 0)
        throw util::Error("compress the box " + to_string(box.key()) + ": " +
                          ZSTD_getErrorName(size));
    out.resize(size);
    return out;
}

std::shared_ptr<const Box> decompress_box(std::span<const std::byte> frame,
                                          const std::string& origin) {
    const unsigned long long claimed = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (claimed == ZSTD_CONTENTSIZE_ERROR || claimed == ZSTD_CONTENTSIZE_UNKNOWN)
        throw util::Error("read the box " + origin + ": not a zstd frame with a known size");
    if (claimed > kMaxBytes)
        throw util::Error("read the box " + origin + ": claims " + std::to_string(claimed) +
                          " bytes; allowed: up to " + std::to_string(kMaxBytes));
    std::vector<std::byte> blob(static_cast<std::size_t>(claimed));
    const std::size_t size = ZSTD_decompress(blob.data(), blob.size(), frame.data(), frame.size());
    if (ZSTD_isError(size) != 0)
        throw util::Error("read the box " + origin + ": " + ZSTD_getErrorName(size));
    if (size != blob.size())
        throw util::Error("read the box " + origin + ": " + std::to_string(size) +
                          " bytes; the frame promised " + std::to_string(blob.size()));
    return Box::from_blob(blob, origin);
}

}  // namespace terravox::voxel
