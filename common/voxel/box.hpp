#pragma once

#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::voxel {

/// Interleaves three coordinates, x in the lowest bit of each triple, then y, then z. Each
/// coordinate is taken modulo 2^21 (so [-2^20, 2^20) is one to one); the result has 63 bits. The
/// result is the same on every CPU; uses BMI2 (pdep) where available.
/// Ref: Morton, "A computer oriented geodetic data base and a new technique in file sequencing",
/// IBM 1966.
[[nodiscard]] std::uint64_t morton_encode(std::int32_t x, std::int32_t y, std::int32_t z) noexcept;

/// The same with shifts and masks only: the reference for tests, and the implementation for CPUs
/// without BMI2.
[[nodiscard]] std::uint64_t morton_encode_portable(std::int32_t x, std::int32_t y,
                                                   std::int32_t z) noexcept;

struct MortonCoord {
    std::int32_t x, y, z;  ///< each in [-2^20, 2^20)
};
[[nodiscard]] MortonCoord morton_decode(std::uint64_t code) noexcept;

inline constexpr int kBoxSizeX = 64;
inline constexpr int kBoxSizeY = 256;
inline constexpr int kBoxSizeZ = 64;

/// Identifies a box: voxels of level n have 2^n times the base size; bx, by, bz count boxes of 64 x
/// 256 x 64 voxels of that level.
struct BoxKey {
    int level = 0;
    std::int32_t bx = 0;
    std::int32_t by = 0;
    std::int32_t bz = 0;
    friend auto operator<=>(const BoxKey&, const BoxKey&) = default;
};
/// The hash for every cache of boxes: the Morton code, with the level in bits that only boxes a
/// million boxes from the origin use.
struct BoxKeyHash {
    [[nodiscard]] std::size_t operator()(const BoxKey& key) const noexcept;
};
[[nodiscard]] std::string to_string(const BoxKey& key);  ///< "level/bx/by/bz"

inline constexpr int kMaxLevel = 20;

/// The attributes of one voxel. Eight bytes, stored as is in the box format.
struct VoxelAttr {
    static constexpr std::uint8_t kHasColour = 1;
    /// The colour is no measurement: it is one that is typical of the material, the same for a
    /// whole building or tree. Not set together with kHasColour.
    static constexpr std::uint8_t kTinted = 2;
    /// The material was guessed from the intensity of echoes or the shape of a roof, as no colour
    /// is known.
    static constexpr std::uint8_t kGuessed = 4;
    Material material = Material::kRock;
    std::uint8_t source_class = 0;  ///< class code of the survey (0-255), unchanged
    std::uint8_t flags = 0;
    std::uint8_t reserved = 0;
    Rgb8 colour;  ///< of the surface, sRGB; true with kHasColour, typical with kTinted
    std::uint8_t reserved_too = 0;

    [[nodiscard]] bool has_colour() const noexcept { return (flags & kHasColour) != 0; }
    [[nodiscard]] bool is_guessed() const noexcept { return (flags & kGuessed) != 0; }
    [[nodiscard]] bool is_tinted() const noexcept { return (flags & kTinted) != 0; }
    friend bool operator==(const VoxelAttr&, const VoxelAttr&) = default;
};
static_assert(sizeof(VoxelAttr) == 8);

/// One cell of the 64-tree: 4 x 4 x 4 children, bit = x + 4 z + 16 y.
///
/// `mask`: children that contain any solid voxel. `detail`, a subset of it: children with data of
/// their own, stored consecutively from index `first` in bit order (cells for the two upper levels,
/// VoxelAttr for bricks). A child in `mask` but not in `detail` is solid throughout and none of its
/// faces is visible: it is rock and takes no storage.
struct TreeCell {
    std::uint64_t mask = 0;
    std::uint64_t detail = 0;
    std::uint32_t first = 0;
    std::uint32_t reserved = 0;

