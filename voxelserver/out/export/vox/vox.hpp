#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "voxelserver/out/export/core/columns.hpp"
#include "voxelserver/out/export/core/format.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/shape/byte_file.hpp"
#include "voxelserver/out/export/vox/vox_palette.hpp"

namespace terravox::exports {

/// A voxel in the spool. Coordinates are the file's (x east, y north, z up), relative to its box.
struct SpooledVoxel {
    std::uint8_t x = 0;
    std::uint8_t y = 0;
    std::uint8_t z = 0;
    voxel::Material material = voxel::Material::kAir;
    voxel::Rgb8 colour;
    bool own = false;  ///< the colour is the voxel's own, else its material's
};
static_assert(sizeof(SpooledVoxel) == 8);

/// The visible voxels of one box.
struct SpooledBox {
    std::array<std::int32_t, 3> low{};         ///< of its coordinates, from the file's origin
    std::array<std::uint8_t, 3> min{}, max{};  ///< of its voxels, both inclusive
    std::uint64_t first = 0, count = 0;        ///< range of voxels of the spool
};

/// A model of the file: the boxes of up to 4 x 4 columns at one height.
struct VoxModel {
    std::vector<SpooledBox> boxes;
    std::array<std::int32_t, 3> min{}, size{};  ///< from the file's origin, tight
    std::uint64_t voxels = 0;
};

/// All visible voxels of a part, read once and kept on disk until the colours are chosen. Not
/// thread-safe.
class VoxSpool {
public:
    /// Reads the whole part.
    /// @param max_voxels limit beyond which it gives up
    /// @throws Error
    VoxSpool(Job& job, VoxPalette& palette, std::uint64_t max_voxels,
             const std::function<void()>& fail_too_many);
    [[nodiscard]] const std::vector<VoxModel>& models() const noexcept { return m_models; }
    /// Reads one box back, piece by piece.
    void each(const SpooledBox& box, const std::function<void(const SpooledVoxel&)>& use);

private:
    struct MadeBox {
        std::int32_t by = 0;
        SpooledBox box;
        std::vector<SpooledVoxel> voxels;
    };
    [[nodiscard]] static std::vector<MadeBox> make_column(Job& job, const Columns::At& at);
    void end_square();
    ByteFile m_file;
    std::uint64_t m_voxels = 0;
    /// Models of the square of columns in progress, by height.
    std::map<std::int32_t, VoxModel> m_square;
    std::vector<VoxModel> m_models;
};

struct VoxOptions {
    /// Maximum size of the file; never more than these 2 GiB, as its lengths are signed numbers of
    /// 32 bits.
    std::uint64_t max_bytes = 0x7FFF'FFFFu;
};

/// Writes MagicaVoxel's format, version 200: the visible voxels of a part, in models of up to 256
/// x 256 x 256 under a scene graph that places them; x east, y north, z up, from make_origin(part).
/// 255 colours, chosen for the whole part; water, glass and ice are _glass, lava and lamps _emit.
/// Reads the part once: voxels are spooled in the folder of the file (8 bytes each) until the
/// colours are chosen. The bytes do not depend on the number of threads. MagicaVoxel itself shows
/// no more than 2000 x 2000 x 1000 voxels: larger parts are written, with a warning.
/// @throws Error when nothing is visible, the file would become too large (then nothing is
/// written), or cannot be written
void write_vox(Job& job, const VoxOptions& options = {});

extern const Format kVoxFormat;

}  // namespace terravox::exports
