#include "common/voxel/box.hpp"

#include <xxhash.h>
#include <zstd.h>
#include <algorithm>
#include <cstring>

#include "common/util/error.hpp"

namespace terravox::voxel {
namespace {

// The 64-byte header before the arrays. All numbers little-endian (docs/formats/box.md).
struct BlobHeader {
    char magic[8];
    std::uint32_t version;
    std::int32_t level;
    std::int32_t bx;
    std::int32_t by;
    std::int32_t bz;
    std::uint32_t cell_count;
    std::uint32_t attr_count;
    std::uint32_t reserved[5];
    // XXH64 of the 56 preceding bytes, then of everything after the header, chained as the seed.
    std::uint64_t checksum;
};
static_assert(sizeof(BlobHeader) == 64);
static_assert(std::endian::native == std::endian::little,
              "the box format is mapped: a big-endian port needs a swap here");

constexpr char kMagic[8] = {'T', 'V', 'X', 'B', 'O', 'X', '\r', '\n'};
constexpr std::uint32_t kBoxVersion = 1;
// Roots, 16^3 cells and bricks of a box in which every cell has details.
constexpr std::uint32_t kMaxCells =
    Box::kRootCount + Box::kRootCount * 64 + Box::kRootCount * 64 * 64;
constexpr std::uint32_t kMaxAttrs = kBoxSizeX * kBoxSizeY * kBoxSizeZ;

std::uint64_t compute_checksum(const BlobHeader& header, const std::byte* payload,
                               std::size_t bytes) {
    return XXH64(payload, bytes, XXH64(&header, offsetof(BlobHeader, checksum), 0));
}

// Every `first` must refer to cells of the next level (or attributes) inside the arrays, so that no
// traversal can leave them.
bool indices_hold(std::span<const TreeCell> cells, std::size_t attr_count) {
    std::size_t begin = 0;
    std::size_t end = Box::kRootCount;
    for (int depth = 0; depth < 3; ++depth) {
        std::size_t children = 0;
        for (std::size_t i = begin; i < end; ++i) {
            if ((cells[i].detail & ~cells[i].mask) != 0)
                return false;
            const auto count = static_cast<std::size_t>(std::popcount(cells[i].detail));
            const std::size_t expected = (depth < 2 ? end : 0) + children;
            if (count != 0 && cells[i].first != expected)
                return false;
            children += count;
        }
        if (depth == 2)
            return end == cells.size() && children == attr_count;
        begin = end;
        end += children;
        if (end > cells.size())
            return false;
    }
    return false;
}

}  // namespace

std::size_t BoxKeyHash::operator()(const BoxKey& key) const noexcept {
    return static_cast<std::size_t>(morton_encode(key.bx, key.by, key.bz) ^
                                    (static_cast<std::uint64_t>(key.level) << 58));
}

std::string to_string(const BoxKey& key) {
    return std::to_string(key.level) + "/" + std::to_string(key.bx) + "/" + std::to_string(key.by) +
           "/" + std::to_string(key.bz);
}

std::shared_ptr<const Box> Box::from_arrays(const BoxKey& key, std::span<const TreeCell> cells,
                                            std::span<const VoxelAttr> attrs) {
    auto box = std::shared_ptr<Box>(new Box);
    box->m_key = key;
    box->m_blob_bytes = sizeof(BlobHeader) + cells.size_bytes() + attrs.size_bytes();
    box->m_blob.reset(new std::byte[box->m_blob_bytes]);
    std::byte* payload = box->m_blob.get() + sizeof(BlobHeader);
    std::memcpy(payload, cells.data(), cells.size_bytes());
    if (!attrs.empty())
        std::memcpy(payload + cells.size_bytes(), attrs.data(), attrs.size_bytes());
    BlobHeader header{};
    std::memcpy(header.magic, kMagic, sizeof kMagic);
    header.version = kBoxVersion;
    header.level = key.level;
    header.bx = key.bx;
    header.by = key.by;
    header.bz = key.bz;
    header.cell_count = static_cast<std::uint32_t>(cells.size());
    header.attr_count = static_cast<std::uint32_t>(attrs.size());
    header.checksum = compute_checksum(header, payload, box->m_blob_bytes - sizeof(BlobHeader));
    std::memcpy(box->m_blob.get(), &header, sizeof header);
    box->m_cells = {reinterpret_cast<const TreeCell*>(payload), cells.size()};
    box->m_attrs = {reinterpret_cast<const VoxelAttr*>(payload + cells.size_bytes()), attrs.size()};
    return box;
}

std::shared_ptr<const Box> Box::from_blob(std::span<const std::byte> blob,
                                          const std::string& origin) {
    const auto fail = [&](const std::string& what) {
        throw util::Error("read the box {}: {}", origin, what);
    };
    BlobHeader header;
    if (blob.size() < sizeof header)
        fail(std::to_string(blob.size()) + " bytes; at least " + std::to_string(sizeof header) +
             " are needed");
    std::memcpy(&header, blob.data(), sizeof header);
    if (std::memcmp(header.magic, kMagic, sizeof kMagic) != 0)
        fail("not in the box format (magic bytes differ)");
    if (header.version != kBoxVersion)
        fail("format version " + std::to_string(header.version) +
             "; allowed: " + std::to_string(kBoxVersion));
    if (header.level < 0 || header.level > kMaxLevel)
        fail("level " + std::to_string(header.level) + "; allowed: 0 to " +
             std::to_string(kMaxLevel));
    if (header.cell_count < kRootCount || header.cell_count > kMaxCells)
        fail(std::to_string(header.cell_count) + " cells; allowed: 4 to " +
             std::to_string(kMaxCells));
    if (header.attr_count > kMaxAttrs)
        fail(std::to_string(header.attr_count) + " voxels; allowed: 0 to " +
             std::to_string(kMaxAttrs));
    const std::size_t cell_bytes = std::size_t{header.cell_count} * sizeof(TreeCell);
    const std::size_t payload_bytes =
        cell_bytes + std::size_t{header.attr_count} * sizeof(VoxelAttr);
    if (blob.size() != sizeof header + payload_bytes)
        fail(std::to_string(blob.size()) + " bytes; its header promises " +
             std::to_string(sizeof header + payload_bytes));
    if (compute_checksum(header, blob.data() + sizeof header, payload_bytes) != header.checksum)
        fail("checksum differs: damaged");

    auto box = std::shared_ptr<Box>(new Box);
    box->m_key = {header.level, header.bx, header.by, header.bz};
    box->m_blob_bytes = blob.size();
    box->m_blob.reset(new std::byte[blob.size()]);
    std::memcpy(box->m_blob.get(), blob.data(), blob.size());
    const std::byte* payload = box->m_blob.get() + sizeof header;
    box->m_cells = {reinterpret_cast<const TreeCell*>(payload), header.cell_count};
    box->m_attrs = {reinterpret_cast<const VoxelAttr*>(payload + cell_bytes), header.attr_count};
    if (!indices_hold(box->m_cells, header.attr_count))
        fail("an index leads outside its arrays");
    return box;
}

std::uint64_t Box::checksum() const noexcept {
    BlobHeader header;
    std::memcpy(&header, m_blob.get(), sizeof header);
    return header.checksum;
}

bool Box::solid(int x, int y, int z) const noexcept {
    return voxel(x, y, z).has_value();
}

std::optional<VoxelAttr> Box::voxel(int x, int y, int z) const noexcept {
    const TreeCell* cell = &m_cells[static_cast<std::size_t>(y >> 6)];
    for (int shift = 4;; shift -= 2) {
        const int bit = child_bit(x >> shift, y >> shift, z >> shift);
        if ((cell->mask >> bit & 1) == 0)
            return std::nullopt;
        if ((cell->detail >> bit & 1) == 0)
            return VoxelAttr{};
        if (shift == 0)
            return m_attrs[cell->compute_index(bit)];
        cell = &m_cells[cell->compute_index(bit)];
    }
}

bool Box::hidden(int x, int y, int z) const noexcept {
    const TreeCell* cell = &m_cells[static_cast<std::size_t>(y >> 6)];
    for (int shift = 4;; shift -= 2) {
        const int bit = child_bit(x >> shift, y >> shift, z >> shift);
        if ((cell->detail >> bit & 1) == 0)
            return (cell->mask >> bit & 1) != 0;
        if (shift == 0)
            return false;
        cell = &m_cells[cell->compute_index(bit)];
    }
}

int Box::top() const noexcept {
    const auto highest_layer = [](std::uint64_t mask) {
        return (63 - std::countl_zero(mask)) / 16;
    };
    for (int root = kRootCount - 1; root >= 0; --root) {
        const TreeCell& top_cell = m_cells[static_cast<std::size_t>(root)];
        if (top_cell.mask == 0)
            continue;
        int best = 0;
        // The highest layer of cells contains the highest voxel, but not necessarily in a
        // particular cell: check each.
        const int layer = highest_layer(top_cell.mask);
        for (int bit = layer * 16; bit < layer * 16 + 16; ++bit) {
            if ((top_cell.mask >> bit & 1) == 0)
                continue;
            int y = root * 64 + layer * 16 + 16;
            if ((top_cell.detail >> bit & 1) != 0) {
                const TreeCell& middle = m_cells[top_cell.compute_index(bit)];
                const int brick_layer = highest_layer(middle.mask);
                y = 0;
                for (int b = brick_layer * 16; b < brick_layer * 16 + 16; ++b) {
                    if ((middle.mask >> b & 1) == 0)
                        continue;
                    int voxel_top = 4;
                    if ((middle.detail >> b & 1) != 0)
                        voxel_top = highest_layer(m_cells[middle.compute_index(b)].mask) + 1;
                    y = std::max(y, root * 64 + layer * 16 + brick_layer * 4 + voxel_top);
                }
            }
            best = std::max(best, y);
        }
        return best;
    }
    return 0;
}

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
        throw util::Error("compress the box {}: {}", to_string(box.key()), ZSTD_getErrorName(size));
    out.resize(size);
    return out;
}

std::shared_ptr<const Box> decompress_box(std::span<const std::byte> frame,
                                          const std::string& origin) {
    const unsigned long long claimed = ZSTD_getFrameContentSize(frame.data(), frame.size());
    if (claimed == ZSTD_CONTENTSIZE_ERROR || claimed == ZSTD_CONTENTSIZE_UNKNOWN)
        throw util::Error("read the box {}: not a zstd frame with a known size", origin);
    if (claimed > kMaxBytes)
        throw util::Error("read the box {}: claims {} bytes; allowed: up to {}", origin, claimed,
                          kMaxBytes);
    std::vector<std::byte> blob(static_cast<std::size_t>(claimed));
    const std::size_t size = ZSTD_decompress(blob.data(), blob.size(), frame.data(), frame.size());
    if (ZSTD_isError(size) != 0)
        throw util::Error("read the box {}: {}", origin, ZSTD_getErrorName(size));
    if (size != blob.size())
        throw util::Error("read the box {}: {} bytes; the frame promised {}", origin, size,
                          blob.size());
    return Box::from_blob(blob, origin);
}

}  // namespace terravox::voxel