    [[nodiscard]] std::uint32_t compute_index(int bit) const noexcept {
        return first +
               static_cast<std::uint32_t>(std::popcount(detail & ((std::uint64_t{1} << bit) - 1)));
    }
};
static_assert(sizeof(TreeCell) == 24);

/// A block of 64 x 256 x 64 voxels: four 64-trees of three levels, stacked vertically. Immutable,
/// so it is safe to share between threads. The bytes in memory are those of the box format: a box
/// is mapped, not parsed.
///
/// Ref: 64-trees of bit masks as in Museth, "NanoVDB", SIGGRAPH 2021 (bit masks, child by
/// popcount), with 4^3 fan-out throughout.
class Box {
public:
    static constexpr int kRootCount = kBoxSizeY / 64;

    /// Creates a box from a blob in the box format.
    /// @param origin names the blob in error messages
    /// @throws Error when the blob is invalid: wrong magic, version, checksum, size, or an index
    /// out of range
    static std::shared_ptr<const Box> from_blob(std::span<const std::byte> blob,
                                                const std::string& origin);

    /// Creates a box from finished arrays (BoxBuilder). The first kRootCount cells are the roots,
    /// bottom first.
    static std::shared_ptr<const Box> from_arrays(const BoxKey& key,
                                                  std::span<const TreeCell> cells,
                                                  std::span<const VoxelAttr> attrs);

    [[nodiscard]] const BoxKey& key() const noexcept { return m_key; }
    [[nodiscard]] std::span<const TreeCell> cells() const noexcept { return m_cells; }
    [[nodiscard]] std::span<const VoxelAttr> attrs() const noexcept { return m_attrs; }
    [[nodiscard]] std::span<const std::byte> blob() const noexcept {
        return {m_blob.get(), m_blob_bytes};
    }
    /// XXH64 of the payload, as in the blob's header.
    [[nodiscard]] std::uint64_t checksum() const noexcept;
    [[nodiscard]] std::size_t memory_bytes() const noexcept { return m_blob_bytes + sizeof(Box); }

    /// Local coordinates: x, z in [0, 64), y in [0, 256). Undefined outside of these ranges.
    [[nodiscard]] bool solid(int x, int y, int z) const noexcept;
    /// The voxel's attributes, nullopt for air. Hidden solid voxels are reported as plain rock.
    [[nodiscard]] std::optional<VoxelAttr> voxel(int x, int y, int z) const noexcept;
    /// Whether a voxel is solid and cannot be seen: its six neighbours, in other boxes too, are
    /// opaque.
    [[nodiscard]] bool hidden(int x, int y, int z) const noexcept;
    /// @return one past the highest solid y in [0, 256]; 0 when the box is empty
    [[nodiscard]] int top() const noexcept;

private:
    Box() = default;
    BoxKey m_key;
    std::unique_ptr<std::byte[]> m_blob;
    std::size_t m_blob_bytes = 0;
    std::span<const TreeCell> m_cells;
    std::span<const VoxelAttr> m_attrs;
};

/// Bit of a child in its TreeCell; only the two lowest bits of each coordinate are used.
[[nodiscard]] constexpr int child_bit(int x, int y, int z) noexcept {
    return (x & 3) | (z & 3) << 2 | (y & 3) << 4;
}

inline constexpr const char* kBoxMediaType = "application/vnd.terravox.box";

/// Compresses the box's blob to one zstd frame (docs/formats/box.md). The same box and level give
/// the same bytes on every machine.
[[nodiscard]] std::vector<std::byte> compress(const Box& box, int zstd_level = 1);

/// The inverse of compress(), for untrusted input.
/// @param origin names the box in error messages
/// @throws Error for a damaged or foreign frame, or one whose declared size exceeds that of any box
[[nodiscard]] std::shared_ptr<const Box> decompress_box(std::span<const std::byte> frame,
                                                        const std::string& origin);

}  // namespace terravox::voxel
